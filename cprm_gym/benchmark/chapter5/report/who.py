"""Who plays, in a line each, and how what was measured is to be read."""

from __future__ import annotations

WHO: dict[str, str] = {
    "cprm": "The architecture: a Petri net that acts; in some tasks with a probabilistic relational model that tells it what it does not "
            "see.",
    "net": "The same net without the model. It knows what the environment reckons from what was last seen (dead reckoning), as "
           "do fsm, subsumption, behavior_tree, code and belief_region.",
    "net on tracker": "The same net on Kalman filters of the ball and of everybody, which know how large the noise is.",
    "fsm": "A state machine: in one state at a time.",
    "subsumption": "Small machines side by side, of which a higher one overrules a lower one.",
    "behavior_tree": "A tree of conditions and actions, asked anew in every cycle.",
    "code": "Python coroutines side by side.",
    "belief_region": "No memory of its own: what it believes of the world decides what it does, region by region.",
    "policy": "A neural network, trained on the task, where one comes with the project.",
    "scripted": "A simple hand-written player who plays every task; the usual opponent.",
    "random": "Any command.",
}  # fmt: skip
"""Player -> what it is."""
READING = (
    "A cell is a task, a condition and a player. A tier is what a player goes by where he does not see: frozen readings, dead reckoning "
    "(memory), Kalman filters (tracker), a probabilistic model (belief), or the truth (state). A chain is a Markov chain of what a "
    "behaviour does in a world, which analysis asks. "
    "All meet the same worlds. All that are written by hand, but scripted, have the same skills and formulas, so they differ in structure. "
    "Rates have Wilson intervals of 95 %. Differences are paired, episode by episode, and corrected for the number of comparisons of their "
    "experiment (Holm). “A > B” is said only where the corrected exact test is below .05 and the corrected interval excludes zero. "
    "h is Cohen's effect size of two rates: .2 is small, .5 medium, .8 large; d is the mean difference in standard deviations."
)
MARKS = (
    "▲ decidedly better, ▼ decidedly worse than net, or than cprm where no net is played apart; without a mark it is not "
    "decided, and random is not compared. "
    "Nothing stands where nobody plays, and for net where it would be cprm again."
)
