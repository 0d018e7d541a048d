"""What the holder of the ball is about to do: a relational model learned from logged play, a tier that filters it, a goalie who uses it.

`learned("shooter")` gives the tables, `IntentionTier` the chance, side and line of the next shot, `IntentionGoalie` acts on them
(dissertation §2.3.5; ``docs/knowledge.md`` says what it is worth).
"""

from .goalie import AttackedIntentionConstants, HoldingIntentionConstants, IntentionConstants, IntentionGoalie
from .model import DUE, LINE, MODES, Intention, intention_model, learned
from .situation import FEATURES, TOUCHES, VIEW
from .tier import IntentionTier, Rule, Told
from .tree import Tree, grow

__all__ = [
    "DUE",
    "FEATURES",
    "LINE",
    "MODES",
    "TOUCHES",
    "VIEW",
    "AttackedIntentionConstants",
    "HoldingIntentionConstants",
    "Intention",
    "IntentionConstants",
    "IntentionGoalie",
    "IntentionTier",
    "Rule",
    "Told",
    "Tree",
    "grow",
    "intention_model",
    "learned",
]
