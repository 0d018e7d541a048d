"""The goalie as a state machine; the eyes, which he needs whatever he does, are a second one beside it."""

from __future__ import annotations

from ..behaviour.machine import Move, State

STATES = {
    "take place": State("post", moves=(Move("save", "coming"), Move("clear", "at_hand")), on={"in_place": "watch"}),
    "watch": State(moves=(Move("save", "coming"), Move("clear", "at_hand"), Move("take place", "displaced"))),
    "save": State("save", on={"caught": "clear", "over": "take place", "past": "take place", "missed": "missed"}),
    "missed": State(moves=(Move("clear", "at_hand"), Move("take place"))),
    "clear": State("away", on={"cleared": "take place", "failed": "take place"}),
}
EYES = "eyes"
