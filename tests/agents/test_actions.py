"""Actions that a kernel makes of commands are those by formulas over whole arrays."""

import numpy as np

from cprm_gym.agents.body import DEFAULT
from cprm_gym.agents.kernels import actions as kernels
from cprm_gym.agents.play import ACTION, BODY_COMMANDS, sending
from cprm_gym.architecture.petri import Command, Input, PetriNet, Place, Transition
from cprm_gym.architecture.petri.execution.executor import Executor
from cprm_gym.envs.actions import NECK_SCALE, scaled
from cprm_gym.envs.controller import no_action
from cprm_gym.simulator.state import CommandKind

SIDE = {"turn_neck": ("moment",), "look": ("direction",), "change_view": ("width",)}


def sender():
    """A net that may send every command."""
    commands = {**{name: keys for name, (_, keys) in BODY_COMMANDS.items()}, **SIDE}
    keys = sorted({key for parts in commands.values() for key in parts})
    return PetriNet(
        "sender",
        places=(Place("ready", capacity=1, tokens=1), *(Input(key, observes=key) for key in keys)),
        transitions=tuple(
            Transition(f"say_{name}", ("ready",), ("ready",), delay=1, emits=Command(name, **{key: key for key in parts}))
            for name, parts in commands.items()
        ),
    )


def by_arrays(executor, fired, value, speed, neck):
    """As it was done before, one command after the other."""
    action, count = no_action(len(fired)), len(fired)
    turned = np.zeros(count)

    def sent(name):
        values = {key: value[:, column] for key, column in executor.parameters(name).items()}
        return fired[:, executor.command_names.index(name)], values

    for name, (kind, keys) in BODY_COMMANDS.items():
        went, values = sent(name)
        action["type"][went] = kind
        action["params"][went] = scaled(np.full(count, int(kind)), *(values[key] for key in keys))[went]
        if name == "turn":
            turned = np.where(went, values["moment"] / (1.0 + DEFAULT.kind.inertia_moment * speed), 0.0)
    went, values = sent("turn_neck")
    action["turn_neck"][went, 0] = np.clip(values["moment"] / NECK_SCALE, -1.0, 1.0)[went]
    went, values = sent("look")
    wanted = (values["direction"] - turned + 180.0) % 360.0 - 180.0
    angle = (np.clip(wanted, DEFAULT.server.minneckang, DEFAULT.server.maxneckang) - neck) / NECK_SCALE
    action["turn_neck"][went, 0] = np.clip(angle, -1.0, 1.0)[went]
    went, values = sent("change_view")
    action["view"][went] = np.rint(values["width"][went]).astype(np.int64)
    return action, turned


def test_commands_become_the_actions_that_formulas_over_arrays_make():
    executor, rng, count = Executor(sender(), 400), np.random.default_rng(0), 400
    fired = np.zeros(executor.sent[0].shape, bool)
    body = [executor.command_names.index(name) for name in BODY_COMMANDS]
    fired[np.arange(count), rng.choice(body, count)] = rng.random(count) < 0.9
    for name in SIDE:
        fired[:, executor.command_names.index(name)] = rng.random(count) < 0.5
    value = rng.normal(0.0, 80.0, executor.sent[1].shape)
    value[:, executor.parameters("change_view")["width"]] = rng.integers(0, 4, count)
    speed, neck = rng.random(count), rng.uniform(-90.0, 90.0, count)
    action, turned = no_action(count), np.empty(count)
    sends = sending(executor, DEFAULT)
    kernels.act(*sends, fired, value, speed, neck, int(CommandKind.TURN), *(action[key] for key in ACTION), turned)
    wanted, turns = by_arrays(executor, fired, value, speed, neck)
    for key, values in wanted.items():
        np.testing.assert_array_equal(action[key], values, err_msg=key)
    np.testing.assert_array_equal(turned, turns)
    assert len(np.unique(action["type"])) == 1 + len(BODY_COMMANDS)
