"""The own pose from landmarks and lines, with the own commands as context.

`pose_model` is the model: a player, and landmarks that refer to him. `PoseFilter` is what runs: the kernel `kernels.pose.know_pose`, which
does for it what the engine ``"mixture"`` does (tested), for N agents at once.

References
----------
specification/simulator.md 3.1 and 4.1 (motion, turns), 6.1.3, 6.1.4 and 6.1.7 (directions, distances, lines), 6.2 (what is felt).
"""

from __future__ import annotations

import numpy as np

from ....architecture.prm.model.cpds import Noise
from ....architecture.prm.model.domains import Real
from ....architecture.prm.model.model import Model
from ....architecture.prm.model.schema import Attribute, Given, PRMClass, Reference
from ....envs.actions import NECK_SCALE, PARAMETER_SCALES
from ....envs.controller import Action, Observation
from ....envs.observations import BodyFeature, SelfFeature
from ....envs.players.senses import Senses
from ....simulator.state import CommandKind
from ...body import DEFAULT, Body
from .constants import PoseConstants
from .kernels.motion import motion_of, tell_self
from .kernels.pose import know_pose

ROUNDING = 0.05
"""Half the last digit of a distance, m."""
DEGREE = np.radians(1.0)
TIMES = 2
"""How often a look is taken, each time around where the one before led to."""
TURN_SCALE = np.radians(PARAMETER_SCALES[CommandKind.TURN, 0])
"""rad of moment that 1 means."""
STARTED = -20.0
"""x of one who has not found out where he is, as in every memory."""


def pose_model() -> Model:
    """Where a player is and looks, ``face``, ``x``, ``y``, and a landmark that he sees: how far beside its direction, and how far away.

    All are straight lines around ``about``, where he is expected to look, and the pose at which a reading is taken; those are given, as is
    what he did.
    """
    own = ("turned", "turning", "go_x", "go_y", "straying", "about", "start_face", "start_x", "start_y", "start_turn", "start_spread")
    mark = ("mark_x", "mark_y", "along_x", "along_y", "across_x", "across_y", "away", "seen_face", "slack", "blur")

    def place(axis: str, way: str) -> Attribute:
        parents = (f"prev.{axis}", "face", "go_x", "go_y", "about", "straying")
        moved = Noise(f"prev.{axis} + go_{axis} {way} * (face - about)", sd="straying")
        return Attribute(axis, Real("m"), moved, parents, Noise(f"start_{axis}", sd="start_spread"), (f"start_{axis}", "start_spread"))

    face = Attribute(
        "face", Real("rad"), Noise("prev.face + turned", sd="turning"), ("prev.face", "turned", "turning"),
        Noise("start_face", sd="start_turn"), ("start_face", "start_turn"),
    )  # fmt: skip

    def numbers(names: tuple[str, ...]) -> tuple[Given, ...]:
        return tuple(Given(name, Real(), 0.0) for name in names)

    player = PRMClass("Self", (face, place("x", "- go_y"), place("y", "+ go_x")), given=numbers(own))
    aside = Noise("(mark_x - me.x) * across_x + (mark_y - me.y) * across_y - away * (me.face - seen_face)", sd="slack")
    far = Noise("(mark_x - me.x) * along_x + (mark_y - me.y) * along_y", sd="hypot(slack, blur * away)")
    parents = ("me.x", "me.y", "mark_x", "mark_y")
    readings = (
        Attribute("aside", Real("m"), aside, (*parents, "me.face", "across_x", "across_y", "away", "seen_face", "slack")),
        Attribute("far", Real("m"), far, (*parents, "along_x", "along_y", "slack", "blur", "away")),
    )
    return Model("own pose", (player, PRMClass("Mark", readings, (Reference("me", "Self"),), numbers(mark))))


class PoseFilter:
    """Where N agents are.

    Parameters
    ----------
    senses : Senses
        What is known of the eye.
    body : Body
        His own.
    constants : PoseConstants, optional

    Attributes
    ----------
    mean : (N, 3) array
        Face (rad, unwrapped), x, y (m).
    cov : (N, 3, 3) array
    known : (N,) bool array
        He has known where he is since the episode began.
    late : (N,) array
        Probability that the last look showed the world before the step.
    """

    def __init__(self, senses: Senses, body: Body = DEFAULT, constants: PoseConstants | None = None) -> None:
        self.senses, self.body, self.constants = senses, body, constants or PoseConstants()
        c, server, kind = self.constants, body.server, body.kind
        rate = kind.land_dist_noise_rate + kind.land_focus_dist_noise_rate if senses.gaussian else 0.0
        self.terms = np.array([
            server.quantize_step_l, ROUNDING, 0.5 * DEGREE, rate, c.slack**2, c.slanting**2, c.late if senses.asynchronous else 0.0,
            c.surprise, c.spread, c.turn,
        ])  # fmt: skip
        self._bounds = np.array([
            c.twisting, *np.radians((server.minmoment, server.maxmoment)), kind.inertia_moment, server.player_rand / np.sqrt(3.0),
            *np.radians((server.minneckang, server.maxneckang)), kind.player_decay, c.straying, c.bumped,
        ])  # fmt: skip
        self._work = np.zeros((4, 4, 4))
        self.mean: np.ndarray = np.zeros((0, 3))
        self.reset(0)

    def reset(self, count: int, worlds: np.ndarray | None = None) -> None:
        """Forget; in `worlds` (N,) bool alone, if given."""
        if worlds is None or len(self.mean) != count:
            self.mean, self.cov = np.zeros((count, 3)), np.zeros((count, 3, 3))
            self.known, self.late = np.zeros(count, bool), np.zeros(count)
            self._neck, self._speed, self._free = np.zeros(count), np.zeros(count), np.ones(count, bool)
            self._nothing = np.zeros(count, np.int64), np.zeros(count), np.zeros(count)
            self._resting = np.zeros(count, bool)
            self.mean[:, 1] = STARTED
            return
        self.mean[worlds] = (0.0, STARTED, 0.0)
        self.known[worlds], self._free[worlds] = False, True
        self._neck[worlds], self._speed[worlds] = 0.0, 0.0

    def step(self, observation: Observation, sent: Action | None, still: np.ndarray | None = None) -> np.ndarray:
        """Go on by a cycle.

        Parameters
        ----------
        observation : dict of (N, ...) arrays
            With ``landmarks`` and ``lines``.
        sent : dict of (N, ...) arrays, or None
            The command that brought it about; None where there was none.
        still : (N,) bool array, optional
            Whose news are the same as before: nothing is done.

        Returns
        -------
        (N, 8) array of `SelfFeature`
        """
        felt = np.asarray(observation["body"], np.float64)
        count = len(felt)
        kinds, moments, necks = self._nothing
        if sent is not None:
            kinds = np.asarray(sent["type"], np.int64)
            moments = np.asarray(sent["params"], np.float64)[:, 0] * TURN_SCALE
            necks = np.asarray(sent["turn_neck"], np.float64)[:, 0] * np.radians(NECK_SCALE)
        resting = self._resting if still is None else still
        motion, me = np.empty((count, 5)), np.empty((count, len(SelfFeature)))
        motion_of(felt, kinds, moments, necks, self._neck, self._speed, self._free, resting, self._bounds, motion)
        know_pose(
            self.mean, self.cov, self.known, self.late, felt[:, BodyFeature.SIDE], motion,
            (felt[:, BodyFeature.FRESH] > 0) & ~resting, np.asarray(observation["landmarks"], np.float64),
            np.asarray(observation["landmark_level"], np.float64), np.asarray(observation["lines"], np.float64), TIMES,
            self.terms, self._work,
        )  # fmt: skip
        tell_self(felt, self.mean, self.known, self._free, me)
        return me
