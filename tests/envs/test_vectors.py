"""The feature vectors: equal to plain formulas over angles, world by world whatever the others do."""

import numpy as np
import pytest
from slow_presets import SlowPreset

from cprm_gym.envs.core import BLOCK, SoccerCore
from cprm_gym.envs.tasks import make_task

PRESETS = ("hfo_low", "hfo_high", "keepaway")


def random_actions(rng, core):
    shape = (core.worlds, len(core.agents))
    return {"type": rng.integers(0, 4, shape), "params": rng.uniform(-1, 1, (*shape, 4))}


def seen_by(core):
    return core.output if isinstance(core.output, np.ndarray) else core.output["players"]


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize(
    ("task", "options"),
    [("Soccer11v11", {}), ("HFO2v2", {"full_state": True}), ("Keepaway3v2", {}), ("GoToBall", {})],
)
def test_vectors_equal_the_formulas(preset, task, options):
    core = SoccerCore(make_task(task, max_cycles=10**9, **options), 6, observation=preset)
    core.reset(3)
    slow, rng = SlowPreset(core), np.random.default_rng(1)
    np.testing.assert_allclose(core.output, slow(core), atol=1e-6)
    for _ in range(80):
        core.step(random_actions(rng, core))
        np.testing.assert_allclose(core.output, slow(core), atol=1e-6)


def test_goal_openings_equal_the_formulas_wherever_everybody_stands():
    core = SoccerCore(make_task("Soccer", left=3, right=3, full_state=True, max_cycles=10**9), 40, observation="hfo_high")
    core.reset(1)
    slow, rng = SlowPreset(core), np.random.default_rng(2)
    middle = 0.0
    for k in range(60):
        places = rng.uniform((35.0, -12.0), (54.0, 12.0), (40, 7, 2))
        if k == 0:
            places[:, 1] = places[:, 4]  # one on top of another
        core.sim.world["pos"][:, [0, 1, 2, 3, 12, 13, 14]] = places
        core.observe()
        np.testing.assert_allclose(core.output, slow(core), atol=1e-6)
        opening = core.output[..., core.preset.names.index("goal_opening")]
        middle += np.mean((opening > -1.0) & (opening < 1.0))
    assert middle > 30, "most look at a goal of which something is covered"


@pytest.mark.parametrize("preset", ["raw", *PRESETS])
def test_a_world_is_told_the_same_whatever_the_others_do(preset):
    """Others of the batch begin anew in most cycles, in blocks of their own and in its block; it is alone, or shared by two threads."""
    task, count, mine = make_task("Soccer", left=2, right=2, max_cycles=10**9), BLOCK + 3, BLOCK + 1
    options = {"observation": preset, "others": "medium", "controlled": "left"}
    many, threaded = SoccerCore(task, count, **options), SoccerCore(task, count, threads=2, **options)
    alone = SoccerCore(task, 1, first_world=mine, **options)
    rng = np.random.default_rng(5)
    for core in (many, threaded, alone):
        core.reset(7)
        core.sim.world["mode"] = 3
    for cycle in range(60):
        actions = random_actions(rng, many)
        for core in (many, threaded):
            core.step(actions)
            core.reset(None, np.array([k for k in range(count) if k != mine and (k + cycle) % 4 == 0]))
        alone.step({name: values[[mine]] for name, values in actions.items()})
        for core in (many, threaded):
            np.testing.assert_array_equal(seen_by(core)[mine], seen_by(alone)[0])
            assert core.sim.state_hash([mine]) == alone.sim.state_hash()


def test_a_reset_leaves_the_observations_of_other_worlds_alone():
    core = SoccerCore(make_task("GoToBall"), BLOCK + 4, observation="hfo_low")
    core.reset(1)
    core.step({"type": np.full((core.worlds, 1), 2), "params": np.zeros((core.worlds, 1, 4))})
    before = core.output.copy()
    core.reset(None, np.array([2, BLOCK + 1]))
    changed = (core.output != before).any(axis=(1, 2))
    assert np.flatnonzero(changed).tolist() == [2, BLOCK + 1]


def test_a_kick_that_had_an_effect_stays_one_when_another_world_begins_anew():
    core = SoccerCore(make_task("Soccer", left=1, right=0, max_cycles=10**9), 2, observation="hfo_low", controlled="left_1")
    core.reset(1)
    core.sim.world["mode"] = 3
    core.sim.world["pos"][:, 1] = core.sim.world["pos"][:, 0]
    core.step({"type": np.full((2, 1), 3), "params": np.full((2, 1, 4), 0.5)})
    possible = core.preset.names.index("last_action_possible")
    assert core.output[1, 0, possible] == 1.0
    core.reset(None, np.array([0]))
    assert core.output[1, 0, possible] == 1.0


def test_a_saved_state_goes_on_with_the_same_vectors():
    core = SoccerCore(make_task("Soccer11v11", max_cycles=10**9), 2, observation="hfo_high")
    core.reset(1)
    rng = np.random.default_rng(1)
    for _ in range(7):
        core.step(random_actions(rng, core))
    state, told = core.save_state(), []
    actions = [random_actions(rng, core) for _ in range(4)]
    for _ in range(2):
        for action in actions:
            core.step(action)
        told.append(core.output.copy())
        core.load_state(state)
    np.testing.assert_array_equal(*told)
