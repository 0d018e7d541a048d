"""A soccer server over UDP: programs written for the RoboCup 2D soccer server join it as they would join that.

``cprm-gym serve`` starts one. `Server` is the match without sockets and clocks (datagrams in, datagrams out); `Transport` has the sockets,
`run_in_real_time` and `run_synchronously` the clocks; `Settings` reads parameters and the server's own configuration files.

=========== =======================================================================================
core        the server: who gets which datagram, one cycle
stadium     what its parts share: the match, who is connected, what waits to be sent
roles       connecting and commands of players, coaches, trainer and monitors
texts       parameters, frames and pictures as they are told them
transport   sockets and clocks
logs, teams logs and start commands
=========== =======================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_face

if TYPE_CHECKING:
    from .clients import Port as Port
    from .core import Server as Server
    from .settings import Settings as Settings
    from .transport import Transport as Transport
    from .transport import run_in_real_time as run_in_real_time
    from .transport import run_synchronously as run_synchronously
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "clients": "Port",
            "core": "Server",
            "settings": "Settings",
            "transport": "Transport run_in_real_time run_synchronously",
        },
    )
