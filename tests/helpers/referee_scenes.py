"""Small scenes for the tests of the referee: one noise-free world, a few players, commands by name."""

from __future__ import annotations

from typing import Any

import numpy as np

from cprm_gym.simulator.parameters import Rules, ServerParameters
from cprm_gym.simulator.player_types import PlayerParameters
from cprm_gym.simulator.simulator import Simulator, no_commands
from cprm_gym.simulator.state import CommandKind, PlayMode, player_index
from cprm_gym.simulator.trainer import announcement_text

QUIET = {"ball_rand": 0.0, "player_rand": 0.0, "kick_rand": 0.0, "half_time": 300}


def player(name: str) -> int:
    """Object number of ``"l3"`` or ``"r11"``."""
    return player_index(1 if name[0] == "l" else -1, int(name[1:]))


class Scene:
    """One world in which the test puts everybody where it wants them; those who are not named wait far from the ball."""

    def __init__(
        self,
        left: int = 4,
        right: int = 4,
        mode: str = "play_on",
        rules: Rules = Rules.ALL,
        seed: int = 1,
        goalies: tuple[int, int] = (1, 1),
        **parameters: Any,
    ) -> None:
        self.sim = Simulator(
            1,
            ServerParameters(**{**QUIET, **parameters}),
            PlayerParameters(random_seed=3),
            seed=seed,
            rules=rules,
            left=left,
            right=right,
            goalies=goalies,
        )
        self.put_ball(0.0, 25.0)
        for unum in range(1, left + 1):
            self.put(f"l{unum}", -30.0, -33.0 + unum, body=0.0)
        for unum in range(1, right + 1):
            self.put(f"r{unum}", 30.0, 33.0 - unum, body=np.pi)
        if mode != "before_kick_off":
            self.sim.trainer.change_mode(mode)
        self.world["announced"] = 0
        self.said: list[str] = []
        self._orders: dict[int, list[Any]] = {}

    @property
    def world(self) -> Any:
        return self.sim.world[0]

    @property
    def mode(self) -> str:
        return PlayMode(int(self.world["mode"])).name

    @property
    def ball(self) -> tuple[float, float]:
        x, y = self.world["pos"][0]
        return float(x), float(y)

    def place_of(self, name: str) -> tuple[float, float]:
        x, y = self.world["pos"][player(name)]
        return float(x), float(y)

    def put(self, name: str, x: float, y: float, body: float | None = None, velocity: tuple[float, float] = (0.0, 0.0)) -> Scene:
        self.sim.trainer.place_player(player(name), x, y, body, velocity)
        return self

    def put_ball(self, x: float, y: float, vx: float = 0.0, vy: float = 0.0) -> Scene:
        self.sim.trainer.place_ball(x, y, vx, vy)
        return self

    def do(self, name: str, kind: CommandKind, *arguments: float) -> Scene:
        """Execute one command now."""
        command = no_commands(1)[0]
        command["kind"] = kind
        for field, value in zip("abcd", arguments):
            command[field] = value
        if kind in (CommandKind.DASH, CommandKind.TACKLE) and len(arguments) == 1:
            command["b"] = 0.0
        self.sim.command_phase(0, player(name), command)
        return self

    def dash(self, name: str, power: float = 100.0, direction: float = 0.0) -> Scene:
        return self.do(name, CommandKind.DASH, power, direction)

    def kick(self, name: str, power: float = 20.0, direction: float = 0.0) -> Scene:
        return self.do(name, CommandKind.KICK, power, direction)

    def tackle(self, name: str, foul: bool = False) -> Scene:
        return self.do(name, CommandKind.TACKLE, 0.0, float(foul))

    def catch(self, name: str, direction: float = 0.0) -> Scene:
        return self.do(name, CommandKind.CATCH, direction)

    def step(self, count: int = 1) -> Scene:
        """Run steps and keep what the referee says."""
        for _ in range(count):
            self.sim.advance()
            self.listen()
        return self

    def listen(self) -> None:
        world = self.world
        self.said += [announcement_text(*(int(n) for n in row)) for row in world["announcement"][: int(world["announced"])]]
        world["announced"] = 0

    def steps_until(self, mode: str, limit: int = 200) -> int:
        """Steps until the play mode is `mode`; fails beyond `limit`."""
        for count in range(limit + 1):
            if self.mode == mode:
                return count
            self.step()
        raise AssertionError(f"no {mode} within {limit} steps; said {self.said}")
