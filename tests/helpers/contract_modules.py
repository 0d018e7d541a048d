"""A behaviour module that keeps its contract, and the same module broken in one place at a time."""

from __future__ import annotations

from dataclasses import replace

from cprm_gym.architecture.petri import Belief, Command, Input, Math, PetriNet, Place, Ports, Transition

CLEAN = {"turns": 0, "watching": 0}


def turn_to_ball(**ports: object) -> PetriNet:
    """Turn until the ball is ahead, at most five times; a second thread watches whether it is still seen."""
    return PetriNet(
        "turn_to_ball",
        ports=Ports(
            begin="begin", ongoing="ongoing", done="facing", errors=("failed", "lost_ball"), interrupts=("abort",),
            answers={"abort": ("failed",)}, **ports,
        ),
        places=(
            *(Place(p, capacity=1) for p in ("begin", "ongoing", "facing", "failed", "lost_ball", "abort", "watching")),
            Place("turns", capacity=5),
            Input("ball_seen", observes="ball.seen"),
            Belief("bearing", variable="ball.direction"),
            Math("off_axis", "abs(bearing)"),
            Math("moment", "clip(0.9 * bearing, -180, 180)"),
        ),
        transitions=(
            Transition("stop", ("abort", "ongoing"), ("failed",), sets=CLEAN, priority=10),
            Transition("drop", ("abort",), inhibitors=("ongoing",), priority=10),
            Transition("start", ("begin",), ("ongoing", "watching")),
            Transition(
                "turn", ("ongoing",), ("ongoing", "turns"), delay=1, tests={"off_axis": 3.0}, inhibitors={"turns": 5},
                emits=Command("turn", moment="moment"),
            ),
            Transition("arrive", ("ongoing", "watching"), ("facing",), inhibitors={"off_axis": 3.0}, sets=CLEAN),
            Transition("give_up", ("ongoing",), ("failed",), tests={"turns": 5, "off_axis": 3.0}, sets=CLEAN),
            Transition("lose", ("watching",), ("lost_ball",), inhibitors=("ball_seen",), sets={**CLEAN, "ongoing": 0}, delay=2),
        ),
    )  # fmt: skip


def changed(net: PetriNet, name: str, **fields: object) -> PetriNet:
    """The net with one transition changed."""
    rest = {k: getattr(net.transition(name), k) for k in Transition.__dataclass_fields__}
    new = Transition(rest.pop("name"), rest.pop("inputs"), rest.pop("outputs"), **rest)
    values = {k: getattr(new, k) for k in Transition.__dataclass_fields__} | fields
    new = Transition(values.pop("name"), values.pop("inputs"), values.pop("outputs"), **values)
    return replace(net, transitions=tuple(new if t.name == name else t for t in net.transitions))


def added(net: PetriNet, *parts: Place | Transition) -> PetriNet:
    """The net with more places and transitions."""
    return replace(
        net,
        places=net.places + tuple(p for p in parts if isinstance(p, Place)),
        transitions=net.transitions + tuple(t for t in parts if isinstance(t, Transition)),
    )


def without(net: PetriNet, name: str) -> PetriNet:
    """The net without one transition."""
    return replace(net, transitions=tuple(t for t in net.transitions if t.name != name))


def broken() -> dict[str, tuple[PetriNet, str]]:
    """Name of the fault -> the broken module and the clause that it breaks."""
    m = turn_to_ball()
    return {
        "starts late": (changed(m, "start", delay=1), "start"),
        "never starts unless the ball is seen": (changed(m, "start", tests={"ball_seen": 1}), "start"),
        "skips ongoing": (added(m, Transition("at_once", ("begin",), ("facing",), tests={"ball_seen": 1}, priority=1)), "start"),
        "two outcomes": (changed(m, "arrive", outputs=("facing", "failed")), "exclusive end"),
        "ongoing stays": (changed(m, "arrive", outputs=("facing", "ongoing"), sets={"turns": 0}), "exclusive end"),
        "vanishes": (changed(m, "give_up", outputs=()), "exclusive end"),
        "counter not reset": (changed(m, "give_up", sets={"watching": 0}), "clean"),
        "thread left behind": (changed(m, "give_up", sets={"turns": 0}), "clean"),
        "ignores the abort": (without(m, "stop"), "interruption"),
        "answers the abort too late": (changed(m, "stop", delay=2), "interruption"),
        "answers the abort with success": (changed(m, "stop", outputs=("facing",)), "interruption"),
        "keeps an idle abort": (without(m, "drop"), "idle interrupt"),
        "acts while idle": (
            added(m, Place("clock", capacity=1, tokens=1), Transition("tick", ("clock",), ("clock",), delay=3)),
            "no spontaneous activity",
        ),
        "fills a place": (changed(added(m, Place("diary")), "turn", outputs=("ongoing", "diary"), inhibitors={}), "bounded"),
        "cannot end": (
            added(
                changed(added(m, Place("pit", capacity=1)), "stop", inhibitors=("pit",)),
                Transition("fall", ("watching", "ongoing"), ("pit", "ongoing"), tests={"off_axis": 90.0}, priority=1),
                Transition("struggle", ("turns",), (), tests=("pit",)),
            ),
            "may end",
        ),
        "never quiet": (
            added(m, Place("spin", capacity=1), Transition("a", ("watching",), ("spin",)), Transition("b", ("spin",), ("watching",))),
            "becomes quiet",
        ),
    }  # fmt: skip
