"""Kernels loaded or compiled before a server answers, so that no cycle waits for them."""

from __future__ import annotations

from functools import cache

from ..simulator.protocol.messages import see_text, sense_body_text
from .clients import Client, Port
from .core import Server
from .settings import Settings

_WORDS = ("server::synch_mode=true", "server::fullstate_l=true", "server::fullstate_r=true", "server::send_comms=true")
_WITH_REFEREE = ("server::coach_w_referee=true", "server::auto_mode=true")
_WITHOUT = ("server::coach=true",)
_GUESTS = {
    "goalie": (Port.PLAYER, b"(init Left (version 19) (goalie))\0"),
    "mate": (Port.PLAYER, b"(init Left (version 19))\0"),
    **{f"player {version}": (Port.PLAYER, b"(init Right (version %d))\0" % version) for version in (7, 13, 18)},
    **{f"monitor {version}": (Port.PLAYER, b"(dispinit version %d)\0" % version) for version in (-1, 1, 2, 3, 4, 5)},
    "coach": (Port.COACH, b"(init Left (version 19))\0"),
    "trainer": (Port.TRAINER, b"(init (version 19))\0"),
}
_OFFICIALS = (
    ("coach", "(eye on)(look)(change_player_type 2 1)(change_player_type 1 goalie)"),
    ("trainer", "(eye on)(look)(check_ball)(move (ball) 0 0 0 0 0)(move (player Left 1) -1 0 0 0 0)(recover)"),
    ("trainer", "(change_player_type Left 2 2)(change_mode free_kick_l)(change_mode play_on)(start)"),
    ("monitor 5", "(dispfoul 0 0 0)(dispfoul 0 0 1)(dispplayer 1 1 0 0 0)(dispcard 1 2 yellow)"),
)
_PLAYS = (
    b"(dash 10)(turn_neck 5)\0", b'(say "a")(kick 10 0)(pointto 5 0)\0', b"(change_view narrow)(attentionto our 2)(sense_body)\0",
    b"(turn 10)(change_focus 1 1)(score)\0", b"(tackle 0)\0", b"(catch 0)\0", b"(move -1 0)(ear (off))\0", b"(bye)\0",
)  # fmt: skip


@cache
def load_kernels(refereed: bool) -> None:
    """Play a few cycles of a match that nobody sees, with somebody of every role; once per process.

    The first time ever that takes a minute or two, later processes load what was compiled then (`cprm_gym.kernel_cache`).

    Parameters
    ----------
    refereed : bool
        As `Simulator.refereed`: a match without any rule has kernels of its own. On other parameters they do not depend.
    """
    server, there = Server(Settings.from_words((*_WORDS, *(_WITH_REFEREE if refereed else _WITHOUT)))), dict[str, Client]()
    for name, (port, first) in _GUESTS.items():
        client = server.receive(port, name, first)
        assert client is not None
        there[name] = client
    for name, texts in _OFFICIALS:
        for text in texts.replace(")(", ")\n(").splitlines():
            server.receive_from(there[name], text.encode() + b"\0")
    for data in _PLAYS:
        server.receive_many([(there["goalie"], data), (there["mate"], b"(dash 10)(turn_neck 5)(done)\0")])
        server.step()
        server.look_again()
        server.think()
        server.look_late()
        server.take_outbox()
    for write in (see_text, sense_body_text):  # numbers that the kernels for texts leave
        write(server.stadium.sim, 0, 1)
