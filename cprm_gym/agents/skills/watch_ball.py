"""watch_ball: keep the eyes on the ball beside whatever the body does, and say when it is coming (dissertation §2.3.5, §4.3).

    begin --> [start] --> ongoing + open
    open --> [follow | sweep] --> moved --(one cycle)--> open           one turn of the neck per cycle
    open & coming ------> [warn] --> open + ball_coming                 the output holds a token while the ball is coming
    ball_coming & not --> [calm]
    stop ---------------> [close] --> stopped
    lid --> [narrow | widen] --> lid_moved --(one cycle)--> lid          where it is wanted, beside all of it

The neck points where the ball is believed to be. If the last looks did not show it, or the first one of all, the neck sweeps from side
to side, as far as the cone is wide. The skill moves nothing but the neck, so it runs concurrently with skills that move the body.

With `focus` the view is narrow, and there is a look in every cycle, while looks show the ball; a look that does not widens it again.
"""

from __future__ import annotations

from ...architecture.petri import AnyPlace, Command, Continuous, Input, Math, PetriNet, Place, Ports, Transition
from ...simulator.state import ViewWidth
from ..body import Body, number, of_body

LOOKS = 4
"""Looks in a row without the ball after which the neck sweeps."""
NARROW_CONE = 60
"""Degrees that the narrow cone shows."""


def _lid(focus: bool) -> tuple[tuple[AnyPlace, ...], tuple[Transition, ...]]:
    """Places and transitions that change the width of the view; none without `focus`."""
    if not focus:
        return (), ()
    places = (
        Place("lid", capacity=1), Place("lid_moved", capacity=1),
        Continuous("narrow_width", float(ViewWidth.NARROW)), Continuous("normal_width", float(ViewWidth.NORMAL)),
    )  # fmt: skip
    transitions = (
        Transition("narrow", ("lid",), ("lid_moved",), tests={"seen": 1, "width": int(ViewWidth.NORMAL)},
                   emits=Command("change_view", width="narrow_width"), priority=3),
        Transition("widen", ("lid",), ("lid_moved",), tests={"fresh": 1}, inhibitors={"seen": 1, "width": int(ViewWidth.NORMAL)},
                   emits=Command("change_view", width="normal_width"), priority=3),
        Transition("leave_lid", ("lid",), ("lid_moved",), priority=-1),
        Transition("lift", ("lid_moved",), ("lid",), delay=1),
    )  # fmt: skip
    return places, transitions


@of_body
def watch_ball(body: Body, focus: bool = False) -> PetriNet:
    """The skill of a player as a module; it goes on until it is stopped."""
    lid, lids = _lid(focus)
    begun = ("ongoing", "open", *(("lid",) if focus else ()))
    shut = {"missed": 0, "ball_coming": 0}
    shut |= {"lid": 0, "lid_moved": 0} if focus else {}
    return PetriNet(
        "watch_ball",
        ports=Ports(
            begin="begin", ongoing="ongoing", errors=("stopped",), interrupts=("stop",), outputs=("ball_coming",),
            parameters=("ball_direction", "coming"),
        ),
        places=(
            Place("begin", capacity=1), Place("ongoing", capacity=1), Place("stopped", capacity=1), Place("stop", capacity=1),
            Place("ball_coming", capacity=1), Place("open", capacity=1), Place("moved", capacity=1),
            Place("missed", capacity=LOOKS),  # looks in a row without the ball
            Continuous("ball_direction"),  # degrees from the body, believed
            Continuous("coming"),  # 1 while the ball is a danger
            Input("seen", observes="ball.seen"), Input("fresh", observes="body.fresh"), Input("neck", observes="body.neck_deg"),
            Input("width", observes="body.view_width"),
            *lid,
            # so far that the cone ends where it began before
            Math("aside", f"{NARROW_CONE} if width < {int(ViewWidth.NORMAL)} else 180"),
            Math("other_side",
                 f"max({number(body.server.minneckang)}, -aside) if neck > 0 else min({number(body.server.maxneckang)}, aside)"),
        ),
        transitions=(
            # nobody knows yet where the ball is: a look that does not show it is followed by one to the side
            Transition("start", ("begin",), begun, sets={"missed": LOOKS}),
            Transition("close_open", ("stop", "ongoing", "open"), ("stopped",), sets=shut, priority=9),
            Transition("close_moved", ("stop", "ongoing", "moved"), ("stopped",), sets=shut, priority=9),
            Transition("ignore", ("stop",), inhibitors=("ongoing", "begin"), priority=8),
            # the output is up to date before anybody acts on it
            Transition("warn", ("open",), ("open", "ball_coming"), tests={"coming": 1}, inhibitors=("ball_coming",), priority=7),
            Transition("warn_moved", ("moved",), ("moved", "ball_coming"), tests={"coming": 1}, inhibitors=("ball_coming",), priority=7),
            Transition("calm", ("ball_coming",), inhibitors={"coming": 1}, priority=7),
            Transition("see", ("open",), ("open",), tests={"seen": 1, "missed": 1}, sets={"missed": 0}, priority=5),
            Transition("miss", ("open",), ("moved", "missed"), tests={"fresh": 1}, inhibitors={"seen": 1, "missed": LOOKS},
                       emits=Command("look", direction="ball_direction"), priority=4),
            Transition("sweep", ("open",), ("moved",), tests={"fresh": 1, "missed": LOOKS}, inhibitors={"seen": 1},
                       emits=Command("look", direction="other_side"), priority=3),
            Transition("follow", ("open",), ("moved",), inhibitors={"missed": LOOKS},
                       emits=Command("look", direction="ball_direction"), priority=2),
            Transition("wait", ("open",), ("moved",), priority=-1),
            Transition("blink", ("moved",), ("open",), delay=1),
            *lids,
        ),
    )  # fmt: skip


WATCH_BALL = watch_ball()
"""Of a default player."""
