"""A journal knows what it is of: another chain, environment or policy is refused."""

import functools

import numpy as np
import pytest

from cprm_gym.agents.worlds.runs import StageRuns
from cprm_gym.architecture.analysis.markov.generators import walk_chain
from cprm_gym.architecture.analysis.sampling.gymnasium_runs import GymnasiumRuns
from cprm_gym.architecture.analysis.sampling.identity import fingerprint
from cprm_gym.architecture.analysis.sampling.runs import ChainRuns
from cprm_gym.architecture.analysis.sampling.sample import sample
from cprm_gym.errors import FormatError, ModelError


def left(observation, rng):
    return 0


def right(observation, rng):
    return 1


class Table:
    """A policy with numbers."""

    def __init__(self, numbers):
        self.numbers = np.asarray(numbers, float)

    def __call__(self, observation, rng):
        return int(self.numbers @ np.asarray(observation) > 0)


def biased(by):
    return lambda observation, rng: int(rng.random() < by)


OTHERS = {
    "chain": (ChainRuns(walk_chain(10, 0.45)), ChainRuns(walk_chain(10, 0.46))),
    "limit": (ChainRuns(walk_chain(10, 0.45)), ChainRuns(walk_chain(10, 0.45), limit=50)),
    "environment": (GymnasiumRuns("CartPole-v1"), GymnasiumRuns("CartPole-v0")),
    "options": (GymnasiumRuns("CartPole-v1"), GymnasiumRuns("CartPole-v1", options={"sutton_barto_reward": True})),
    "function": (GymnasiumRuns("CartPole-v1", left), GymnasiumRuns("CartPole-v1", right)),
    "closure": (GymnasiumRuns("CartPole-v1", biased(0.4)), GymnasiumRuns("CartPole-v1", biased(0.5))),
    "numbers": (GymnasiumRuns("CartPole-v1", Table([0, 0, 1, 0])), GymnasiumRuns("CartPole-v1", Table([0, 0, 1, 1]))),
    "partial": (GymnasiumRuns("CartPole-v1", functools.partial(left)), GymnasiumRuns("CartPole-v1", functools.partial(right))),
    "behaviour": (StageRuns("go_to_ball"), StageRuns("approach")),
}


@pytest.mark.parametrize("what", OTHERS)
def test_a_journal_of_another_thing_is_refused(what, tmp_path):
    one, other = OTHERS[what]
    assert fingerprint(one) == fingerprint(one) != fingerprint(other)
    if what == "behaviour":
        return
    sample(one, 20, block=10, journal=tmp_path / "runs.jsonl")
    with pytest.raises(FormatError, match="another sample"):
        sample(other, 20, block=10, journal=tmp_path / "runs.jsonl")
    assert sample(one, 20, block=10, journal=tmp_path / "runs.jsonl").runs == 20


def test_the_same_thing_made_again_is_the_same():
    assert fingerprint(GymnasiumRuns("CartPole-v1", Table([0, 1]))) == fingerprint(GymnasiumRuns("CartPole-v1", Table([0, 1])))
    assert fingerprint(biased(0.4)) == fingerprint(biased(0.4))
    assert fingerprint({1, 2, 3}) == fingerprint({3, 2, 1})
    around = [1]
    around.append(around)
    assert fingerprint(around) == fingerprint(around)


def test_what_keeps_its_inside_to_itself_needs_a_name(tmp_path):
    class Named:
        identity = "the third network"

    with open(tmp_path / "x", "w") as file, pytest.raises(ModelError, match="attribute `identity`"):
        fingerprint(file)
    Other = type("Named", (Named,), {"identity": "the fourth network", "__qualname__": Named.__qualname__, "__module__": Named.__module__})
    assert fingerprint(Named()) != fingerprint(Other())
