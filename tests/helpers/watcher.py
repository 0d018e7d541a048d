"""A CPRM that uses every kind of link: two players may hold a ball that shoots, one of three comes and goes."""

from cprm_gym.architecture.cprm import CPRM, Cluster, Event, Observe
from cprm_gym.architecture.petri import Belief, ObjectPlace, PetriNet, Selection
from cprm_gym.architecture.prm import BOOL, Attribute, Bins, Model, Noise, PRMClass, Relation, Replace, Table, prev

PLACE = Bins((0.0, 2.0, 4.0, 6.0), clip=True)
MOVING = (
    Attribute("at", PLACE, Noise("prev.at", 0.8), parents=(prev("at"),), initial=Noise("3", 2.0)),
    Attribute("seen_at", PLACE, Noise("at", 0.9), parents=("at",)),
)
HOLDS = Relation(
    "holds",
    {"p": "Player", "b": "Ball"},
    attributes=(Attribute("shoots", BOOL, (0.7, 0.3)),),
    changes=(Replace("b.at", ("p.at", "shoots"), Table({(s, "yes"): (0.0, 0.1, 0.9) for s in PLACE.states} | {
        (s, "no"): tuple(0.8 if j == k else 0.1 for j in range(3)) for k, s in enumerate(PLACE.states)})),),
    conflict="mixture",
)  # fmt: skip
PITCH = Model("pitch", (PRMClass("Ball", MOVING), PRMClass("Player", MOVING)), (HOLDS,))
OBJECTS = {"ball": "Ball", "p0": "Player", "p1": "Player", "p2": "Player"}

NET = PetriNet(
    "watcher",
    places=(
        ObjectPlace("first", "Player", select=Selection("Player", best="player.one")),
        ObjectPlace("second", "Player", select=Selection("Player", best="player.two")),
        Belief("shot", variable="one.shoots", view="probability", state="yes", value=-1.0),
        Belief("whose", variable="ball.selector", view="probability", state="one", value=-1.0),
        Belief("doubt", variable="ball.selector", view="entropy", value=-1.0),
        Belief("where", variable="ball.at", view="expectation"),
        Belief("gone", variable="p2.at", view="expectation", value=-5.0),
        Belief("both", variable="near", view="probability", state="yes"),
    ),
)
WATCHER = CPRM(
    "watcher", NET, PITCH, OBJECTS,
    observations=(
        Observe("ball.seen_at", "ball", when="ball_seen"),
        Observe("first.seen_at", "holder"),
        Observe("one.shoots", "kick", when="kick_heard"),
        Observe("ball.selector", "0", when="told"),
        Observe("p2.at", likelihood=("1 + noise", "2", "1")),
    ),
    clusters=(Cluster("holds", ("first", "=ball"), "one"), Cluster("holds", ("second", "=ball"), "two")),
    present={"p2": "p2_there"},
    events=(Event("near", {"ball.at": "..2", "first.at": "..4"}),),
)  # fmt: skip
