"""The soccer world of server 19, whole and faithful, thousands of matches at once.

::

    from . import CommandKind, Simulator

    simulator = Simulator(worlds=2, seed=1)
    simulator.trainer.start()
    simulator.commands["kind"], simulator.commands["a"], simulator.commands["b"] = CommandKind.DASH, 60, 0
    simulator.step()
    simulator.see().ball_level      # what each of the 22 players of each world sees

One match is one record of `state.WORLD`. `simulator.Simulator` owns an array of them and calls compiled kernels (``kernels``); the
senses (`senses`), the powers of trainer and coach (`trainer`), the server's texts (`protocol`), logs (`gamelog`) and the proof by
replay (`conformance`) stand around it. The simulator knows no Gym and no agents.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_face

if TYPE_CHECKING:
    from .parameters import Rules as Rules
    from .parameters import ServerParameters as ServerParameters
    from .player_types import PlayerParameters as PlayerParameters
    from .player_types import PlayerType as PlayerType
    from .player_types import generate_types as generate_types
    from .simulator import Simulator as Simulator
    from .simulator import no_commands as no_commands
    from .state import COMMAND as COMMAND
    from .state import WORLD as WORLD
    from .state import CommandKind as CommandKind
    from .state import Count as Count
    from .state import PlayerBit as PlayerBit
    from .state import PlayMode as PlayMode
    from .state import ViewWidth as ViewWidth
    from .state import player_index as player_index
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "parameters": "Rules ServerParameters",
            "player_types": "PlayerParameters PlayerType generate_types",
            "simulator": "Simulator no_commands",
            "state": "COMMAND CommandKind Count PlayMode PlayerBit ViewWidth WORLD player_index",
        },
    )
