"""What a step of the Gaussian mixture engine costs: ``python tests/benchmarks/bench_real_numbers.py``.

CPU time of this process, medians over 100 steps. A ball and eleven players, each with place and velocity in real numbers, distance and
direction of all of them read in every step; and the ball of `cprm_gym.agents.knowledge.ball` with its modes.
"""

from __future__ import annotations

from time import process_time

import numpy as np

from cprm_gym.agents.body import DEFAULT
from cprm_gym.agents.knowledge.ball import SELF, BallConstants, ball_model
from cprm_gym.architecture.prm import Angle, Attribute, Filter, Grounding, Interval, Model, Noise, PRMClass, Real
from cprm_gym.architecture.prm.inference.engines.mixture import MixtureEngine
from cprm_gym.envs.players.senses import Senses


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


def main() -> None:
    """Print the table."""
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
        spent = microseconds(Filter(modes, batch=agents, engine=MixtureEngine(6, 1e-3)), told)
        print(f"ball with modes and intervals, {agents} agents: {spent:.0f} us a step, {spent / agents:.2f} us for an agent")


if __name__ == "__main__":
    main()
