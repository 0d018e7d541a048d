"""Mates and opponents from raw senses: a relational model of real numbers with modes, and identities that are uncertain.

`players_model` is the model: players who rest, run on or change their way, and sights of them. `PlayersFilter` is what runs: kernels that
do for it what the engine ``"mixture"`` does (tested), for N agents at once, with at most `HYPOTHESES` assignments of nameless readings.

References
----------
specification/simulator.md 3.1 (motion), 6.1.3 to 6.1.6 (what is told of players).
"""

from __future__ import annotations

import numpy as np

from ....architecture.prm.model.cpds import Chance, Noise, Prior, Switch, Table
from ....architecture.prm.model.domains import BOOL, Domain, Labels, Real
from ....architecture.prm.model.model import Model
from ....architecture.prm.model.schema import Attribute, Given, PRMClass, Reference
from ....envs.controller import Observation
from ....envs.observations import BodyFeature, SelfFeature
from ....envs.players.senses import Senses
from ....simulator.pitch import PITCH_LENGTH, PITCH_WIDTH
from ....simulator.state import ViewWidth
from ...body import DEFAULT, Body, number
from ...percepts import NEVER
from ..kernels.eye import RATE_STEP, ROUNDING, SWING_STEP
from .constants import PlayerConstants
from .kernels import players as terms
from .kernels.association import PLAYERS, Modes, Room, Seen, Tracks, expected_places, know_players

HYPOTHESES, PAIRS = 32, 64
"""Assignments of the nameless readings of a look that are kept, and pairs of a reading and a player that are weighed."""
WIDTHS = {ViewWidth.NARROW: (60.0, 0.5), ViewWidth.NORMAL: (120.0, 1.0), ViewWidth.WIDE: (180.0, 2.0)}
"""View cone of an eye in step (degrees), and the factor of ``visible_angle`` of one that is not."""
MODES = ("rests", "runs", "changes")
"""How a player moves: he slows down, he goes on, or he starts, stops or turns."""
COLUMNS = [SelfFeature.X, SelfFeature.Y, SelfFeature.VX, SelfFeature.VY, SelfFeature.FACE]
LEAST = 1e-6
"""m^2 that are added to every variance where a density is asked for."""


def modes_of(body: Body, constants: PlayerConstants) -> Modes:
    """The numbers of `MODES`."""
    c, decay = constants, max(body.kind.player_decay, 0.05)
    other = 0.5 * (1.0 - c.lasting)
    switch = np.full((3, 3), other)
    np.fill_diagonal(switch, c.lasting)
    return Modes(
        switch, np.array([decay, c.keeps, c.holds]), np.array([c.still, c.steady, c.sudden]) ** 2, np.full(3, 1.0 / 3.0), c.turning**2
    )


def players_model(body: Body = DEFAULT, constants: PlayerConstants | None = None, sights: int = 0) -> Model:
    """The model of players, and of sights that can be of one of several.

    Parameters
    ----------
    body : Body
        Of the server; the others are taken for players like him.
    constants : PlayerConstants, optional
    sights : int
        Players whom a nameless sight refers to, ``p1`` ...; 0 leaves that class out.
    """
    c = constants or PlayerConstants()
    moves, decay = modes_of(body, c), number(max(body.kind.player_decay, 0.05))

    def numbers(*names: str) -> tuple[Given, ...]:
        return tuple(Given(name, Real(), 0.0) for name in names)

    def velocity(axis: str) -> Attribute:
        ways = {name: Noise(f"{number(k)} * prev.v{axis}", sd=float(np.sqrt(q))) for name, k, q in zip(MODES, moves.keeps, moves.pushes)}
        start = Noise(f"start_v{axis}", sd="start_speed")
        return Attribute(
            f"v{axis}", Real("m/cycle"), Switch("mode", ways), (f"prev.v{axis}", "mode"), start, (f"start_v{axis}", "start_speed")
        )

    def place(axis: str) -> Attribute:
        parents = (f"prev.{axis}", f"v{axis}")
        start = Noise(f"start_{axis}", sd="start_spread")
        return Attribute(
            axis, Real("m"), Noise(f"prev.{axis} + v{axis} / {decay}", sd=c.jitter), parents, start, (f"start_{axis}", "start_spread")
        )

    table = Table({(name,): tuple(float(x) for x in row) for name, row in zip(MODES, moves.switch)})
    along, across = "({0}x - me_{0}x) * seen_cos + ({0}y - me_{0}y) * seen_sin", "({0}y - me_{0}y) * seen_cos - ({0}x - me_{0}x) * seen_sin"
    away = f"({along.format('')})"
    where, moving = ("x", "y", "me_x", "me_y", "seen_cos", "seen_sin"), ("vx", "vy", "me_vx", "me_vy")
    off = Noise("about + (y - about_y) * side_y + (x - about_x) * side_x", sd="turned")
    mode: Domain = Labels(MODES)
    player = PRMClass(
        "Player",
        (
            Attribute("mode", mode, table, ("prev.mode",), Prior(tuple(float(x) for x in moves.shares))),
            velocity("x"), velocity("y"), place("x"), place("y"),
            Attribute("facing", Real("rad"), Noise("prev.facing", sd=c.turning), ("prev.facing",), Noise("0", sd=3.0)),
            Attribute("far", Real("m"), Noise(along.format(""), sd="far_sd"), (*where, "far_sd")),
            Attribute("aside", Real("m"), Noise(across.format(""), sd="aside_sd"), (*where, "aside_sd")),
            Attribute("approach", Real("m/cycle"), Noise(f"{along.format('v')} - told_rate * {away}", sd="approach_sd"),
                      (*where, *moving, "told_rate", "approach_sd")),
            Attribute("swing", Real("m/cycle"), Noise(f"{across.format('v')} - told_turn * {away}", sd="swing_sd"),
                      (*where, *moving, "told_turn", "swing_sd")),
            Attribute("body", Real("rad"), Noise("facing", sd="turned"), ("facing", "turned")),
            Attribute("off", Real("rad"), off, ("x", "y", "about", "about_x", "about_y", "side_x", "side_y", "turned")),
            Attribute("missed", BOOL, Chance(f"{number(1.0 - c.seen)} if abs(off) < half else 1", points=8), ("off", "half")),
        ),
        given=numbers(
            "start_x", "start_y", "start_vx", "start_vy", "start_speed", "start_spread", "me_x", "me_y", "me_vx", "me_vy",
            "seen_cos", "seen_sin", "far_sd", "aside_sd", "approach_sd", "swing_sd",
            "told_rate", "told_turn", "about", "about_x", "about_y", "side_x", "side_y", "turned", "half",
        ),
    )  # fmt: skip
    if not sights:
        return Model("players from raw senses", (player,))
    names = tuple(f"p{k + 1}" for k in range(sights))
    parents = tuple(f"{name}.{axis}" for name in names for axis in "xy")

    def sight(formula: str, sd: str) -> Attribute:
        formula = formula.replace("({0}x", "({0}.x").replace("({0}y", "({0}.y").replace("me_{0}", "me_")
        ways = {name: Noise(formula.format(name), sd=sd) for name in names}
        return Attribute(sd[:-3], Real("m"), Switch("whose", ways), (*parents, "whose", "me_x", "me_y", "seen_cos", "seen_sin", sd))

    seen = PRMClass(
        "Sight",
        (Attribute("whose", Labels(names), Prior((1.0 / sights,) * sights)), sight(along, "far_sd"), sight(across, "aside_sd")),
        tuple(Reference(name, "Player") for name in names),
        numbers("me_x", "me_y", "seen_cos", "seen_sin", "far_sd", "aside_sd"),
    )
    return Model("players and nameless sights", (player, seen))


def make_terms(senses: Senses, body: Body, constants: PlayerConstants) -> np.ndarray:
    """The numbers of `kernels.players` that are the senses', the server's and the model's."""
    c, noise = constants, senses.sizes
    p = np.zeros(terms.COARSER + 1)
    p[terms.STEP], p[terms.ROUNDING] = senses.quantise * body.server.quantize_step, 0.5 * ROUNDING
    p[terms.HALF] = np.radians(0.5 * senses.quantise)
    p[terms.FAR_NOISE], p[terms.ANGLE_NOISE] = np.hypot(2.0 * senses.gaussian, noise[0]), noise[1]
    p[terms.PACE_NOISE], p[terms.SWING_NOISE], p[terms.BLUR] = noise[2], noise[3], 2.0 * senses.gaussian
    p[terms.DECAY], p[terms.JITTER] = max(body.kind.player_decay, 0.05), c.jitter**2
    p[terms.PLACED], p[terms.TURNED], p[terms.PACED] = c.placed, np.radians(c.turned), c.paced
    p[terms.SEEN], p[terms.NEAR] = c.seen, body.server.visible_distance
    p[terms.RATE_STEP], p[terms.SWING_STEP], p[terms.GAUSSIAN] = RATE_STEP, np.radians(SWING_STEP), senses.gaussian
    p[terms.ELSEWHERE], p[terms.FRESH], p[terms.STRAY] = c.elsewhere, c.fresh, c.stray
    p[terms.SPEED], p[terms.GATE], p[terms.SOFT] = c.speed, c.gate, np.rint(c.soft)
    p[terms.FIELD], p[terms.ARM] = PITCH_LENGTH * PITCH_WIDTH, senses.motion
    # a change of distance is told as a share of the distance that is told, unless one of them was blurred or coarsened afterwards
    tied = senses.gaussian > 0.0 or (senses.noise == 0.0 and senses.quantise == 1.0)
    p[terms.TIED] = tied
    p[terms.AFTER] = noise[0] + (0.5 * p[terms.STEP] if senses.quantise > 1.0 else 0.0) if tied else 0.5 * body.server.quantize_step
    p[terms.EYE] = body.server.quantize_step if senses.noise == 0.0 and not senses.gaussian else 0.0
    p[terms.COARSER] = senses.quantise
    p[terms.SHRUNK] = np.exp(-0.5 * noise[0] ** 2)  # of a distance whose logarithm has a normal error
    return p


def make_room(hypotheses: int = HYPOTHESES, pairs: int = PAIRS) -> Room:
    """Arrays for `know_players`."""
    paths, state, modes = terms.PATHS, terms.STATE, terms.MODES

    def three(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return np.zeros((count, paths)), np.zeros((count, paths, state)), np.zeros((count, paths, state, state))

    return Room(
        *three(PLAYERS), *three(PLAYERS), *three(pairs), np.zeros((pairs, 2), np.int64), np.zeros((pairs, 2)), np.zeros(PLAYERS),
        np.zeros((2 * PLAYERS, 5)), np.zeros((PLAYERS, 4, 4)), np.zeros((4, 4)), np.zeros((PLAYERS, 3)), np.zeros(PLAYERS, np.int64),
        np.zeros(PLAYERS, np.int64), np.zeros(PLAYERS + 1, np.int64), np.zeros((2, hypotheses), np.int64), np.zeros((2, hypotheses)),
        np.zeros((2, hypotheses, PLAYERS), np.int64), np.zeros(modes), np.zeros((2, modes, state)), np.zeros((modes, state, state)),
        np.zeros(state + 1), np.zeros((state + 1, state + 1)), np.zeros(state + 1), np.zeros((state, state)),
    )  # fmt: skip


class PlayersFilter:
    """What N agents believe of mates and opponents.

    Parameters
    ----------
    senses : Senses
        What is known of the eye.
    body : Body
        His own; the others are taken for players like him.
    constants : PlayerConstants, optional
    hypotheses : int
        Assignments of the nameless readings of a look that are kept.

    Attributes
    ----------
    tracks : Tracks
        ``dropped`` and ``merged`` tell what the budget and merging lost in the last look.
    """

    def __init__(
        self, senses: Senses, body: Body = DEFAULT, constants: PlayerConstants | None = None, hypotheses: int = HYPOTHESES
    ) -> None:
        self.senses, self.body, self.constants = senses, body, constants or PlayerConstants()
        self.modes, self.terms = modes_of(body, self.constants), make_terms(senses, body, self.constants)
        self._room = make_room(hypotheses)
        cones = np.zeros(4)
        for width, (degrees, factor) in WIDTHS.items():
            cones[width] = np.radians(0.5 * (factor * body.server.visible_angle if senses.asynchronous else degrees))
        self._cones = cones
        self.tracks: Tracks = self._nobody(0)
        self._none = np.zeros(0, bool)

    @staticmethod
    def _nobody(count: int) -> Tracks:
        shape, modes, state = (count, PLAYERS), terms.MODES, terms.STATE
        return Tracks(
            np.zeros((*shape, modes)), np.zeros((*shape, modes, state)), np.zeros((*shape, modes, state, state)), np.zeros(shape, np.int64),
            np.full(shape, int(NEVER), np.int64), np.zeros(shape), np.zeros((*shape, 2)), np.zeros(count), np.zeros(count),
        )  # fmt: skip

    def reset(self, count: int, worlds: np.ndarray | None = None) -> None:
        """Forget; in `worlds` (N,) bool alone, if given."""
        if worlds is None or len(self.tracks.w) != count:
            self.tracks, self._none = self._nobody(count), np.zeros(count, bool)
            return
        self.tracks.known[worlds] = 0
        self.tracks.age[worlds] = int(NEVER)

    def step(
        self,
        observation: Observation,
        me: np.ndarray,
        unsure: np.ndarray,
        before: np.ndarray | None = None,
        still: np.ndarray | None = None,
    ) -> None:
        """Go on by a cycle.

        Parameters
        ----------
        observation : dict of (N, ...) arrays
        me : (N, 8) array of `SelfFeature`
            What he believes of himself when they were seen.
        unsure : (N, 2) array
            Variances of his place (m^2) and face (rad^2).
        before : (N,) bool array, optional
            Whose look shows the world before the step; `me` is of then.
        still : (N,) bool array, optional
            Whose news are the same as before: nothing is done.
        """
        felt, level = np.asarray(observation["body"], np.float64), np.asarray(observation["level"], np.float64)
        none = self._none
        told = np.empty((len(felt), len(COLUMNS) + 2))
        told[:, :-2], told[:, -2:] = me[:, COLUMNS], unsure
        fresh = (felt[:, BodyFeature.FRESH] > 0) | (level > 0).any(axis=1)
        width = np.clip(felt[:, BodyFeature.VIEW_WIDTH].astype(np.int64), 1, 3)
        seen = Seen(
            told, self._cones[width], fresh & (me[:, SelfFeature.LOCATED] > 0), none if before is None else before,
            np.asarray(observation["players"], np.float64), level[:, 1:], felt[:, BodyFeature.SIDE],
            felt[:, BodyFeature.UNUM].astype(np.int64) - 1, none if still is None else still,
        )  # fmt: skip
        know_players(self.tracks, seen, self.modes, self.terms, self._room)

    @property
    def known(self) -> np.ndarray:
        """(N, 22) bool, own team 0..10, opponents 11..21: believed to be there."""
        return self.tracks.known > 0

    def places(self, ahead: int = 0) -> np.ndarray:
        """(N, 22, 4) expected places and velocities, `ahead` cycles from the last news on; 0 of those not known."""
        out = np.empty((len(self.tracks.w), PLAYERS, terms.STATE))
        expected_places(self.tracks, self.modes, ahead, self.terms[terms.DECAY], out)
        return out

    def log_density(self, place: np.ndarray) -> np.ndarray:
        """(N, 22) log density of places (N, 22, 2) at the time of the last news, of all modes together; -inf of those not known."""
        t = self.tracks
        off, cov = np.asarray(place, np.float64)[:, :, None] - t.mu[..., :2], t.cv[..., :2, :2]
        xx, yy, xy = cov[..., 0, 0] + LEAST, cov[..., 1, 1] + LEAST, cov[..., 0, 1]
        det = np.maximum(xx * yy - xy**2, LEAST**2)
        away = (yy * off[..., 0] ** 2 - 2.0 * xy * off[..., 0] * off[..., 1] + xx * off[..., 1] ** 2) / det
        with np.errstate(divide="ignore"):
            parts = np.log(t.w) - 0.5 * (away + np.log(det)) - np.log(2.0 * np.pi)
        return np.where(self.known, np.logaddexp.reduce(parts, axis=2), -np.inf)
