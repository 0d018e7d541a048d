"""Of which episodes there are films, and which claims cannot be seen in one."""

from __future__ import annotations

from dataclasses import dataclass

from .experiments.slow import WITH, WITHOUT
from .players import BARE, INTERNAL, NET, ON, WATCHED


@dataclass(frozen=True)
class Pair:
    """Two films of one world.

    Parameters
    ----------
    claims : tuple of str
        Keys of `claims.CLAIMS`: those behind which it stands.
    shows : str
        What is to be seen.
    task, condition : str
    one, other : (str, str, str)
        End of the name of the file, player, and how it ends. Of equal ends both films are the same to the byte, and one is kept.
    alike : bool
        Whether both are to succeed; otherwise the one does and the other does not.
    kept : str
        Name of the pair whose films these are, too.
    """

    claims: tuple[str, ...]
    shows: str
    task: str
    condition: str
    one: tuple[str, str, str]
    other: tuple[str, str, str]
    alike: bool = False
    kept: str = ""

    def files(self, name: str) -> tuple[str, str]:
        """Names of the files of both, of the pair that is called so."""
        return f"chapter5_{self.kept or name}_{self.one[0]}.mp4", f"chapter5_{self.kept or name}_{self.other[0]}.mp4"


FILMS = {
    "late": Pair(("inference",), "a belief rolls late news on to now", "Goalie", "late 2",
                 ("belief", f"{NET}{ON}belief", "saved"), ("memory", f"{NET}{ON}memory", "goal")),
    "noise": Pair(("inference",), "a belief against noise", "LostAndFound", "noise 1",
                  ("belief", f"{NET}{ON}belief", "found"), ("memory", f"{NET}{ON}memory", "not found")),
    "slow": Pair(("slow",), "reflexes answer while inference is late", "Goalie", "inference 5 late",
                 ("reflexes", WITH, "saved"), ("belief", WITHOUT, "goal")),
    "hike": Pair(("intention",), "without internal state the hike does not end", "Hike", "default",
                 ("net", NET, "out and home"), ("regions", "belief_region", "never home")),
    "internal": Pair(("internal",), "with the intention as a variable of the model it does", "Hike", "default",
                     ("net", INTERNAL, "out and home"), ("net", NET, "out and home"), alike=True, kept="hike"),
    "alike": Pair(("code can", "performance"), "code plays what the net plays", "KickOffShot", "default",
                  ("net", NET, "goal"), ("code", "code", "goal"), alike=True),
    "machine": Pair(("fsm contained",), "a state machine and its net send the same", "GoToBall", "default",
                    ("both", "state machine", "at the ball"), ("both", "state machine as a net", "at the ball"), alike=True),
    "regions": Pair(("regions contained",), "regions of belief and their net send the same", "GoToBall", "default",
                    ("both", "belief regions", "at the ball"), ("both", "belief regions as a net", "at the ball"), alike=True),
    "shifted": Pair(("transfer",), "shots are harder than those that anybody was tuned for", "Goalie", "hard shots",
                    ("cprm", "cprm", "saved"), ("regions", "belief_region", "goal")),
    "recovery": Pair(("recovery",), "recovery parts against a watchdog", "KickOffShot", "ball displaced",
                     ("net", "cprm", "goal"), ("watchdog", BARE + WATCHED, "no goal")),
}  # fmt: skip
"""Name -> pair."""
UNFILMED = {
    "explosion": "it is of sizes",
    "layers": "it is of sizes and of analysis",
    "no better analysed": "it is of what analysis finds",
    "code opaque": "it is of what analysis finds",
    "cost": "it is of what making costs",
    "learning": "it is of what making costs",
}
"""Claim -> why there is no film of it."""


def films_of(claim: str) -> list[str]:
    """Names of the pairs behind a claim."""
    return [name for name, pair in FILMS.items() if claim in pair.claims]
