"""What a step of the Gaussian mixture engine costs: ``python tests/benchmarks/bench_real_numbers.py``.

CPU time of this process, medians over 100 steps. A ball and eleven players, each with place and velocity in real numbers, distance and
direction of all of them read in every step; the ball of `cprm_gym.agents.knowledge.ball` with its modes; and what the tier ``belief`` does
in a match of eleven a side, from recorded observations of one who runs about and looks: himself, the 21 others, all of it with the ball.
"""

from __future__ import annotations

from collections.abc import Callable
from time import process_time
from typing import Any

import numpy as np

from cprm_gym.agents.body import DEFAULT
from cprm_gym.agents.knowledge.ball import SELF, BallConstants, ball_model
from cprm_gym.agents.knowledge.belief import COMPONENTS, MERGE, BeliefTier
from cprm_gym.architecture.prm import Angle, Attribute, Filter, Grounding, Interval, Model, Noise, PRMClass, Real
from cprm_gym.architecture.prm.inference.engines.mixture import MixtureEngine
from cprm_gym.envs.controller import Action, Observation, no_action
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.players.senses import Senses
from cprm_gym.simulator.state import CommandKind


def thing(name: str) -> PRMClass:
    """Place and velocity, distance and direction."""
    place = [
        Attribute(a, Real("m"), Noise(f"prev.{a} + prev.v{a}", sd=0.05), (f"prev.{a}", f"prev.v{a}"), Noise("12", sd=15)) for a in "xy"
    ]
    speed = [Attribute(f"v{a}", Real("m/cycle"), Noise(f"0.94 * prev.v{a}", sd=0.1), (f"prev.v{a}",), Noise("0", sd=0.5)) for a in "xy"]
    sight = [
        Attribute("dir", Angle("deg"), Noise("degrees(atan2(y, x))", sd=1.0), ("x", "y")),
        Attribute("dist", Real("m"), Noise("hypot(x, y)", sd=0.3), ("x", "y")),
    ]
    return PRMClass(name, (*place, *speed, *sight))


def microseconds(filter: Filter, told: list[dict[str, object]]) -> float:
    """Median of a step."""
    spent = []
    for k, readings in enumerate(told):
        begun = process_time()
        filter.step(readings)
        if k >= 20:
            spent.append(process_time() - begun)
    return 1e6 * float(np.median(spent))


def match(worlds: int, cycles: int = 60) -> tuple[list[Observation], list[Action]]:
    """What a player of a match is told and does, in `worlds` worlds."""
    core = SoccerCore("Soccer11v11", worlds, controlled="left_7", others="strong", include=("landmarks", "lines"), seed=3)
    core.reset(3)
    random = np.random.default_rng(0)
    told, sent = [], []
    for _ in range(cycles):
        told.append({key: value[:, 0].copy() for key, value in core.observation.items()})
        action = no_action(worlds)
        action["type"][:] = random.choice([CommandKind.DASH, CommandKind.TURN], worlds)
        action["params"][:, 0] = random.uniform(-0.5, 1.0, worlds)
        sent.append(action)
        core.step({key: value[:, None] for key, value in action.items()})
    return told, sent


def timed(step: Callable[..., Any], spent: list[float]) -> Callable[..., Any]:
    """The same, which notes its CPU time."""

    def run(*arguments: Any) -> Any:
        begun = process_time()
        found = step(*arguments)
        spent.append(process_time() - begun)
        return found

    return run


def raw_senses() -> None:
    """Rows of the tier ``belief``."""
    for agents in (1, 250):
        told, sent = match(agents)
        tier = BeliefTier(Senses())
        tier.reset(told[0])
        spent: dict[str, list[float]] = {"self": [], "21 others": [], "self, ball and 21 others": []}
        tier.pose.step = timed(tier.pose.step, spent["self"])  # type: ignore[method-assign]
        tier.others.step = timed(tier.others.step, spent["21 others"])  # type: ignore[method-assign]
        for k, observation in enumerate(told):
            begun = process_time()
            tier.know(observation, sent[k - 1] if k else None)
            spent["self, ball and 21 others"].append(process_time() - begun)
        for name, times in spent.items():
            mean = 1e6 * float(np.mean(times[10:]))
            worst = 1e6 * float(np.quantile(times[10:], 0.95))
            each = mean / {"self": 1, "21 others": 21}.get(name, 23) / agents
            print(f"{name}, {agents} agents: {mean:.0f} us a cycle (95 %: {worst:.0f}), {each:.2f} us for an object and agent")


def main() -> None:
    """Print the table."""
    raw_senses()
    rng = np.random.default_rng(0)
    objects = {"ball": "Ball", **{f"o{k}": "Opponent" for k in range(1, 12)}}
    world = Grounding(Model("scene", (thing("Ball"), thing("Opponent"))), objects)
    for agents in (1, 250):
        told = [{f"{n}.{a}": m + s * rng.normal(size=agents) for n in objects for a, m, s in (("dist", 17.0, 0.3), ("dir", 45.0, 1.0))}
                for _ in range(120)]  # fmt: skip
        spent = microseconds(Filter(world, batch=agents, engine="mixture"), told)
        print(f"ball and 11 opponents, {agents} agents: {spent:.0f} us a step, {spent / 12 / agents:.2f} us for an object and agent")
    modes = Grounding(ball_model(DEFAULT, Senses(), BallConstants()), {"ball": "Ball"})
    own = {f"ball.me_{name}": 0.0 for name in SELF}
    for agents in (1, 250):
        told = []
        for _ in range(120):
            far = 12.0 + rng.normal(size=agents)
            told.append({"ball.seen_far": Interval(far - 0.6, far + 0.6), "ball.seen_aside": Interval(0 * far - 0.1, 0 * far + 0.1),
                         "ball.seen_approach": 0.1 * rng.normal(size=agents), "ball.seen_swing": 0.1 * rng.normal(size=agents),
                         "ball.told_far": far, **own})  # fmt: skip
        spent = microseconds(Filter(modes, batch=agents, engine=MixtureEngine(COMPONENTS, MERGE)), told)
        print(f"ball with modes and intervals, {agents} agents: {spent:.0f} us a step, {spent / agents:.2f} us for an agent")


if __name__ == "__main__":
    main()
