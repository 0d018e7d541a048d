"""Who plays a demonstration: the model, its rivals and the oracle, each with the same net and with numbers tuned by the same procedure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ...agents.body import Body
from ...agents.goalie import GoalieAgent, ReckoningGoalie
from ...agents.intention import (
    AttackedIntentionConstants,
    HoldingIntentionConstants,
    IntentionConstants,
    IntentionGoalie,
    IntentionTier,
    Rule,
    learned,
)
from ...agents.knowledge.belief import BeliefTier
from ...agents.knowledge.players import PLAYERS
from ...agents.knowledge.registry import make_tier
from ...agents.knowledge.tiers import Informed
from ...agents.knowledge.tracker import Tracker
from ...agents.skills.constants import AttackedConstants, GoalieConstants, HoldingConstants
from ...envs.controller import Controller
from ...envs.players.senses import Senses
from ...envs.tasks import Task
from .looking import NARROW, PATTERNS, FixedLooks, Pattern

Factory = Callable[[Task, str], Informed]


@dataclass(frozen=True)
class Arm:
    """One who plays.

    Parameters
    ----------
    tier : str
        Of knowledge; of an arm that expects shots the one beneath, ``tracker`` or ``belief``; ``own`` for the goalie with the model of his
        own (`GoalieAgent`).
    expects : str
        ``model``, ``rule`` or nothing.
    lesion : mapping of str to bool
        Options of `IntentionTier`.
    options : mapping
        Of the goalie: how he looks (``focus``); of one with a model of his own also ``reflexes``, ``t_b`` and ``latency``.
    looks : Pattern, optional
        Which his eyes follow instead; of an arm that expects nothing.
    holds : bool
        Whether he catches by how likely he is to hold the ball, on a tier that has a distribution of it (`Tracker`).
    """

    tier: str
    expects: str = ""
    lesion: Mapping[str, bool] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)
    looks: Pattern | None = None
    holds: bool = False

    def constants(self, task: str = "Goalie") -> type[GoalieConstants]:
        """What his numbers are in a task: against several attackers there are more."""
        if self.holds:
            return HoldingIntentionConstants if self.expects else HoldingConstants
        alone, several = (IntentionConstants, AttackedIntentionConstants) if self.expects else (GoalieConstants, AttackedConstants)
        return alone if task == "Goalie" else several

    def begin(self, task: str = "Goalie") -> GoalieConstants:
        """The numbers at which his tuning begins: those tuned for ``memory`` at default senses, the same for all."""
        tuned = GoalieConstants.tuned("memory") if task == "Goalie" else AttackedConstants.tuned("memory", PLAYERS[task].study)
        return self.constants(task).of(tuned.to_dict())

    def on(self, senses: Senses, constants: GoalieConstants, play: str = "shooter") -> Factory:
        """A factory of his controllers.

        Parameters
        ----------
        senses : Senses
        constants : GoalieConstants
        play : str
            Whose learned tables a model takes.
        """

        def make(task: Task, agent: str) -> Informed:
            body, opponents = Body.of(task), task.right if agent.startswith("left") else task.left
            if self.tier == "own":
                return Informed(GoalieAgent(opponents, body=body, constants=constants, **self.options), make_tier("memory", task, agent))
            if not self.expects:
                goalie: Controller = ReckoningGoalie(opponents, body, constants, **self.options)
                goalie = goalie if self.looks is None else FixedLooks(goalie, self.looks)
                if not self.holds:
                    return Informed(goalie, make_tier(self.tier, task, agent, senses))
            inner = (BeliefTier if self.tier == "belief" else Tracker)(senses, body, hands=self.holds)
            if not self.expects:
                return Informed(goalie, inner)
            assert isinstance(constants, IntentionConstants)
            options: dict[str, Any] = {**self.lesion, "rule": Rule() if self.expects == "rule" else None}
            goalie = IntentionGoalie(opponents, body, constants, **self.options)
            return Informed(goalie, IntentionTier(inner, learned(play), opponents, **options))

        return make


_EYES: Mapping[str, Any] = {"focus": True, "reflexes": "eye"}
ARMS: dict[str, Arm] = {
    "memory": Arm("memory"),
    "tracker": Arm("tracker"),
    "belief": Arm("belief"),
    "rule": Arm("tracker", "rule"),
    "rule on belief": Arm("belief", "rule"),
    "model": Arm("tracker", "model"),
    "model on belief": Arm("belief", "model"),
    "tracker, hands": Arm("tracker", holds=True),
    "belief, hands": Arm("belief", holds=True),
    "rule, hands": Arm("tracker", "rule", holds=True),
    "model, hands": Arm("tracker", "model", holds=True),
    "model on belief, hands": Arm("belief", "model", holds=True),
    "without attention": Arm("tracker", "model", {"attended": False}),
    "without possession": Arm("tracker", "model", {"possesses": False}),
    "without memory": Arm("tracker", "model", {"memory": False}),
    "state": Arm("state"),
    "at once": Arm("own", options=_EYES),
    "slow": Arm("own", options={**_EYES, "t_b": 5, "latency": 5}),
    "slow, no reflexes": Arm("own", options={**_EYES, "t_b": 5, "latency": 5, "reflexes": "none"}),
    "no model": Arm("frozen", options={"focus": True}),
    "looking": Arm("tracker", options={"focus": True}),
    "eyes on the ball, narrow": Arm("tracker", looks=NARROW),
    **{name: Arm("tracker", looks=pattern) for name, pattern in PATTERNS.items()},
}  # fmt: skip
"""Name -> who plays. ``rule`` is the hand rule "expect the shot", with the model's line; ``at once`` and ``slow`` have the goalie's own
model, ``no model`` nothing but what the eye told last; after them those who differ in how they look."""
