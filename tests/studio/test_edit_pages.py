"""The editors in a browser: a net is changed and saved, a broken contract is reported, nothing is lost by a reload, a model is asked."""

import re

import pytest

from cprm_gym.agents.goalie import GOALIE_NET
from cprm_gym.agents.skills.orient import ORIENT
from cprm_gym.architecture.petri import load_net, save_net
from cprm_gym.architecture.prm import Attribute, Grounding, Model, PRMClass, Table, world_to_json

NODE = '.netcanvas .node[data-key="{}"] .hit, .netcanvas .node[data-key="{}"] .shape'


@pytest.fixture
def orient(serve, open_page, tmp_path):
    save_net(ORIENT, tmp_path / "orient.json")
    page = open_page(serve(file="orient.json").address)
    page.wait_for_selector('.netcanvas .node[data-key="turn"]')
    page.keyboard.press("q")
    page.wait_for_selector('.netcanvas .node[data-key="off_axis"]')
    return page


def click(page, key):
    page.locator(NODE.format(key, key)).last.click()


def value(page, label):
    return page.get_by_label(label, exact=True)


def commit(page, label, text):
    value(page, label).fill(text)
    value(page, label).press("Enter")


def test_a_net_is_changed_saved_and_not_lost_by_a_reload(orient, tmp_path):
    page = orient
    click(page, "turns")
    commit(page, "capacity", "20")
    page.get_by_text("≤ 20", exact=True).wait_for()
    commit(page, "name", "tries")
    page.wait_for_selector('.node[data-key="tries"]')
    click(page, "turn")
    commit(page, "priority", "5")
    page.get_by_text("changed; a draft is kept").wait_for()
    page.reload()
    page.wait_for_selector('.node[data-key="tries"]')
    page.keyboard.press("Control+s")
    page.get_by_text("written: orient.json").wait_for()
    saved = load_net(tmp_path / "orient.json")
    assert saved.place("tries").capacity == 20
    assert saved.transition("turn").priority == 5
    assert saved.transition("give_up").tests.keys() >= {"tries"}


def test_what_is_being_typed_is_saved_and_not_lost_by_a_reload(orient, tmp_path):
    page = orient
    click(page, "turns")
    value(page, "capacity").fill("19")
    page.keyboard.press("Control+s")
    page.get_by_text("written: orient.json").wait_for()
    assert load_net(tmp_path / "orient.json").place("turns").capacity == 19
    value(page, "capacity").fill("23")
    page.reload()
    page.get_by_text("≤ 23", exact=True).wait_for()
    page.get_by_text("changed; a draft is kept").wait_for()


def test_keys_that_come_faster_than_answers_are_all_heard(orient):
    page = orient
    nodes = page.locator(".netcanvas .node").count()

    def press(*keys):
        page.evaluate(
            """(keys) => keys.forEach((key) => document.body.dispatchEvent(
                new KeyboardEvent('keydown', { key, ctrlKey: 'zy'.includes(key), bubbles: true })))""",
            keys,
        )

    def shown(count):
        page.wait_for_function("(n) => document.querySelectorAll('.netcanvas .node').length === n", arg=count)

    press("p", "p", "t", "t")
    shown(nodes + 4)
    press("z", "z", "z", "y", "z")
    shown(nodes + 1)
    assert page.locator(".note.error").count() == 0


def test_quantities_are_hidden_until_they_are_asked_for_or_found(serve, open_page, tmp_path):
    save_net(ORIENT, tmp_path / "orient.json")
    page = open_page(serve(file="orient.json").address)
    page.wait_for_selector('.netcanvas .node[data-key="turn"]')
    assert page.locator('.node[data-key="off_axis"]').count() == 0
    page.keyboard.press("f")
    page.get_by_label("find", exact=True).fill("off_a")
    page.keyboard.press("Enter")
    page.wait_for_selector('.node[data-key="off_axis"].selected')


def test_a_search_begun_before_the_net_is_there_waits_for_it_and_says_so(serve, open_page, tmp_path):
    save_net(ORIENT, tmp_path / "orient.json")
    served, page = serve(file="orient.json"), open_page("about:blank")
    kept = []

    def between(socket):
        server = socket.connect_to_server()
        socket.on_message(lambda message: kept.append((server, message)) if "edit.read" in message else server.send(message))

    page.route_web_socket("**/ws*", between)
    page.goto(served.address)
    page.get_by_text("opening…").first.wait_for()
    while not kept:
        page.wait_for_timeout(20)
    page.keyboard.press("f")
    page.get_by_text("the net is being opened; the search begins when it is here").wait_for()
    kept[0][0].send(kept[0][1])
    page.get_by_label("find", exact=True).fill("give_up")
    page.keyboard.press("Enter")
    page.wait_for_selector('.node[data-key="give_up"].selected')


def test_what_does_not_fit_is_said_beside_the_field_and_changes_nothing(orient):
    page = orient
    click(page, "off_axis")
    field = value(page, "expression")
    before = field.inner_text()
    field.fill("abs(bearing) + nothing")
    page.get_by_text("unknown place 'nothing'").wait_for()
    assert page.inner_text(".mistake") == "nothing"
    assert field.get_attribute("aria-invalid") == "true"
    field.press("Enter")
    page.get_by_text("unknown place 'nothing'").first.wait_for()
    field.press("Escape")
    assert field.inner_text() == before
    assert page.locator(".mistake").count() == 0


def test_an_expression_is_written_with_names_completed_by_keys_alone(orient):
    page = orient
    click(page, "off_axis")
    field = value(page, "expression")
    field.fill("2 * abs(")
    page.keyboard.type("bea")
    page.wait_for_selector(".cm-tooltip-autocomplete li:has-text('bearing')")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    page.keyboard.type(")")
    assert field.inner_text() == "2 * abs(bearing)"
    page.keyboard.press("Tab")
    assert not field.evaluate("(e) => e === document.activeElement")
    page.get_by_text("changed; a draft is kept").wait_for()
    page.reload()
    page.wait_for_selector('.netcanvas .node[data-key="turn"]')
    if page.locator('.node[data-key="off_axis"]').count() == 0:
        page.keyboard.press("q")
    click(page, "off_axis")
    assert value(page, "expression").inner_text() == "2 * abs(bearing)"


def test_an_expression_that_is_being_typed_is_saved(orient, tmp_path):
    page = orient
    click(page, "off_axis")
    value(page, "expression").fill("abs(bearing) / 2")
    page.keyboard.press("Control+s")
    page.get_by_text("written: orient.json").wait_for()
    assert load_net(tmp_path / "orient.json").place("off_axis").expression == "abs(bearing) / 2"


def test_a_part_is_added_connected_and_taken_back_by_keys_alone(orient):
    page = orient
    canvas = page.locator(".netcanvas").first
    canvas.focus()
    page.keyboard.press("p")
    page.wait_for_selector('.node[data-key="place"].selected')
    canvas.focus()
    page.keyboard.press("t")
    page.wait_for_selector('.node[data-key="transition"].selected')
    canvas.focus()
    page.keyboard.press("a")
    page.wait_for_selector(".netcanvas.connecting")
    click(page, "place")
    page.wait_for_selector('.link[data-key="arc\ttransition\tplace"]', state="attached")
    canvas.focus()
    page.keyboard.press("Control+z")
    page.wait_for_selector('.link[data-key="arc\ttransition\tplace"]', state="detached")
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+z")
    page.wait_for_selector('.node[data-key="place"]', state="detached")


def test_parts_are_copied_with_the_arcs_among_them(orient):
    page = orient
    click(page, "ready")
    page.keyboard.down("Shift")
    click(page, "wait")
    page.keyboard.up("Shift")
    page.keyboard.press("Control+c")
    page.get_by_text("copied 1 places and 1 transitions").wait_for()
    page.keyboard.press("Control+v")
    page.wait_for_selector('.link[data-key="arc\tready_2\twait_2"]', state="attached")
    page.wait_for_selector('.link[data-key="arc\twait_2\tacted"]', state="attached")


def test_a_part_that_is_dragged_stays_there_in_the_file(orient, tmp_path):
    page = orient
    box = page.locator('.node[data-key="begin"] .shape').bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + 60, box["y"] + 80, steps=4)
    page.mouse.up()
    page.get_by_text("changed; a draft is kept").wait_for()
    page.keyboard.press("Control+s")
    page.get_by_text("written").wait_for()
    assert '"layout"' in (tmp_path / "orient.json").read_text()
    assert load_net(tmp_path / "orient.json") == ORIENT


def test_a_broken_contract_is_reported_with_the_places_and_a_run(orient):
    page = orient
    page.get_by_text("a token in begin marks ongoing in the same instant").wait_for()
    assert page.locator(".finding.broken").count() == 0
    click(page, "start")
    page.get_by_label("remove the output arc with ongoing").click()
    page.wait_for_selector(".finding.broken")
    assert "ongoing" in page.locator(".finding.broken").first.inner_text()
    page.wait_for_selector('.node[data-key="ongoing"].problem')
    assert page.locator(".run").count() > 0
    page.keyboard.press("Escape")
    page.locator("[data-do=undo]").first.click()
    page.wait_for_selector(".finding.broken", state="detached")


def test_a_file_that_changed_meanwhile_is_asked_about(orient, tmp_path):
    page = orient
    click(page, "turns")
    commit(page, "capacity", "30")
    page.get_by_text("≤ 30", exact=True).wait_for()
    text = (tmp_path / "orient.json").read_text() + "\n"
    (tmp_path / "orient.json").write_text(text)
    page.locator("[data-do=save]").first.click()
    page.get_by_text("was changed since it was opened").wait_for()
    page.keyboard.press("Delete")
    page.keyboard.press("Escape")
    page.wait_for_selector("dialog.ask", state="detached")
    assert page.locator('.node[data-key="turns"]').count() == 1
    page.keyboard.press("Control+s")
    page.get_by_text("was changed since it was opened").wait_for()
    assert (tmp_path / "orient.json").read_text() == text
    page.get_by_role("button", name="write over it").click()
    page.get_by_text("written: orient.json").wait_for()
    assert load_net(tmp_path / "orient.json").place("turns").capacity == 30


def test_two_pages_show_the_same_document(serve, open_page, tmp_path):
    save_net(ORIENT, tmp_path / "orient.json")
    address = serve(file="orient.json").address
    one, other = open_page(address), open_page(address)
    for page in (one, other):
        page.wait_for_selector('.netcanvas .node[data-key="turn"]')
    click(one, "turn")
    commit(one, "name", "swing")
    other.wait_for_selector('.netcanvas .node[data-key="swing"]')
    click(other, "swing")
    commit(other, "priority", "4")
    one.locator('.node[data-key="swing"] .detail', has_text="priority 4").wait_for()


def test_changes_outlive_the_studio(serve, open_page, tmp_path):
    save_net(ORIENT, tmp_path / "orient.json")
    first = serve(file="orient.json")
    page = open_page(first.address)
    page.wait_for_selector('.netcanvas .node[data-key="turn"]')
    click(page, "turn")
    commit(page, "name", "swing")
    page.get_by_text("changed; a draft is kept").wait_for()
    first.close()
    page = open_page(serve(file="orient.json").address)
    page.wait_for_selector('.netcanvas .node[data-key="swing"]')
    page.get_by_text("changed; a draft is kept").wait_for()
    assert load_net(tmp_path / "orient.json") == ORIENT


def test_the_token_game_is_played_by_hand(orient):
    page = orient
    page.locator("[data-do=play]").click()
    page.get_by_label("marking of begin").fill("1")
    page.get_by_label("marking of begin").press("Enter")
    page.get_by_role("button", name="fire start").click()
    page.wait_for_selector('.node[data-key="ongoing"].marked')
    page.get_by_role("button", name="back", exact=True).click()
    page.wait_for_selector('.node[data-key="begin"].marked')
    page.get_by_role("button", name="end", exact=True).click()
    page.wait_for_selector('.node[data-key="begin"].marked', state="detached")


BOOL = ("no", "yes")
RAIN = Model(
    "rain",
    (
        PRMClass(
            "Garden",
            (
                Attribute("rain", BOOL, (0.8, 0.2)),
                Attribute("wet", BOOL, Table({"yes": (0.1, 0.9), "no": (0.7, 0.3)}), ("rain",)),
            ),
        ),
    ),
)


def test_a_model_is_asked_by_clicking_evidence_and_its_table_is_changed(serve, open_page, tmp_path):
    (tmp_path / "rain.json").write_text(world_to_json(Grounding(RAIN, {"g": "Garden"})))
    page = open_page(serve(file="rain.json").address)
    page.get_by_role("tab", name="Models").click()
    page.locator(".side:visible .doc[aria-current=true]", has_text="rain.json world").wait_for()
    page.locator("[data-do=graph]:visible").click()
    page.locator("[data-do=graph][aria-pressed=true]:visible").wait_for()
    page.locator('.variable[data-key="g.wet"]').click()
    page.get_by_role("button", name="yes").click()
    page.wait_for_selector('.variable[data-key="g.rain"][aria-label="g.rain: no 57 %"]')
    page.locator("[data-do=table]:visible").click()
    page.locator(".side:visible .doc", has_text="rain 2 states").click()
    cell = page.get_by_label("yes", exact=True)
    cell.fill("0.5")
    cell.press("Enter")
    page.get_by_text("changed; a draft is kept").last.wait_for()
    page.locator("[data-do=graph]:visible").click()
    page.wait_for_selector('.variable[data-key="g.rain"][aria-label="g.rain: yes 75 %"]')


def test_an_unfinished_model_says_what_is_missing(serve, open_page, tmp_path):
    (tmp_path / "rain.json").write_text(world_to_json(Grounding(RAIN, {"g": "Garden"})))
    page = open_page(serve(file="rain.json").address)
    page.get_by_role("tab", name="Models").click()
    page.locator(".side:visible .doc", has_text="wet 2 states").click()
    commit(page, "parents", "rein")
    page.get_by_text("not finished").wait_for()
    assert "Did you mean 'rain'" in page.locator(".problem:visible").inner_text()
    page.locator("[data-do=undo]:visible").click()
    page.wait_for_selector(".models .problem:not(:empty)", state="detached")


def test_the_expression_of_a_model_is_checked_by_the_names_of_its_parents(serve, open_page):
    page = open_page(serve(demo="goalie").address)
    page.get_by_role("tab", name="Models").click()
    page.locator(".side:visible .doc", has_text="seen_vx").click()
    field = page.locator("section[data-view=models]").get_by_label("mean", exact=True)
    assert field.inner_text() == "vx"
    field.fill("0.9 * vz")
    page.get_by_text("unknown parent 'vz'").wait_for()
    assert page.inner_text(".mistake") == "vz"
    field.fill("0.9 * vx")
    page.wait_for_selector(".mistake", state="detached")
    field.press("Enter")
    page.wait_for_selector("section[data-view=models] [data-do=undo]:not([disabled])")
    assert field.inner_text() == "0.9 * vx"


@pytest.mark.slow
def test_the_model_of_an_agent_is_learned_from_the_readings_of_the_run_that_is_watched(serve, open_page, tmp_path):
    served = serve(demo="goalie", seed=2)
    page = open_page(served.address)
    page.wait_for_selector(".netcanvas .node")
    served.studio.session.step(6)
    page.get_by_role("tab", name="Percepts").click()
    page.locator("[data-do=readings]").click()
    page.get_by_label("file", exact=True).fill("told.json")
    page.keyboard.press("Enter")
    page.get_by_text("written: told.json, 7 cycles").wait_for()
    page.get_by_role("tab", name="Models").click()
    page.locator(".side:visible .doc", has_text="seen_vx").wait_for()
    before = served.studio.desk.models()
    page.locator("[data-do=learn]").click()
    page.get_by_role("option", name="told.json").click()
    page.get_by_label("iterations", exact=True).fill("2")
    page.get_by_role("button", name="learn", exact=True).click()
    page.get_by_text(re.compile(r"learned \d+ CPDs from 7 slices")).wait_for(timeout=60_000)
    said = re.search(r"ln P of the log (\S+) → (\S+)", page.inner_text("#notes"))
    assert float(said[2]) > float(said[1])
    page.locator("section[data-view=models] [data-do=undo]:not([disabled])").wait_for()
    assert served.studio.desk.models().keys() == before.keys() == {"goalie"}
    assert served.studio.desk.models() != before
    assert served.studio.desk.document("d1").value().net == GOALIE_NET
