"""What a relation has linked, once it no longer does: apart by its marginals, with the loss told, against normals by hand and fine bins."""

import numpy as np
import pytest
from scipy import stats

from cprm_gym.architecture.prm import (
    BOOL,
    Attribute,
    Chance,
    Filter,
    Grounding,
    Model,
    Noise,
    PRMClass,
    Real,
    Relation,
    Replace,
    Switch,
    Table,
)
from cprm_gym.architecture.prm.inference.engines.mixture import MixtureEngine
from cprm_gym.errors import ParameterError

HOLDS = ["holds(o,b)"]


def scene(*more, ball="b.x", mean="o.x", sd=0.3):
    """A player and a ball that wander by themselves, each seen with noise; while he holds it, it is where he is."""

    def thing(name, *extra):
        return PRMClass(name, (
            Attribute("x", Real("m"), Noise("prev.x", sd=0.5), ("prev.x",), initial=Noise("0", sd=2.0)),
            Attribute("z", Real("m"), Noise("x", sd=0.4), ("x",)),
            *extra,
        ))  # fmt: skip

    holds = Relation("holds", {"o": "Player", "b": "Ball"}, changes=(Replace(ball, (mean,), Noise(mean, sd=sd)),))
    return Grounding(Model("scene", (thing("Player", *more), thing("Ball")), (holds,)), {"o": "Player", "b": "Ball"})


def test_linear_parts_go_on_by_their_marginals_and_the_loss_is_their_information():
    world = scene()
    kept, parted = Filter(world, engine=MixtureEngine()), Filter(world, engine=MixtureEngine(split=10.0))
    held = [filter.step({"o.z": 1.0}, relations=HOLDS) for filter in (kept, parted)]
    _, cov = held[0].moments("o.x", "b.x")
    c = cov[0]
    alone, together = parted.step({"o.z": 2.0}), kept.step({"o.z": 2.0})
    assert alone.loss[0] == pytest.approx(0.5 * np.log(c[0, 0] * c[1, 1] / np.linalg.det(c)), abs=1e-9)
    assert sizes(alone) == [1, 1]
    assert together.loss[0] == 0.0
    assert sizes(together) == [2]
    # the reading of the player moves him as before, and the ball no more
    assert alone.read("o.x")[0] == pytest.approx(together.read("o.x")[0], abs=1e-12)
    assert alone.read("b.x")[0] == pytest.approx(kept_ball(1.0), abs=1e-12)
    assert together.read("b.x")[0] > alone.read("b.x")[0] + 0.2


def sizes(posterior):
    return sorted(len(part) for part in posterior.result.report["parts"])


def kept_ball(z):
    """Mean of the ball after one reading of who holds it."""
    return z * 4.0 / (4.0 + 0.16)


def test_more_than_is_allowed_is_not_lost_and_agents_stay_together():
    world = scene()
    filter = Filter(world, batch=2, engine=MixtureEngine(split=0.05))
    filter.step({"o.z": 1.0}, relations=HOLDS)
    for _ in range(2):  # of the agent who reads nothing, too much would be lost
        seen = filter.step({"o.z": np.array([1.0, np.nan]), "b.z": np.array([1.0, np.nan])})
        assert sizes(seen) == [2]
        assert not seen.loss.any()
    seen = filter.step({})  # both have wandered since
    assert sizes(seen) == [1, 1]
    assert (seen.loss > 0.0).all()
    assert (seen.loss <= 0.05).all()
    with pytest.raises(ParameterError, match="`split` is a loss in nats"):
        MixtureEngine(split=-1.0)


def test_attributes_that_a_later_reading_links_again_find_each_other():
    world = scene()
    filter = Filter(world, engine=MixtureEngine(split=10.0))
    filter.step({"o.z": 1.0}, relations=HOLDS)
    filter.step({})
    again = filter.step({"o.z": 3.0}, relations=HOLDS)
    mean, cov = again.moments("o.x", "b.x")
    assert mean[0, 1] == pytest.approx(mean[0, 0], abs=1e-12)
    assert cov[0, 0, 1] == pytest.approx(cov[0, 0, 0], abs=1e-12)


def on_grid(readings, shows, split):
    """Player and ball on fine bins, the ball's side of the joint last; what the product of the marginals loses."""
    x = np.linspace(-9.0, 9.0, 361)
    move = stats.norm(0.0, 0.5).pdf(x[:, None] - x)
    move /= move.sum(axis=0)
    weight = stats.norm(0, 2).pdf(x)
    lasting = np.array([[0.8, 0.2], [0.2, 0.8]])
    # modes of the first slice: (mode, player, ball)
    hold = np.stack([stats.norm(x, sd).pdf(x[:, None]).T for sd in (0.2, 1.5)])
    hold /= hold.sum(axis=2, keepdims=True)
    joint = 0.5 * weight[None, :, None] * hold
    joint *= stats.norm(x, 0.4).pdf(readings[0])[None, :, None]
    joint *= np.where(shows[0], shown(x), 1.0 - shown(x))[None, :, None]
    joint /= joint.sum()
    lost = 0.0
    if split:
        one, other = joint.sum(axis=2), joint.sum(axis=(0, 1))
        apart = one[:, :, None] * other
        there = joint > 0
        lost = float((joint[there] * np.log(joint[there] / apart[there])).sum())
        joint = apart
    joint = np.einsum("mn,mij->nij", lasting, joint)
    joint = np.einsum("ai,mij->maj", move, joint)
    joint = np.einsum("bj,maj->mab", move, joint)
    joint *= stats.norm(x, 0.4).pdf(readings[1])[None, :, None]
    joint *= np.where(shows[1], shown(x), 1.0 - shown(x))[None, :, None]
    joint /= joint.sum()
    return x, joint, lost


def shown(x):
    return 1.0 / (1.0 + np.exp(-x))


@pytest.mark.parametrize("split", [0.0, 5.0])
def test_with_modes_and_chances_it_is_near_fine_bins_and_the_loss_is_a_bound(split):
    """He holds it closely or loosely, which is not told, and a chance tells on which side he is."""
    mode = Attribute("loose", BOOL, Table({("no",): (0.8, 0.2), ("yes",): (0.2, 0.8)}), ("prev.loose",), initial=Table({(): (0.5, 0.5)}))
    side = Attribute("right", BOOL, Chance("1 / (1 + exp(-x))"), ("x",))
    plain = scene(mode, side)
    ways = Switch("o.loose", {"no": Noise("o.x", sd=0.2), "yes": Noise("o.x", sd=1.5)})
    holds = Relation("holds", {"o": "Player", "b": "Ball"}, changes=(Replace("b.x", ("o.x", "o.loose"), ways),))
    world = Grounding(Model("scene", plain.model.classes, (holds,)), {"o": "Player", "b": "Ball"})
    filter = Filter(world, engine=MixtureEngine(64, split=split))
    filter.step({"o.z": 1.5, "o.right": "yes"}, relations=HOLDS)
    found = filter.step({"o.z": -1.0, "o.right": "no"})
    x, joint, lost = on_grid((1.5, -1.0), (True, False), bool(split))
    for name, axis in (("o.x", (0, 2)), ("b.x", (0, 1))):
        marginal = joint.sum(axis=axis)
        mean = marginal @ x
        assert found.read(name)[0] == pytest.approx(mean, abs=0.01)
        assert found.read(name, "deviation")[0] == pytest.approx(np.sqrt(marginal @ (x - mean) ** 2), abs=0.01)
    assert found["o.loose"][0, 1] == pytest.approx(joint[1].sum(), abs=0.01)
    if split:
        assert lost - 0.01 < found.loss[0] < lost + np.log(2.0)
