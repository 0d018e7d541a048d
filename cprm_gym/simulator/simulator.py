"""The soccer world: many matches at once, one cycle per call, every rule of server 19.

`Simulator` owns one array of `WORLD` records and one `PARAMETERS` record. Its methods check and allocate once; a step is one
call of a compiled kernel that changes the worlds in place.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import CommandError, ParameterError
from .kernels import audio, body, landmark_sight
from .kernels import senses as eye_kernels
from .kernels import step as kernels
from .kernels.powers import restart
from .kernels.random import draw_uniforms
from .packing import NO_REFEREE, pack
from .parameters import Rules, ServerParameters
from .player_types import PlayerParameters, PlayerType, TypeColumn, generate_types
from .senses import Hear, Landmarks, See, new_body, new_hear, new_landmarks, new_see
from .setup import draw_wind, initial_world, stream_keys
from .state import COMMAND, PLAYERS, WORLD, Seed, Stream, Worlds, chosen_worlds
from .trainer import Coach, Trainer

_HASHED = (
    "time",
    "stoppage",
    "mode",
    "kick_off_side",
    "ball_catcher",
    "score",
    "pen_score",
    "pen_miss",
    "half_count",
    "steps",
    "pos",
    "vel",
    "acc",
    "enabled",
    "goalie",
    "type",
    "card_count",
    "body",
    "neck",
    "stamina",
    "effort",
    "recovery",
    "capacity",
    "bits",
    "counts",
    "tackle_cycles",
    "foul_cycles",
    "catch_ban",
    "view_width",
    "arm_target",
    "arm_timer",
    "attention",
)


def no_commands(*shape: int) -> npt.NDArray[Any]:
    """An array of `COMMAND` records that say nothing.

    Parameters
    ----------
    *shape : int
        Shape of the array, for example ``(worlds, 22)``.
    """
    commands = np.zeros(shape, COMMAND)
    for name in ("a", "b", "c", "d", "turn_neck", "focus", "point"):
        commands[name] = np.nan
    return commands


class Simulator:
    """`worlds` matches of 2D soccer.

    Parameters
    ----------
    worlds : int
        How many.
    parameters : ServerParameters, optional
        Parameters of the server.
    player_parameters : PlayerParameters, optional
        How heterogeneous types are drawn.
    player_types : sequence of PlayerType, optional
        The types, 1 to 18; drawn from `player_parameters` (its ``random_seed``, or `seed` when that is negative) if not given.
    seed : int, SeedSequence or sequence of int
        World ``k`` has streams of its own for physics, sensors, referee and resets: spawned from the seed, or from the ``k``-th
        of `worlds` seeds. Equal seeds and commands give equal worlds, bit for bit, whatever `worlds` and `threads` are.
    rules : Rules
        Modules of the referee.
    threads : int
        Threads that share the worlds of one step.
    left, right : int
        Players per team, 0 to 11, with uniform numbers from 1.
    goalies : pair of int
        Uniform numbers of the goalies, 0 for none.
    first_world : int
        Number of world 0 among those of the seed: ``Simulator(1, seed=s, first_world=k)`` is world ``k`` of a batch, bit for bit.

    Raises
    ------
    ParameterError
        When an argument is out of range; the message names it.

    Attributes
    ----------
    world : (W,) array of WORLD
        The state; the simulator's own array, changed in place by every step and free to be changed by its user.
    commands : (W, 22) array of COMMAND
        Buffer for the commands of the next `step`.
    types : tuple of PlayerType
        The types of this match.
    trainer : Trainer
        Places ball and players, changes the mode, kicks off.
    coach : Coach
        Exchanges players within the rules.
    team_names : tuple of two str
        What messages and logs call the left and the right team; free to be changed.
    told : bool
        Whether the senses are what messages of a server told, not what follows from `world`.
    refereed : bool
        Whether any rule is on; where none is, the step is compiled without the referee.
    played : (1,) array of PARAMETERS
        `packed` as the step takes it: of another type where nothing is refereed.
    """

    told = False

    def __init__(
        self,
        worlds: int = 1,
        parameters: ServerParameters | None = None,
        player_parameters: PlayerParameters | None = None,
        player_types: Sequence[PlayerType] | None = None,
        seed: Seed = 0,
        rules: Rules = Rules.ALL,
        threads: int = 1,
        left: int = 11,
        right: int = 11,
        goalies: tuple[int, int] = (1, 1),
        first_world: int = 0,
    ) -> None:
        _check_whole("worlds", worlds, 1, 2**31)
        _check_whole("threads", threads, 1, 1024)
        _check_whole("first_world", first_world, 0, 2**31)
        self.parameters = ServerParameters() if parameters is None else parameters
        self.player_parameters = PlayerParameters() if player_parameters is None else player_parameters
        _check_is("parameters", self.parameters, ServerParameters)
        _check_is("player_parameters", self.player_parameters, PlayerParameters)
        drawn = self.player_parameters.random_seed
        self.types = tuple(
            player_types or generate_types(self.parameters, self.player_parameters, drawn if drawn >= 0 else _first_word(seed))
        )
        for number, kind in enumerate(self.types):
            _check_is(f"player_types[{number}]", kind, PlayerType)
        _check_whole("rules", rules, Rules.NONE, Rules.ALL)
        self.rules = Rules(rules)
        self.team_names: tuple[str, str] = ("Left", "Right")
        self.packed = pack(self.parameters, self.player_parameters, self.types, self.rules)
        self._start = initial_world(self.packed, left, right, goalies).reshape(1)
        if not self.parameters.wind_random:
            draw_wind(self._start, self.parameters, np.zeros(1, np.int64))
        self.world: npt.NDArray[Any] = np.zeros(worlds, WORLD)
        self.trainer, self.coach = Trainer(self.world, self.played), Coach(self.world, self.packed)
        self._silence = no_commands(worlds, PLAYERS)
        self.commands: npt.NDArray[Any] = self._silence.copy()
        self._one = no_commands(1)
        self._every = np.arange(worlds)
        self.first_world = first_world
        self._see: See | None = None
        self._body: npt.NDArray[Any] | None = None
        self._hear: Hear | None = None
        self._landmarks: Landmarks | None = None
        self.threads = threads
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None
        self.reset(seed)

    @property
    def worlds(self) -> int:
        """The number of worlds."""
        return len(self.world)

    # ------------------------------------------------------------------------------------------ time

    def step(self, commands: npt.NDArray[Any] | None = None) -> None:
        """Execute every player's commands, in an order drawn anew for each world and cycle, then run one step.

        Parameters
        ----------
        commands : (W, 22) array of COMMAND, optional
            The buffer `commands` when not given. It is not cleared; see `clear_commands`.

        Raises
        ------
        CommandError
            When `commands` is not such an array.
        """
        given = self.commands if commands is None else self._checked_commands(commands)
        self._run(kernels.step_worlds, given, parameters=self.played)

    def advance(self) -> None:
        """Run one step; commands given by `command_phase` since the last one have been executed already."""
        self._run(kernels.advance_worlds, parameters=self.played)

    def command_phase(self, world: int, player: int, command: Any) -> None:
        """Execute one command at once, as the server does when it receives it; `advance` then runs the step.

        Parameters
        ----------
        world : int
            Index of the world.
        player : int
            Object number 1 to 22 of the player.
        command : COMMAND record
            What he sends.

        Raises
        ------
        CommandError
            When there is no such world or player, or `command` is not a record.
        """
        _check_index("world", world, 0, self.worlds - 1)
        _check_index("player", player, 1, PLAYERS)
        if getattr(command, "dtype", None) != COMMAND or np.size(command) != 1:
            raise CommandError(f"`command` takes one record of dtype COMMAND, got {_named(command)}")
        self._one[0] = np.reshape(command, ())[()]
        kernels.command_world(self.world, self.played, world, player - 1, self._one, 0)

    def clear_commands(self) -> None:
        """Make the buffer `commands` say nothing."""
        self.commands.view("u1")[...] = self._silence.view("u1")

    @property
    def packed(self) -> npt.NDArray[Any]:
        """The parameters as kernels read them; others may be put in their place for some steps."""
        return self._packed

    @packed.setter
    def packed(self, packed: npt.NDArray[Any]) -> None:
        self._packed = packed
        self.refereed = bool(packed["rules"][0]) or self.parameters.auto_mode
        self.played = packed if self.refereed else packed.view(NO_REFEREE)

    # ------------------------------------------------------------------------------------------ senses

    def see(self, out: See | None = None, worlds: npt.NDArray[np.int64] | None = None) -> See:
        """Ball and players as every player sees them; rows of players without a message in this cycle are zero.

        Parameters
        ----------
        out : See, optional
            Buffers to fill, made by `senses.new_see`; the simulator's own, overwritten by the next call, when not given.
        worlds : (n,) int64 array, optional
            Which worlds; all when not given. Row k of the buffers, of which there may be more than n, is world ``worlds[k]``.
        """
        if out is None:
            out = self._see = self._see or new_see(self.worlds)
        self._look(eye_kernels.see_worlds, worlds, *out)
        return out

    def sense_body(self, out: npt.NDArray[Any] | None = None, worlds: npt.NDArray[np.int64] | None = None) -> npt.NDArray[Any]:
        """What every player is told of himself, (W, 22, columns) with columns `senses.BodyColumn`; arguments as for `see`."""
        if out is None:
            if self._body is None:
                self._body = new_body(self.worlds)
            out = self._body
        self._look(body.sense_bodies, worlds, out)
        return out

    def hear(self, out: Hear | None = None, worlds: npt.NDArray[np.int64] | None = None) -> Hear:
        """What every player heard after the last step; arguments as for `see`."""
        if out is None:
            out = self._hear = self._hear or new_hear(self.worlds)
        self._look(audio.hear_worlds, worlds, *out)
        return out

    def landmarks(self, out: Landmarks | None = None, worlds: npt.NDArray[np.int64] | None = None) -> Landmarks:
        """Landmarks and lines as every player sees them, computed only when asked for; arguments as for `see`."""
        if out is None:
            out = self._landmarks = self._landmarks or new_landmarks(self.worlds)
        self._look(landmark_sight.landmarks_of_worlds, worlds, *out)
        return out

    def _look(self, kernel: Any, worlds: npt.NDArray[np.int64] | None, *out: Any) -> None:
        """Call a kernel of a sense for the given worlds, or all."""
        worlds = self._every if worlds is None else worlds
        self._run(kernel, worlds, *out, count=len(worlds))

    def _bytes(self) -> npt.NDArray[np.uint8]:
        """The worlds as rows of bytes: much faster to copy than records field by field."""
        return self.world.view("u1").reshape(self.worlds, -1)

    def _run(self, kernel: Any, *arguments: Any, parameters: npt.NDArray[Any] | None = None, count: int = 0) -> None:
        """Call a kernel over ranges of worlds (`count` of them, or all), one range per thread."""
        parameters = self.packed if parameters is None else parameters
        count = count or self.worlds
        kernel = getattr(kernel, "entry", kernel)  # without a Python call in between; made here, once, not by several threads
        if self._pool is None or count == 1:
            kernel(self.world, parameters, *arguments, 0, count)
            return
        bounds = np.linspace(0, count, min(self.threads, count) + 1).astype(int).tolist()
        tasks = [self._pool.submit(partial(kernel, self.world, parameters, *arguments, start, stop)) for start, stop in pairwise(bounds)]
        for task in tasks:
            task.result()

    # ------------------------------------------------------------------------------------------ beginnings and copies

    def reset(self, seed: Seed | None = None, worlds: Worlds = None) -> None:
        """Put worlds into the state before kick-off: clock 0, everybody at home beside the pitch.

        Parameters
        ----------
        seed : int, SeedSequence or sequence of int, optional
            New streams; without one the worlds keep theirs and go on drawing where they are.
        worlds : int, indices, slice or mask, optional
            Which worlds; all when not given.

        Raises
        ------
        ParameterError
            When the seeds or worlds do not fit.
        """
        chosen = chosen_worlds(worlds, self.worlds)
        restart(self.world, self._bytes(), self._start.view("u1"), chosen)
        if seed is not None:
            self.world["key"][chosen] = stream_keys(seed, chosen, self.first_world)
            self.world["steps"][chosen] = self.world["draws"][chosen] = 0
        if self.parameters.wind_random:
            draw_wind(self.world, self.parameters, chosen)

    def uniforms(self, worlds: Worlds, count: int, stream: Stream = Stream.RESETS) -> npt.NDArray[np.float64]:
        """Numbers in [0, 1) from a stream of the chosen worlds, (n, count); each call gives new ones.

        Parameters
        ----------
        worlds : int, indices, slice, mask or None
            Which worlds.
        count : int
            Numbers per world.
        stream : Stream
            Whose luck it is; start positions take that of resets.
        """
        _check_whole("count", count, 0, 2**31)
        chosen = chosen_worlds(worlds, self.worlds)
        out = np.empty((len(chosen), count))
        draw_uniforms(self.world, chosen, int(stream), out)
        return out

    def kickable(self, player: int) -> npt.NDArray[np.bool_]:
        """(W,) whether the player, object number 1 to 22, can kick the ball (specification/simulator.md 3.6).

        Raises
        ------
        CommandError
            When there is no such player.
        """
        _check_index("player", player, 1, PLAYERS)
        reach = self.packed[0]["types"][self.world["type"][:, player - 1], TypeColumn.KICKABLE_SQUARED]
        gap = self.world["pos"][:, player] - self.world["pos"][:, 0]
        return np.asarray((self.world["enabled"][:, player - 1] > 0) & (gap[:, 0] ** 2 + gap[:, 1] ** 2 <= reach))

    def snapshot(self) -> npt.NDArray[Any]:
        """A copy of every world, for `restore`."""
        copy: npt.NDArray[Any] = self._bytes().copy().view(WORLD)[:, 0]
        return copy

    def restore(self, snapshot: npt.NDArray[Any], worlds: Worlds = None) -> None:
        """Go back to a snapshot.

        Parameters
        ----------
        snapshot : array of WORLD
            Made by `snapshot`; one record per chosen world, or a single one for all of them.
        worlds : int, indices, slice or mask, optional
            Which worlds; all when not given.

        Raises
        ------
        ParameterError
            When the snapshot does not fit.
        """
        chosen = chosen_worlds(worlds, self.worlds)
        if getattr(snapshot, "dtype", None) != WORLD or np.size(snapshot) not in (1, len(chosen)):
            raise ParameterError(f"`snapshot` takes 1 or {len(chosen)} records of dtype WORLD, got {_named(snapshot)}")
        records = np.ascontiguousarray(np.ravel(snapshot))
        self._bytes()[chosen] = records.view("u1").reshape(len(records), -1)

    def state_hash(self, worlds: Worlds = None) -> str:
        """SHA-256 of everything that has happened in the chosen worlds: clocks, mode, score, objects, players.

        Parameters
        ----------
        worlds : int, indices, slice or mask, optional
            Which worlds; all when not given.
        """
        chosen = chosen_worlds(worlds, self.worlds)
        digest = hashlib.sha256()
        for name in _HASHED:
            digest.update(name.encode() + np.ascontiguousarray(self.world[name][chosen]).tobytes())
        return digest.hexdigest()

    # ------------------------------------------------------------------------------------------ checks

    def _checked_commands(self, commands: Any) -> npt.NDArray[Any]:
        if not isinstance(commands, np.ndarray) or commands.dtype != COMMAND or commands.shape != (self.worlds, PLAYERS):
            raise CommandError(
                f"`commands` takes an array of dtype COMMAND and shape ({self.worlds}, {PLAYERS}), got {_named(commands)}; "
                "make one with `no_commands` or fill `Simulator.commands`"
            )
        return np.ascontiguousarray(commands)


def _named(thing: Any) -> str:
    """What `thing` is, for messages."""
    if isinstance(thing, np.ndarray):
        return f"an array of shape {thing.shape} and dtype {str(thing.dtype)[:40]}"
    return f"{type(thing).__name__} {str(thing)[:40]!r}"


def _check_whole(name: str, value: Any, low: int, high: int) -> None:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or not low <= value <= high:
        raise ParameterError(f"`{name}` takes a whole number from {low} to {high}, got {value!r}")


def _check_index(name: str, value: Any, low: int, high: int) -> None:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or not low <= value <= high:
        raise CommandError(f"`{name}` takes a number from {low} to {high}, got {value!r}")


def _check_is(name: str, value: Any, kind: type) -> None:
    if not isinstance(value, kind):
        raise ParameterError(f"`{name}` takes a {kind.__name__}, got {_named(value)}")


def _first_word(seed: Seed) -> int:
    """A seed of 31 bits for the player types."""
    if not isinstance(seed, np.random.SeedSequence):
        try:
            seed = np.random.SeedSequence(seed)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            raise ParameterError(f"`seed` takes whole numbers >= 0 or a SeedSequence, got {seed!r}") from None
    return int(seed.generate_state(1)[0]) & 0x7FFFFFFF
