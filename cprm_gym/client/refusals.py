"""What a server's refusals mean for who was refused, and what to do about them."""

from __future__ import annotations

from ..errors import CprmError

_ADVICE = {
    "no_more_team": "two other teams are there; join under the name of one of them, or a server without teams",
    "no_more_player_or_goalie_or_illegal_client_version": "the team is full or has a goalie (--no-goalie), or the server is older than "
    "protocol 19; a name that is not there yet begins a new team",
    "conflict_with_fixed_teamname": "the server has given that name to a side; choose another",
    "illegal_teamname": "choose another name for the team",
    "cannot_reconnect_while_playon": "try again when play is stopped",
    "red_carded_player": "that player was sent off",
    "connected_offline_coach_without_coach_mode": "start the server with server::coach=true, or server::coach_w_referee=true",
    "already_have_offline_coach": "end the trainer that is there",
    "no_such_team": "its first player must be there before",
    "already_have_coach": "end the coach that is there, or leave out --coach",
    "connection_failed": "a coach of that team has been there; start the server anew, or leave out --coach",
    "no_more_monitor": "end another monitor, or start the server with a larger server::max_monitors",
}
"""What to do about an error of the server, by its name (specification/protocol.md 3, 6, 7, 10)."""


def refusal(place: str, asked: str, answer: str) -> CprmError:
    """The error for somebody whom a server refuses.

    Parameters
    ----------
    place : str
        Of the server.
    asked, answer : str
        What it was sent, and its ``(error NAME)``.
    """
    name = answer.removeprefix("(error ").removesuffix(")")
    advice = f"; {_ADVICE[name]}" if name in _ADVICE else ""
    return CprmError(f"server {place} refuses {asked}: {name}{advice}")
