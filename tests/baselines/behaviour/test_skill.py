"""A skill read off a net does what the net does: the same commands on the same percepts, cycle by cycle."""

import numpy as np
import pytest
from cprm_baselines.behaviour.sheet import Sheet
from cprm_baselines.behaviour.skill import Skill

from cprm_gym.agents.skills.accelerate import accelerate
from cprm_gym.agents.skills.advance import advance
from cprm_gym.agents.skills.approach import approach
from cprm_gym.agents.skills.catch_ball import catch_ball
from cprm_gym.agents.skills.clear import clear
from cprm_gym.agents.skills.cruise import cruise
from cprm_gym.agents.skills.dribble import dribble
from cprm_gym.agents.skills.drive import drive
from cprm_gym.agents.skills.go_to_ball import go_to_ball_reflex
from cprm_gym.agents.skills.intercept import intercept
from cprm_gym.agents.skills.kick import kick
from cprm_gym.agents.skills.look_out import look_out
from cprm_gym.agents.skills.meet_ball import meet_ball
from cprm_gym.agents.skills.orient import orient
from cprm_gym.agents.skills.pass_ball import pass_ball
from cprm_gym.agents.skills.receive import receive
from cprm_gym.agents.skills.reposition import reposition
from cprm_gym.agents.skills.setup import setup
from cprm_gym.agents.skills.shoot import shoot
from cprm_gym.agents.skills.slow import slow
from cprm_gym.agents.skills.watch_ball import watch_ball
from cprm_gym.architecture.cprm import CPRM, CPRMRunner
from cprm_gym.architecture.petri import Continuous, Input, PetriNet, Place, Ports, Transition
from cprm_gym.errors import ModelError

SKILLS = (
    accelerate, advance, approach, catch_ball, clear, cruise, dribble, drive, go_to_ball_reflex, intercept, kick, look_out, meet_ball,
    orient, pass_ball, receive, reposition, setup, shoot, slow, watch_ball,
)  # fmt: skip
WORLDS, CYCLES = 40, 150
FLAGS = ("seen", "fresh", "moving", "waiting", "playing", "stopped", "coming", "behind")


def draw(name, rng):
    """Values of a quantity that matter to thresholds, held for a while so that counters count."""
    last = name.rpartition(".")[2]
    if last in FLAGS:
        return (rng.random(WORLDS) < 0.7).astype(float)
    if "direction" in last or "bearing" in last or last in ("facing_deg", "gaze", "flank", "side_turn", "neck_deg"):
        return rng.choice([rng.uniform(-180, 180, WORLDS), rng.uniform(-20, 20, WORLDS)])
    if "age" in last:
        return rng.choice([0.0, 1.0, 2.0, 5.0, 14.0], WORLDS)
    if "stamina" in last:
        return rng.uniform(1000, 8000, WORLDS)
    if "speed" in last or last in ("vx", "vy", "approach", "distance_change"):
        return rng.uniform(-0.2, 1.0, WORLDS)
    return rng.choice([rng.uniform(0.2, 1.4, WORLDS), rng.uniform(0.2, 12, WORLDS), rng.uniform(5, 30, WORLDS)])


def observed(net):
    """Quantities that a net and its modules observe."""
    own = {p.observes for p in net.places if isinstance(p, Input)}
    return own.union(*(observed(module) for module in net.modules.values()))


@pytest.mark.parametrize("make", SKILLS, ids=lambda make: make.__name__)
def test_a_skill_sends_what_its_net_sends(make):
    net = make()
    parameters = [p for p in net.places if isinstance(p, Continuous) and p.name in net.ports.parameters]
    outcomes = [o for o in (net.ports.done, *net.ports.errors) if o is not None]
    around = PetriNet(
        "around",
        places=(Place("idle", capacity=1, tokens=1), *(Input(p.name, observes=p.name) for p in parameters)),
        modules={"skill": net},
        fuse={f"skill.{p.name}": p.name for p in parameters},
        transitions=(
            Transition("begin", ("idle",), ("skill.begin",)),
            *(Transition(f"after_{o}", (f"skill.{o}",), ("idle",), delay=1) for o in outcomes),
        ),
    )
    runner = CPRMRunner(CPRM("around", net=around), WORLDS)
    sheet = Sheet()
    skill = Skill("skill", net, sheet, {p.name: sheet.observe(p.name) for p in parameters})
    sheet.begin(WORLDS)
    state = skill.begun(WORLDS)
    rng = np.random.default_rng(1)
    names = sorted(observed(around))
    percepts = {name: draw(name, rng) for name in names}
    sent = 0
    for cycle in range(CYCLES):
        for name in names:
            renewed = rng.random(WORLDS) < 0.25
            percepts[name] = np.where(renewed, draw(name, rng), percepts[name])
        commands = runner.step(percepts)
        sheet.fill(percepts)
        step = skill.advance(state)
        sheet.derive_all()
        for number, (command, params) in enumerate(skill.commands):
            mine = step.emits == number
            if not mine.any():
                continue
            assert (commands.fired[command][mine]).all(), (cycle, command)
            for key, value in params.items():
                told = sheet[value][mine] if isinstance(value, str) else value
                np.testing.assert_allclose(commands.values[command][key][mine], told, atol=1e-9, err_msg=f"{cycle} {command} {key}")
            sent += int(mine.sum())
        quiet = step.emits < 0
        for command in commands.fired:
            assert not commands.fired[command][quiet].any(), (cycle, command)
        state = step.state
        state.take(step.outcome >= 0, skill.begun(WORLDS))  # the net around takes the outcome a cycle later, and begins it again then
    assert sent > 50


def test_a_net_of_two_tokens_is_no_machine():
    net = PetriNet(
        "two",
        ports=Ports(begin="begin", ongoing="ongoing", done="done"),
        places=tuple(Place(name, capacity=1) for name in ("begin", "ongoing", "done", "a", "b")),
        transitions=(Transition("start", ("begin",), ("ongoing", "a", "b")), Transition("end", ("ongoing", "a", "b"), ("done",))),
    )
    with pytest.raises(ModelError, match="a machine is in one"):
        Skill("two", net, Sheet(), {})
