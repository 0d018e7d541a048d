"""Views in notebooks: pictures that are SVG, pages that need nothing, the same numbers in both."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from cprm_gym.agents.models import BALL_MODEL
from cprm_gym.agents.skills.approach import APPROACH
from cprm_gym.agents.skills.orient import ORIENT
from cprm_gym.architecture.cprm import CPRM, CPRMRunner
from cprm_gym.architecture.petri import Executor, Input, PetriNet, Place, Transition
from cprm_gym.architecture.prm import Grounding
from cprm_gym.errors import FormatError, ParameterError
from cprm_gym.simulator.gamelog.frames import Frame
from cprm_gym.studio.notebook import show

TWO = PetriNet(
    "two",
    (Place("a", tokens=2), Place("b"), Input("speed", observes="body.speed")),
    (Transition("go", ("a",), ("b",), delay=2, tests={"speed": 0.5}),),
)


def texts(view):
    """The texts of the picture, which is well-formed."""
    return [element.text for element in ElementTree.fromstring(view.svg).iter() if element.text and element.text.strip()]


def run(cycles=5):
    executor = Executor(TWO, trace=True)
    for _ in range(cycles):
        executor.step({"body.speed": 0.75})
    return executor


def frame(time, x=0.0):
    made = Frame(time)
    made.ball[:] = x, 1.0, 0.0, 0.0
    made.players["state"][:2] = 1
    made.players["pos"][:2] = (x - 3, 0), (5, 6)
    made.players["side"][:2], made.players["unum"][:2] = 1, (7, 8)
    return made


def test_a_net_is_drawn_with_its_names():
    assert {"a", "b", "go"} <= set(texts(show(TWO)))
    assert {"a", "b", "go"} <= set(texts(show(CPRM("c", net=TWO))))


def test_a_marking_is_that_of_the_executor():
    assert "0.75" in texts(show(run()))
    assert '"speed": 0.75' in show(run()).page


def decisions(count=3):
    runner = CPRMRunner(CPRM("c", net=TWO), trace=True)
    made = []
    for _ in range(count):
        runner.step({"body.speed": np.array([0.8])})
        made.append(runner.explain())
    return made


def test_a_decision_tells_what_fired():
    made = decisions()
    fired = [d for d in made if d.fired]
    assert fired
    assert "go" in texts(show(fired[0]))
    assert "cycle" in texts(show(made, net=TWO))[0]


def test_models_and_worlds_are_drawn():
    names = [a.name for c in BALL_MODEL.classes for a in c.attributes]
    assert any(name in text for name in names for text in texts(show(BALL_MODEL)))
    world = Grounding(BALL_MODEL, {c.name.lower(): c.name for c in BALL_MODEL.classes if not c.abstract})
    assert texts(show(world))


def test_a_match_shows_who_plays_and_where_the_ball_is():
    view = show([frame(1), frame(2, 4.0)])
    assert {"7", "8"} <= set(texts(view))
    assert 'cx="4.0"' in view.svg
    assert "cycle 2" in " ".join(texts(view))


@pytest.mark.parametrize("thing", [7, "nowhere.rcg", [], [1, 2], None])
def test_what_cannot_be_shown_is_refused(thing):
    with pytest.raises((ParameterError, FormatError)):
        show(thing)


def test_a_name_cannot_end_the_script_it_stands_in():
    net = PetriNet("evil", (Place("</script><script>alert(1)</script>"),))
    page = show(net).page
    assert page.count("</script>") == 1
    assert "<script>alert" not in show(net).svg


def test_notebooks_get_html_in_a_closed_frame_and_svg(tmp_path):
    view = show(TWO)
    bundle = view._repr_mimebundle_()
    assert 'sandbox="allow-scripts"' in bundle["text/html"]
    assert bundle["image/svg+xml"] == view.svg
    view.save(tmp_path / "net.svg")
    view.save(tmp_path / "net.html")
    assert (tmp_path / "net.svg").read_text() == view.svg
    assert "http" not in view.page.replace("http://www.w3.org", "")
    with pytest.raises(ParameterError, match="svg"):
        view.save(tmp_path / "net.png")


@pytest.fixture
def framed(browser):
    """Shows a view as a notebook does, and gives the frame."""
    page = browser.new_page(viewport={"width": 1000, "height": 600})
    wrong = []
    page.on("pageerror", lambda error: wrong.append(str(error)))

    def shown(view):
        page.set_content(f"<body>{view._repr_html_()}</body>")
        return page.frame_locator("iframe")

    yield shown
    page.close()
    assert wrong == []


def test_the_page_of_a_run_moves_through_its_cycles(framed):
    inside = framed(show(run(7)))
    inside.locator('.node[data-key="b"].marked').wait_for()
    inside.get_by_label("cycle", exact=True).fill("0")
    inside.locator('.node[data-key="a"].marked').wait_for()
    inside.locator('.node[data-key="b"]:not(.marked)').wait_for()
    inside.locator("output", has_text="cycle 0").wait_for()


def test_modules_are_unfolded_in_the_page(framed):
    inside = framed(show(APPROACH))
    inside.get_by_role("button", name="unfold").click()
    inner = f"{next(iter(APPROACH.modules))}.{next(iter(APPROACH.modules.values())).transitions[0].name}"
    inside.locator(f'.node[data-key="{inner}"]').wait_for()


def test_pages_of_decisions_models_and_matches_open(framed):
    framed(show(decisions(), net=TWO)).locator(".told", has_text="fired").wait_for()
    framed(show(BALL_MODEL)).locator(".still svg").wait_for()
    inside = framed(show([frame(1), frame(2, 4.0)]))
    inside.locator(".match .ball").wait_for()
    inside.get_by_text("cycle 2").wait_for()


def test_a_single_skill_fits_in_a_small_page():
    assert len(show(ORIENT).page) < 60_000
