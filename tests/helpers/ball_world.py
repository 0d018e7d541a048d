"""A ball, opponents, attention and possession, as the dissertation's goalie sees them (figures 2.25 to 2.28), at any grain."""

from __future__ import annotations

from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.architecture.prm.model.cpds import Chance, Noise, Switch, Table, Uniform
from cprm_gym.architecture.prm.model.domains import BOOL, Bins, Labels
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Attribute, Given, PRMClass, Relation, Replace


def motion(role: str = "") -> dict[str, tuple[tuple[str, ...], Noise]]:
    """Parents and CPD of each moving attribute, of the object itself or of one in a role (``"o."``)."""
    p = f"prev.{role}"
    return {
        "dist": ((f"{p}dist", f"{p}vdist"), Noise(f"{p}dist + {p}vdist", 0.3)),
        "dir": ((f"{p}dir", f"{p}vdir", f"{role}turn"), Noise(f"{p}dir + {p}vdir - {role}turn", 0.05)),
        "vdist": ((f"{p}vdist",), Noise(f"0.94 * {p}vdist", 0.2)),
        "vdir": ((f"{p}vdir",), Noise(f"0.94 * {p}vdir", 0.05)),
    }


def soccer(bins: int = 6, conflict: str = "exclusive") -> Model:
    """The model; `bins` for each of the four hidden quantities."""
    dist, vdist = Bins.linear(0.0, 30.0, bins, "m"), Bins.linear(-3.0, 3.0, bins, "m/step")
    direction, vdir = Bins.circle(bins), Bins.linear(-0.5, 0.5, bins, "rad/step")
    thing = PRMClass(
        "Thing",
        abstract=True,
        given=(Given("turn", Bins.linear(-0.5, 0.5, 5, clip=True), default=0.0),),
        attributes=(
            Attribute("dist", dist),
            Attribute("dir", direction),
            Attribute("vdist", vdist, Noise("0", 1.0)),
            Attribute("vdir", vdir, Noise("0", 0.2)),
            Attribute("seen", BOOL, Chance("0.95 if abs(dir) < 1.05 else 0.03"), parents=("dir",)),
            Attribute("obs_dist", dist, sensor("dist", "0.3 + 0.05 * dist"), parents=("dist", "seen")),
            Attribute("obs_dir", direction, sensor("dir", 0.07), parents=("dir", "seen")),
        ),
    )
    own = {a.name: a for a in thing.attributes}
    moving = tuple(Attribute(name, own[name].domain, cpd, parents, initial=own[name].cpd) for name, (parents, cpd) in motion().items())
    ball = PRMClass("Ball", extends="Thing", attributes=moving)
    opponent = PRMClass("Opponent", extends="Thing", attributes=(Attribute("orient", Labels(("to", "left", "away", "right"))),))
    attended = Relation(
        "attended",
        {"o": "Opponent"},
        changes=tuple(Replace(f"o.{name}", parents, cpd) for name, (parents, cpd) in motion("o.").items()),
    )
    possesses = Relation(
        "possesses",
        {"o": "Opponent", "b": "Ball"},
        attributes=(Attribute("shoot", BOOL, Table({("*", "to"): (0.6, 0.4), ("*", "*"): (0.95, 0.05)}), parents=("o.dist", "o.orient")),),
        changes=(
            Replace(
                "b.dist",
                parents=("o.dist", "shoot"),
                cpd=Switch("shoot", {"no": Noise("o.dist", 0.6), "yes": Noise("o.dist - 2", 1.0)}),
            ),
        ),
        conflict=conflict,
        keep_joint=(("b.dist", "b.vdist", "o.dist", "o.vdist"),),
    )
    return Model("soccer", (thing, ball, opponent), (attended, possesses))


def sensor(of: str, sd: float | str) -> Switch:
    """A noisy reading when seen, anything when not."""
    return Switch("seen", {"yes": Noise(of, sd), "no": Uniform()})


def scene(bins: int = 6, opponents: int = 2, conflict: str = "exclusive") -> Grounding:
    """A ball and some opponents, o1, o2, ..."""
    objects = {"ball": "Ball", **{f"o{k}": "Opponent" for k in range(1, opponents + 1)}}
    return Grounding(soccer(bins, conflict), objects)
