"""Replaying a recorded scenario: every step from the recorded state, and every case freely from its beginning.

A step is loaded, given the recorded commands in the recorded order, run and compared. Draws that the recording tells (success of a tackle
or a stretched catch) are forced. If the outcome differs, the step is run again with other random streams: a draw that nobody recorded
must be able to come out as it did. What differs between the streams and never agrees with the record (a random angle of
two players at one place) is counted as left to chance; everything else must agree.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ..protocol.commands import PlayerCommand, command_record, parse_commands, parse_trainer, side_of_team
from ..state import BALL, LEFT, RIGHT, PlayerBit
from .clock import compare_late, set_asynchronous_clocks
from .envelope import calm, envelope, kick_noise
from .noisy import compare_noisy
from .recording import (
    COLLISIONS,
    KEYS,
    MODES,
    ROW,
    Recording,
    compare_arm,
    compare_state,
    hidden_of,
    load_extras,
    load_hidden,
    load_mode,
    load_objects,
    near_post,
    put_back,
    snapshot_copy,
    telling_bits,
)
from .report import Result
from .texts import Listener, compare_messages, said_by_referee
from .trainer import execute_trainer

Watch = Callable[[int, PlayerCommand, Any], None]
TRIES = 64
"""Streams tried before a step counts as different."""
FORCED = ("forced_tackle", "forced_catch", "forced_foul", "forced_card", "forced_pen_side", "forced_pen_taker")
"""Fields of a world that force draws."""
LOOSE, EXACT = 1e-9, 1e-12
"""Tolerance in general and near collisions, and of runs of random commands elsewhere."""


class Guess(NamedTuple):
    """What a try of a step supposes."""

    outcome: int
    """Of tackles and catches that are not told: 1 success, -1 failure, 0 drawn."""
    order: list[str]
    """In which the players' commands are executed."""
    force_fouls: bool
    """Whether fouls with several victims come out as told for every victim."""


@dataclass(slots=True)
class _Row:
    """One step of a recording with what belongs to it."""

    case: str
    step: dict[str, Any]
    exact: bool
    hidden_before: dict[str, list[Any]] = field(default_factory=dict)

    @property
    def cycle(self) -> int:
        return int(self.step["T"])


class ScenarioReplay:
    """Replays one recording.

    Parameters
    ----------
    recording : Recording
    result : Result
        Gets everything that is found.
    """

    def __init__(self, recording: Recording, result: Result) -> None:
        self.recording, self.result = recording, result
        self.simulator = recording.simulator()
        self.parameters = self.simulator.parameters
        self.names = self.simulator.team_names = team_names(recording)
        self.fields: list[str] = recording.header.get("hid_fields", [])
        self.exact = recording.scenario.startswith("monkey")
        self.noisy = bool(self.parameters.ball_rand or self.parameters.player_rand)
        self._calm = calm(self.simulator.packed)
        self.listener = Listener(recording)
        self._keys = np.random.SeedSequence(20240607).generate_state(4 * TRIES, np.uint64).reshape(TRIES, 4)
        self._last: dict[str, Any] | None = None
        self._late: list[tuple[str, str, Any, Any]] = []
        set_asynchronous_clocks(self.simulator, recording)
        self._started = False

    @property
    def world(self) -> Any:
        """The one world, a record that can be read and written."""
        return self.simulator.world[0]

    # --- cases

    def run(self) -> None:
        """Every case step by step, then freely from its beginning, if its physics leaves nothing to chance."""
        for case in _cases(self.recording):
            self.begin(case)
            start, last, listener = snapshot_copy(self.simulator), self._last, self.listener.copy()
            lucky = self.result.chance
            self.run_steps(case, free=False)
            if not self.noisy and not self.exact and self.result.chance == lucky:
                end, end_last, end_listener = snapshot_copy(self.simulator), self._last, self.listener
                put_back(self.simulator, start)
                self._last, self.listener = last, listener
                self.run_steps(case, free=True)
                put_back(self.simulator, end)
                self._last, self.listener = end_last, end_listener

    def begin(self, case: dict[str, Any]) -> None:
        """Set a case up: the trainer's work, then exactly the recorded initial state."""
        world, first = self.world, case["steps"][0]
        self.listener.begin(case)
        init = completed(case)
        if self._started:
            self._idle(case["t0"], first)
        else:
            name = init.get("pm") or case.get("change_mode") or first["state"]["pm"]
            if first.get("trainer") and not init.get("pm"):
                name = "before_kick_off"
            world["mode"] = MODES[name]
            world["kick_off_side"] = LEFT
            world["kick_cycles"] = world["dash_cycles"] = -1  # steps have been before the recording
            self._started = True
        for row, key in enumerate(KEYS):
            if key in init["pl"]:
                world["body_staged"][row] = world["body"][row]
        world["time"], world["stoppage"] = case["t0"], 0
        load_objects(world, init)
        world["collided"], world["ball_catcher"] = 0, 0  # the trainer has placed the ball
        if case.get("recover"):
            self.simulator.trainer.recover()
        load_objects(world, init)
        if "ex" in init:
            load_extras(world, init, self.parameters.point_to_duration)
        if case.get("change_mode"):
            self.simulator.trainer.change_mode(case["change_mode"])
            load_objects(world, init)
        world["announced"] = 0
        if "init_hid" in case:
            for key, values in case["init_hid"].items():
                load_hidden(world, ROW[key], self.fields, values, self.parameters.point_to_duration)
        self._last = None

    def _idle(self, until: int, first: dict[str, Any]) -> None:
        """Let the cycles between two cases pass, in which nobody did anything that was recorded."""
        gap = until - int(self.world["time"])
        if gap > 0:
            self.listener.forget()
            if self._last is not None:
                load_objects(self.world, self._last)
        for _ in range(max(gap, 0)):
            self.simulator.advance()
        if gap > 0:
            self._unlock(first)

    def _unlock(self, first: dict[str, Any]) -> None:
        """Free players who, in the state after the next step, are not frozen any more: more cycles passed while the clock stood."""
        world = self.world
        for key in first.get("state", {}).get("pl", {}):
            if "t" not in first["state"].get("ex", {}).get(key, {}).get("st", ""):
                world["tackle_cycles"][ROW[key]], world["busy"][ROW[key]] = 0, 0

    def run_steps(self, case: dict[str, Any], free: bool) -> None:
        """Run the steps of a case, each from the recorded state before it or from the own one."""
        hidden, failed = case.get("init_hid", {}), self.result.failed
        for step in case["steps"]:
            row = _Row(f"{case['case']} step {step['i']}{' (free)' if free else ''}", step, self.exact, hidden)
            # a free run that went wrong goes on from the recorded state, so that one error is one mismatch
            if self._last is not None and (not free or self.result.failed > failed):
                self._load(self._last, hidden)
            failed = self.result.failed
            first = step is case["steps"][0]
            if first and (case.get("loads_first") or (self.exact and step.get("trainer") == ["(start)"])):
                self._skip(row)  # the kick-off draws types and places: nothing to compare, everything to load
            elif self.noisy:
                self._run_noisy_step(row)
            else:
                self._run_step(row)
            hidden = step.get("hid", {})
            self._last = step.get("state")
            if self._last is not None and "aux" in step:
                self._load_aux(step)

    def _load(self, state: dict[str, Any], hidden: dict[str, list[Any]]) -> None:
        """Overwrite what is visible with the recorded state; the rest is carried along."""
        world = self.world
        arms = world["arm_target"].copy()
        load_objects(world, state)
        load_mode(world, state)
        load_extras(world, state, self.parameters.point_to_duration)
        close = np.abs(world["arm_target"] - arms).max(axis=1) < 1e-7
        world["arm_target"][close] = arms[close]
        world["time"] = state["t"]
        for key, values in hidden.items():
            load_hidden(world, ROW[key], self.fields, values, self.parameters.point_to_duration)

    def _load_aux(self, step: dict[str, Any]) -> None:
        """Overwrite the hidden state that a run of random commands records after its step."""
        world, aux = self.world, step["aux"]
        if "stop" in aux:
            world["stoppage"] = aux["stop"]
        for name in ("catch_ban", "moves_since_catch"):
            for key, value in aux.get(name, {}).items():
                world[name][ROW[key]] = value

    def _skip(self, row: _Row) -> None:
        """Run a step and load its outcome without comparing it."""
        self._perform(row)
        self._load(row.step["state"], row.step.get("hid", {}))

    # --- one step

    def _run_step(self, row: _Row) -> None:
        before = snapshot_copy(self.simulator)
        key = before["key"][0].copy()
        best: tuple[int, Result, Any] | None = None
        worlds: list[Any] = []
        for number, guess in enumerate(self._guesses(row.step)):
            if number:
                put_back(self.simulator, before)
                self.world["key"] = self._keys[number]
            found = Result("", "")
            self._perform(row, guess)
            self._compare(row, found, frozenset())
            if best is None or found.failed < best[0]:
                best = found.failed, found, snapshot_copy(self.simulator)
            if not found.failed:
                break
            worlds.append(snapshot_copy(self.simulator))
            if number == 3 and not _differing(worlds):
                break  # nothing is drawn here
        assert best is not None
        failed, found, after = best
        put_back(self.simulator, after)
        if failed and (chance := _differing(worlds)):
            self.result.chance += len(chance)
            names = ", ".join(name_of(number) for number in sorted(chance))
            self.result.notes.append(f"left to chance in {row.case}, cycle {row.cycle}: {names}")
            found = Result("", "")
            self._compare(row, found, chance)
        self.world["key"] = key
        self.listener.advance(row.step)
        self.result.cycles += 1
        merge(self.result, found)

    def _run_noisy_step(self, row: _Row) -> None:
        """Run a step without noise and see whether the recorded one lies around it."""
        before = self.world.copy()
        noise, packed = 0.0, self.simulator.packed
        self.simulator.packed = self._calm

        def heed(index: int, command: PlayerCommand, earlier: Any) -> None:
            nonlocal noise
            if command.name in ("kick", "tackle"):
                noise += kick_noise(packed[0], earlier, self.world, index, command)

        middle = self._perform(row, watch=heed)
        self.simulator.packed = packed
        bounds = envelope(packed[0], before, middle, self.world, noise)
        maybe = frozenset(range(23)) if self.listener.first_step else marked(middle["bits"])
        compare_noisy(self.result, row.case, row.cycle, self.world, row.step, bounds, self.parameters.goal_width, maybe)
        self.result.cycles += 1
        self.listener.advance(row.step)

    def _guesses(self, step: dict[str, Any]) -> Iterator[Guess]:
        """What may have happened that the recording does not tell.

        First what it tells and nothing else; then each outcome of untold tackles and catches; then other orders of the players' commands
        and other draws of fouls with several victims. Every try also draws anew.
        """
        commands = list(step.get("cmd") or {})
        order = step.get("order") or commands
        yield Guess(0, order, True)
        texts = (step.get("cmd") or {}).values()
        if "random_possible" not in step and any("(tackle" in text or "(catch" in text for text in texts):
            yield Guess(1, order, True)
            yield Guess(-1, order, True)
        shuffles = np.random.default_rng(7)
        for number in range(TRIES - 3):
            mixed = [commands[index] for index in shuffles.permutation(len(commands))]
            yield Guess(0, order if "order" in step or number % 2 else mixed, False)

    def _perform(self, row: _Row, guess: Guess | None = None, watch: Watch | None = None) -> Any:
        """Trainer, commands in order, step; returns the world between commands and step if it is watched."""
        simulator, world, step = self.simulator, self.world, row.step
        world["announced"], world["announced_done"] = 0, 0
        for text in step.get("trainer") or ():
            execute_trainer(simulator, parse_trainer(text), self.names)
        if "pre" in step:
            load_objects(world, step["pre"])
        commands = step.get("cmd") or {}
        guess = guess or Guess(0, step.get("order") or list(commands), True)
        world["forced_tackle"] = world["forced_catch"] = guess.outcome
        self._force(step, guess.force_fouls)
        for player in guess.order:
            self._command(player, commands.get(player, ""), watch)
        middle = world.copy() if watch else None
        if watch:
            world["bits"] &= np.uint32(~COLLISIONS & 0xFFFFFFFF)  # from here on they tell of the step
        self._late = compare_late(simulator, step)
        simulator.advance()
        for name in FORCED:
            world[name] = 0
        return middle

    def _force(self, step: dict[str, Any], fouls: bool) -> None:
        """Force the draws that the recording tells; a foul with several victims is one draw for each, of which only the sum is told."""
        world = self.world
        world["forced_pen_side"], world["forced_pen_taker"] = drawn_shoot_out(self.listener.announcements(step) or ())
        for event in step.get("random_possible") or ():
            row = ROW[event["p"]]
            if event["e"] == "tackle":
                world["forced_tackle"][row] = 1 if event["ok"] else -1
            elif event["e"] == "catch_stretch":
                world["forced_catch"][row] = 1 if event["ok"] else -1
            elif event["e"] == "foul" and (fouls or len(event["near"]) < 2):
                world["forced_foul"][row] = 1 if event["outcome"] else -1

    def _command(self, player: str, text: str, watch: Watch | None) -> None:
        """Execute the commands of one player's datagrams."""
        row, world = ROW[player], self.world
        side = LEFT if player[0] == "l" else RIGHT
        for command in parse_commands(text).commands:
            record = command_record(command, side, self.names)
            if record is not None:
                earlier = world.copy() if watch else None
                self.simulator.command_phase(0, row + 1, record)
                if watch:
                    watch(row, command, earlier)
            elif command.name == "synch_see":
                world["synchronous"][row], world["view_quality"][row] = 1, 1
            elif command.name == "gaussian_see":
                world["gaussian"][row] = 1
            elif command.name == "ear":
                set_ear(world, row, side, command.args, self.names)

    # --- comparison

    def _compare(self, row: _Row, result: Result, skip: frozenset[int]) -> None:
        world, step = self.world, row.step
        self.listener.adopt(self.simulator, step)
        if "state" in step:
            state = step["state"]
            compare_state(result, row.case, row.cycle, world, state, self._tolerance(row), skip)
            for key in state["pl"]:
                if ROW[key] + 1 not in skip:
                    extra, duration = state.get("ex", {}).get(key, {}), self.parameters.point_to_duration
                    compare_arm(result, row.case, row.cycle, key, extra, world, ROW[key], duration)
        for key, values in (step.get("hid") or {}).items():
            if ROW[key] + 1 not in skip:
                got = hidden_of(world, ROW[key], self.fields, self.parameters.point_to_ban, self.parameters.point_to_duration)
                for name, told, own in zip(self.fields, values, got):
                    if name == "collision" and self.listener.first_step and own in ("", told):
                        continue  # told of the placements before it too
                    result.equal(row.case, row.cycle, key, name, told, own)
        self._compare_aux(row, result)
        for key, quantity, told, own in () if skip else self._late:
            result.equal(row.case, row.cycle, key, quantity, told, own)
        if not skip:
            expected, said = self.listener.announcements(step), said_by_referee(self.simulator)
            if expected is not None:
                result.equal(row.case, row.cycle, "referee", "announcements", expected, said)
        compare_messages(result, row.case, row.cycle, self.simulator, step, self.listener, skip)

        for key, text in (step.get("cmd") or {}).items():
            told = [text for name in ("msgs", "msgs_inphase") for text in (step.get(name) or {}).get(key, ())]
            if told:
                refused = parse_commands(text).error is not None
                result.equal(row.case, row.cycle, key, "refused command", "(error illegal_command_form)" in told, refused)

    def _compare_aux(self, row: _Row, result: Result) -> None:
        """Compare what runs of random commands tell besides: stoppage, dashes, the goalies' counters, state bits."""
        world, aux = self.world, row.step.get("aux")
        if not aux:
            return
        for name in ("catch_ban", "moves_since_catch"):
            for key, value in aux.get(name, {}).items():
                result.equal(row.case, row.cycle, key, name, value, int(world[name][ROW[key]]))
        flags = row.step.get("flags", {})
        for index, key in enumerate(KEYS):
            if world["enabled"][index]:
                told, own = int(flags.get(key, "0"), 16), int(world["bits_shown"][index])
                if self.listener.first_step:  # told of the placements before it too
                    told, own = told & ~COLLISIONS, own & ~COLLISIONS
                result.equal(row.case, row.cycle, key, "state bits", hex(telling_bits(told)), hex(telling_bits(own)))
        result.equal(row.case, row.cycle, "game", "stoppage", aux["stop"], int(world["stoppage"]))
        dashed = [key for index, key in enumerate(KEYS) if world["enabled"][index] and world["dash_cycles"][index] >= 0]
        result.equal(row.case, row.cycle, "game", "dashed", sorted(aux["dashed"]), sorted(dashed))

    def _tolerance(self, row: _Row) -> Any:
        """Tolerance of an object: loose where the server itself displaces by arbitrary 1e-10."""
        if not row.exact:
            return lambda number: LOOSE
        hidden, state = row.step.get("hid", {}), row.step["state"]
        fields = self.fields
        column = fields.index("collision") if "collision" in fields else -1
        touched = {ROW[key] + 1 for key, values in hidden.items() if column >= 0 and values[column]}
        if any("b" in hidden[KEYS[number - 1]][column] for number in touched):
            touched.add(BALL)
        width = self.parameters.goal_width
        for key, values in state["pl"].items():
            if near_post(values[1:3], 2.0, width):
                touched.add(ROW[key] + 1)
        if near_post(state["ball"], 4.0, width):
            touched.add(BALL)
        return lambda number: LOOSE if number in touched else EXACT


def drawn_shoot_out(announced: Iterable[str]) -> tuple[int, int]:
    """The goal of a shoot-out and the side drawn with it (+1 left, -1 right), by what the referee said when it began; 0 when he did not.

    The first kick is that of the other side.
    """
    for earlier, later in itertools.pairwise(announced):
        if " penalty_onfield_" in earlier and " penalty_setup_" in later:
            return LEFT if earlier.endswith("_l)") else RIGHT, RIGHT if later.endswith("_l)") else LEFT
    return 0, 0


def completed(case: dict[str, Any]) -> dict[str, Any]:
    """The initial state of a case, with what the recording leaves open taken from the state after its first step.

    Between cases the recording's trainer parks players without listing it: some are missing, others have the angle they had before. A
    player who is not placed and sends nothing neither moves nor turns in the first step.
    """
    init, first = case["init"], case["steps"][0]
    placed = {values[0] for values in case.get("setup", ())}
    # what the recording's own "recover" left is known better than the effort of a type that was changed meanwhile
    rested = [None] * 4 if case.get("recover") else None
    players = {key: values[:7] + (rested or values[7:]) for key, values in init["pl"].items()}
    for key, after in first.get("state", {}).get("pl", {}).items():
        if key not in players:
            players[key] = after[:7] + (rested or after[7:])
        elif not first.get("trainer"):
            players[key] = [after[0], *players[key][1:]]
        if key not in placed and key not in (first.get("cmd") or {}):
            players[key] = players[key][:5] + after[5:7] + players[key][7:]
    return {**init, "pl": players}


def name_of(number: int) -> str:
    """``ball`` or the player's key of an object number."""
    return "ball" if number == BALL else KEYS[number - 1]


def team_names(recording: Recording) -> tuple[str, str]:
    """The teams' names, as far as the recording tells."""
    left, right = recording.header.get("team_names", ("L", "R"))
    return str(left), str(right)


def set_ear(world: Any, row: int, side: int, args: tuple[Any, ...], names: tuple[str, str]) -> None:
    """Execute ``(ear ...)``: on or off, whose speech, which form; what is not said means both."""
    on, team, mode = args
    bits = {None: 3, "complete": 1, "partial": 2}[mode]
    if team is None:
        columns = [0, 1]
    else:
        whose = side_of_team(team, side, names)
        if whose is None:
            return
        columns = [0 if whose == side else 1]
    for column in columns:
        old = int(world["ear"][row, column])
        world["ear"][row, column] = old | bits if on else old & ~bits


def merge(result: Result, found: Result) -> None:
    """Add what one step found to the file's result."""
    result.compared += found.compared
    for name, count in found.counts.items():
        result.counts[name] = result.counts.get(name, 0) + count
    for name, error in found.errors.items():
        if not error <= result.errors.get(name, -1.0):
            result.errors[name] = error
    for mismatch in found.mismatches:
        result.add(mismatch)


def marked(bits: Any) -> frozenset[int]:
    """Object numbers with the mark of a collision, the ball's being any player's."""
    players = {index + 1 for index in range(22) if int(bits[index]) & COLLISIONS}
    ball = any(int(bits[index]) & int(PlayerBit.BALL_COLLIDE) for index in range(22))
    return frozenset(players | ({BALL} if ball else set()))


def _differing(worlds: list[Any]) -> frozenset[int]:
    """Object numbers whose motion or angles differ among `worlds`."""
    numbers: set[int] = set()
    for other in worlds[1:]:
        for name in ("pos", "vel"):
            numbers.update(np.flatnonzero((worlds[0][name][0] != other[name][0]).any(axis=1)).tolist())
        for name in ("body", "tackle_cycles", "foul_cycles", "card_count"):
            numbers.update((np.flatnonzero(worlds[0][name][0] != other[name][0]) + 1).tolist())
    return frozenset(numbers)


def _cases(recording: Recording) -> Iterator[dict[str, Any]]:
    """The cases; rows that follow a case without steps are its steps."""
    pending: dict[str, Any] | None = None
    for record in recording.records:
        if record["rec"] == "case":
            if pending is not None:
                yield pending
                pending = None
            if "steps" in record:
                yield record
            else:
                pending = {**record, "steps": []}
        elif record["rec"] == "row" and pending is not None:
            pending["steps"].append(record)
    if pending is not None and pending["steps"]:
        yield _with_init(pending)


def _with_init(case: dict[str, Any]) -> dict[str, Any]:
    """A case whose initial state is not recorded: its first step is executed from the set-up, loaded and not compared."""
    if "init" in case:
        return case
    first = case["steps"][0]["state"]
    players = {key: values[:3] + [0.0, 0.0] + values[5:] for key, values in first["pl"].items()}
    for key, x, y, body, vx, vy in case["setup"]:
        if key in players:
            players[key] = [players[key][0], x, y, vx, vy, body, *players[key][6:]]
    return {**case, "init": {"ball": first["ball"], "pl": players}, "loads_first": True}
