"""A module that turns to the ball, and a net that uses it twice."""

from cprm_gym.architecture.petri import Belief, Command, Input, Math, PetriNet, Place, Ports, Transition

ORIENT = PetriNet(
    "orient",
    ports=Ports(begin="begin", ongoing="ongoing", done="facing", errors=("failed",), interrupts=("abort",), outputs=("off_axis",)),
    places=(
        Place("begin", 1), Place("ongoing", 1), Place("facing", 1), Place("failed", 1), Place("abort", 1),
        Place("turns", capacity=5),
        Input("ball_seen", observes="ball.seen"), Input("speed", observes="body.speed"),
        Belief("bearing", variable="ball.direction"),
        Math("off_axis", "abs(bearing)"),
        Math("moment", "clip(0.9 * bearing * (1 + 5 * speed), -180, 180)"),
    ),
    transitions=(
        Transition("start", ("begin",), ("ongoing",), sets={"turns": 0}),
        Transition("turn", ("ongoing",), ("ongoing", "turns"), delay=1, tests={"off_axis": 3.0, "ball_seen": 1}, inhibitors={"turns": 5},
                   emits=Command("turn", moment="moment")),
        Transition("arrive", ("ongoing",), ("facing",), inhibitors={"off_axis": 3.0}),
        Transition("give_up", ("ongoing",), ("failed",), tests={"turns": 5, "off_axis": 3.0}),
        Transition("stop", ("abort", "ongoing"), ("failed",), priority=10),
        Transition("ignore", ("abort",), inhibitors=("ongoing",), priority=9),
    ),
)  # fmt: skip

TWICE = PetriNet(
    "twice",
    places=(Place("go", 1, 1), Place("over", 1)),
    modules={"first": ORIENT, "second": ORIENT},
    fuse={"first.begin": "go"},
    transitions=(
        Transition("next", ("first.facing",), ("second.begin",)),
        Transition("end", ("second.facing",), ("over",)),
        Transition("worry", tests={"first.off_axis": 90}, outputs=("first.abort",), inhibitors=("first.abort", "over"), delay=1),
    ),
)
