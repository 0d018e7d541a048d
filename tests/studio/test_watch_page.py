"""The views Watch and Run in a real browser, as one uses them: by mouse and keys."""

import re

from cprm_gym.envs.play import Film, play
from cprm_gym.envs.tasks import make_task


def at(page, cycle):
    """Wait until a cycle is shown."""
    page.wait_for_function("(c) => document.querySelector('[data-show=cycle]')?.textContent.startsWith(`cycle ${c}`)", arg=cycle)


def shown_cycle(page):
    return int(re.search(r"cycle (\d+)", page.inner_text("[data-show=cycle]"))[1])


def opened(serve, open_page, **options):
    served = serve(**options)
    page = open_page(served.address)
    page.wait_for_selector(".netcanvas .node")
    return served, page


def test_the_goalie_plays_is_paused_and_stepped(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    assert page.inner_text("#what") == "demo goalie"
    at(page, 0)
    ball = page.get_attribute(".thing[data-number='0']", "transform")
    page.click("[data-do=play]")
    page.wait_for_function("() => Number(document.querySelector('[data-show=cycle]').textContent.slice(6)) >= 3")
    page.keyboard.press(" ")
    page.wait_for_function("() => document.querySelector('[data-do=play]').textContent === 'play'")
    there = shown_cycle(page)
    assert there == served.studio.session.run.cycle
    page.wait_for_timeout(250)
    assert shown_cycle(page) == there
    page.keyboard.press("ArrowRight")
    at(page, there + 1)
    assert page.get_attribute(".thing[data-number='0']", "transform") != ball
    assert page.locator(".netcanvas .node.marked").count() > 0
    page.focus("[aria-label=cycle]")
    page.keyboard.press("Home")
    at(page, f"0 of {there + 1}")
    page.keyboard.press(".")
    page.wait_for_function("() => document.querySelector('[data-show=firing]').textContent.startsWith('1 of')")
    assert page.get_attribute(".thing[data-number='0']", "transform") == ball
    page.click("[data-do=resume]")
    at(page, 0)
    assert served.studio.session.run.cycle == 0


def test_a_breakpoint_is_set_hit_and_still_there_after_a_reload(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    page.fill("[type=search]", "leap")
    page.keyboard.press("Enter")
    page.click("[data-do=break]")
    page.wait_for_selector(".break")
    assert page.locator(".netcanvas .node.broken").get_attribute("data-key") == "leap"
    page.fill("[aria-label=expression]", "P(ball.x < -48) > 0.5")
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.querySelectorAll('.break').length === 2")
    page.click("[data-do=play]")
    page.wait_for_selector(".break.struck")
    assert "leap" in page.inner_text(".break.struck")
    assert page.locator(".netcanvas .node.fired[data-key=leap]").count() == 1
    stopped = shown_cycle(page)
    page.reload()
    page.wait_for_selector(".netcanvas .node.broken")
    at(page, stopped)
    page.keyboard.press("s")
    assert page.locator(".break").count() == 2
    page.keyboard.press(" ")
    page.wait_for_function("() => document.querySelector('.break.struck')?.textContent.includes('P(ball.x')")
    assert shown_cycle(page) > stopped
    assert served.studio.session.run.cycle == shown_cycle(page)


def test_expressions_of_breakpoints_and_curves_are_checked_and_completed_while_they_are_typed(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    page.keyboard.press("s")
    field = page.get_by_label("expression", exact=True)
    field.fill("P(ball.x < -45) > 0.8 and sav.turns")
    page.wait_for_selector("text='sav.turns' is neither a percept nor a place.")
    assert page.inner_text(".mistake") == "sav.turns"
    assert field.get_attribute("aria-invalid") == "true"
    field.fill("E(ball.")
    page.keyboard.type("v")
    page.wait_for_selector(".cm-tooltip-autocomplete li:has-text('ball.vx')")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    page.keyboard.type(") < 0")
    assert field.inner_text() == "E(ball.vx) < 0"
    page.wait_for_selector(".mistake", state="detached")
    page.keyboard.press("Enter")
    page.wait_for_selector(".break")
    assert served.studio.debugger.breakpoints["goalie"][0].what == "E(ball.vx) < 0"
    assert field.inner_text().strip() == ""
    page.select_option("[aria-label='kind of breakpoint']", "fires")
    field.fill("lep")
    page.wait_for_selector("text=unknown transition 'lep'. Did you mean 'leap'?")
    field.press("Escape")  # the list of names
    field.press("Escape")
    assert page.locator(".breaks-panel .bad").inner_text() == ""
    page.keyboard.press("Tab")
    page.keyboard.press("g")
    curve = page.get_by_label("expression of a curve")
    curve.fill("P(ball.xx < 3)")
    page.wait_for_selector("text=unknown variable 'ball.xx'")
    assert page.inner_text(".curves .mistake") == "ball.xx"


def test_why_a_transition_did_not_fire_and_which_reading_moved_a_belief(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    page.keyboard.press("ArrowRight")
    at(page, 1)
    page.keyboard.press("ArrowRight")
    at(page, 2)
    page.fill("[type=search]", "hold")
    page.keyboard.press("Enter")
    page.click(".netcanvas .node.selected[data-key=hold] .hit", force=True)
    answer = page.wait_for_selector("[data-show=answer]").inner_text()
    assert answer == served.studio.debugger.why("left_1", "hold")["answer"]
    assert "save.caught needs 1, has 0" in answer
    assert "by 1" in page.inner_text(".conditions .fails")
    page.click(".belief[data-variable='ball.x']")
    page.wait_for_function("() => document.querySelector('.ask h3')?.textContent === 'What moved ball.x'")
    assert page.inner_text(".ask tbody tr td") == "ball.seen_x"
    assert page.inner_text("[data-show=asked]") == "asked in cycle 2"
    page.keyboard.press("ArrowLeft")
    at(page, 1)
    assert "the readings of cycle 2" in page.inner_text("[data-show=answer]")
    page.click("text=ask again in cycle 1")
    page.wait_for_function("() => document.querySelector('[data-show=answer]')?.textContent.includes('cycle 1')")
    assert page.inner_text("[data-show=asked]") == "asked in cycle 1"


def test_after_a_comparison_nothing_is_asked_of_the_other_run(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    page.keyboard.press("ArrowRight")
    at(page, 1)
    page.keyboard.press("x")
    page.wait_for_selector(".field-there .thing")
    page.keyboard.press("ArrowRight")
    at(page, 2)
    page.keyboard.press("x")
    page.wait_for_selector(".watch:not(.split)")
    page.keyboard.press("ArrowLeft")
    at(page, 1)  # which was kept with the other run's
    page.keyboard.press(".")
    page.wait_for_function("() => document.querySelector('[data-show=firing]').textContent.startsWith('1 of')")
    page.fill("[type=search]", "guard")
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.querySelector('.ask h3')?.textContent === 'guard'")
    assert page.inner_text("[data-show=asked]") == "asked in cycle 1"
    assert "there" not in page.inner_text(".ask")
    page.select_option("[aria-label='how far modules are unfolded']", "1")
    page.wait_for_selector(".net-here .node[data-key='save.start']")
    page.keyboard.press("Escape")
    page.select_option("[data-show=compare]", "same")
    page.wait_for_selector(".net-there .node[data-key='save.start']")
    served.studio.playing.watch("Goalie", seed=3)  # as the view Run does, while the other run is beside
    page.wait_for_function("() => document.querySelector('.field-here .bar').textContent.includes('seed 3')")
    page.wait_for_selector(".watch:not(.split)")
    assert [one for one in page.locator(".note").all_inner_texts() if "beside" in one] == []


def test_whom_a_place_is_made_to_hold_is_said_by_name(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    page.keyboard.press("c")
    page.select_option("[data-show=change-kind]", "hold")
    for value, name in (("-1", "nobody"), ("1", served.studio.debugger.inside("left_1")["holds"]["watched_1"][1])):
        page.select_option("[aria-label=object]", value)
        page.click("[data-do=change]")
        page.wait_for_selector(f".hands li:has-text('left_1 watched_1 holds {name}')")


def test_one_firing_after_the_other(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    page.keyboard.press("ArrowRight")
    at(page, 1)
    fired = [f["transition"] for f in served.studio.debugger.firings("left_1")]
    for k, name in enumerate(fired, 1):
        page.keyboard.press(".")
        page.wait_for_function("(t) => document.querySelector('[data-show=firing]').textContent === t", arg=f"{k} of {len(fired)} {name}")
    page.keyboard.press(".")
    at(page, 2)
    page.keyboard.press(",")
    page.keyboard.press(",")
    at(page, "1 of 2")


def test_keys_that_come_faster_than_answers_are_all_heard(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)

    def press(*keys):
        page.evaluate(
            "(keys) => keys.forEach((key) => document.body.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true })))", keys
        )

    press(*["ArrowRight"] * 5)
    at(page, 5)
    press(*["ArrowLeft"] * 3)
    at(page, "2 of 5")
    fired = [len(served.studio.debugger.firings("left_1", cycle)) for cycle in (2, 3)]
    assert min(fired) > 1
    press(*["."] * (fired[0] + 2))
    page.wait_for_function("(t) => document.querySelector('[data-show=firing]').textContent.startsWith(t)", arg=f"1 of {fired[1]}")
    at(page, "3 of 5")
    press(",", ",", "End", "ArrowLeft")
    at(page, "4 of 5")
    press("Enter", "ArrowRight", "ArrowRight", "ArrowLeft")
    at(page, "5 of 6")
    assert served.studio.session.run.cycle == 6


def test_the_ball_is_dragged_and_two_runs_differ_from_then_on(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    page.keyboard.press("ArrowRight")
    at(page, 1)
    page.select_option("[data-show=compare]", "same")
    page.wait_for_function("() => document.querySelector('[data-show=difference]').textContent === 'no difference so far'")
    box = page.locator(".field-here .thing[data-number='0'] .grip").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y + 40, steps=4)
    page.mouse.up()
    page.wait_for_selector(".field .moved circle")
    (change,) = served.studio.session.run.hands.log
    assert change.kind == "ball"
    page.keyboard.press("ArrowRight")
    page.wait_for_function("() => document.querySelector('[data-show=difference]').textContent.startsWith('first difference in cycle 2')")
    assert page.locator(".field-here .thing.differs[data-number='0'] .unequal").count() == 1
    assert page.locator(".field-there .thing.differs[data-number='0'] .unequal").count() == 1
    page.keyboard.press("c")
    page.select_option("[data-show=change-kind]", "blind")
    page.click("[data-do=change]")
    page.wait_for_function("() => document.querySelector('.hands li')?.textContent.includes('blind')")
    page.click("[data-do=undo]")
    page.wait_for_function("() => !document.querySelector('.hands li')")
    page.fill("[data-field=cycles]", "")
    page.click("[data-do=change]")
    page.wait_for_selector("text=cycles: a number is needed")
    assert page.locator(".hands li").count() == 0
    page.focus(".field-here .thing[data-number='0']")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.querySelector('.hands li')?.textContent.includes('ball moved')")


def test_two_runs_are_side_by_side_and_what_differs_is_marked_in_both(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=0)
    page.keyboard.press("x")
    page.wait_for_selector(".net-there .netcanvas .node")
    assert page.inner_text("[data-show=differences]").startswith("No difference so far")
    page.keyboard.press("c")
    page.select_option("[data-show=change-kind]", "mark")
    page.fill("[data-field=name]", "away.patience")
    page.fill("[data-field=value]", "2")
    page.click("[data-do=change]")
    page.wait_for_function("() => document.querySelector('.hands li')?.textContent.includes('away.patience')")
    for k in (1, 2, 3):
        page.keyboard.press("ArrowRight")
        at(page, k)
    page.keyboard.press("d")
    at(page, "1 of 3")
    assert "Here they differ first: left_1: marking of away.patience" in page.inner_text("[data-show=differences]")
    row = page.locator("[data-differs='marking away.patience'] td").all_inner_texts()
    assert row == ["marking", "away.patience", "2", "0"]
    assert page.locator(".box.differs[data-key=away] > .unequal").count() == 2
    page.click("[data-differs='marking away.patience'] button")
    page.wait_for_selector(".net-there .netcanvas .node.differs[data-key='away.patience']")
    tokens = [page.locator(f".net-{side} .node[data-key='away.patience'] .token").count() for side in ("here", "there")]
    assert tokens == [2, 0]
    views = [page.evaluate("(s) => document.querySelector(s).style.transform", f".net-{side} .world") for side in ("here", "there")]
    assert views[0] == views[1]
    for box in (page.locator(f".watch > .{name}").bounding_box() for name in ("field-there", "net-there", "side-left", "side-right")):
        assert box["x"] + box["width"] <= 1280
        assert box["y"] + box["height"] <= 800
        assert box["height"] > 150
    page.fill("section[data-view=watch] [type=search]", "away.start")
    page.keyboard.press("Enter")
    page.click(".net-there .node.selected[data-key='away.start'] .hit", force=True)
    page.wait_for_function("() => document.querySelector('.ask h3')?.textContent === 'away.start there'")
    assert page.inner_text("[data-show=answer]") == served.studio.debugger.why("left_1", "away.start", 1, beside=True)["answer"]
    page.keyboard.press("x")
    page.wait_for_selector(".net-there", state="hidden")
    assert page.locator(".net-here .differs, .field-here .differs").count() == 0


def test_a_part_that_is_looked_for_before_the_net_is_there_is_shown_when_it_comes(serve, open_page):
    served, page = serve(demo="goalie", seed=2), open_page("about:blank")
    kept = []

    def between(socket):
        server = socket.connect_to_server()
        socket.on_message(lambda message: kept.append((server, message)) if "watch.plan" in message else server.send(message))

    def plan_asked():
        while not kept:
            page.wait_for_timeout(20)
        return kept.pop()

    page.route_web_socket("**/ws*", between)
    page.goto(served.address)
    server, message = plan_asked()
    page.keyboard.press("f")
    server.send(message)
    page.wait_for_function("() => document.activeElement.matches('.net-here [type=search]')")
    served.studio.playing.watch("Goalie", seed=3)
    server, message = plan_asked()
    page.fill("[type=search]", "leap")
    page.keyboard.press("Enter")
    page.wait_for_selector("text=leap: looked for as soon as the net is here")
    server.send(message)
    page.wait_for_selector(".netcanvas .node.selected[data-key=leap]")
    page.fill("[type=search]", "nowhere")
    page.keyboard.press("Enter")
    page.wait_for_selector("text=no part of goalie is called nowhere")
    assert page.get_attribute("[type=search]", "aria-invalid") == "true"


def test_episodes_are_played_and_a_failure_is_watched(serve, open_page):
    served = serve(demo="goalie", seed=2)
    page = open_page(f"{served.address}#run")
    page.wait_for_selector("[data-do=episodes]")
    page.fill("[data-field=count]", "-3")
    page.click("[data-do=episodes]")
    assert page.locator("[data-field=count]:invalid").count() == 1
    assert page.inner_text("[data-show=episodes]") == "No episodes yet."
    page.fill("[data-field=count]", "20")
    page.click("[data-do=episodes]")
    page.wait_for_function("() => document.querySelector('[data-show=episodes]').textContent.includes('of 20 succeeded')")
    first = page.locator("[data-world]").first
    world = int(first.get_attribute("data-world"))
    first.click()
    page.wait_for_selector(".netcanvas .node")
    at(page, 0)
    assert served.studio.session.run.setup.world == world
    assert f"world {world}" in page.inner_text("#views")


def test_a_part_is_edited_from_where_it_was_asked_about_and_the_changed_net_plays(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    page.fill("section[data-view=watch] [type=search]", "loose")
    page.keyboard.press("Enter")
    page.click("[data-do=edit]")
    field = page.locator("section[data-view=nets]").get_by_label("expression", exact=True)
    field.fill(field.inner_text().replace("+ 20", "- 20"))
    field.press("Enter")
    page.get_by_text("a draft is kept").wait_for()
    page.keyboard.press("Alt+4")
    page.check("[data-net=goalie]")
    page.click("[data-do=watch]")
    page.wait_for_function("() => [...document.querySelector('[data-show=compare]').options].some((o) => o.value === 'shipped')")
    assert served.studio.session.run.setup.nets["goalie"].place("loose").expression.endswith("rival_time - 20 else 0")


def test_without_anything_to_watch_the_page_says_what_to_do(serve, open_page):
    page = open_page(serve().address)
    page.wait_for_selector("[data-do=watch]")
    page.click("[data-view=watch][role=tab]")
    page.wait_for_function("() => document.body.textContent.includes('Nothing is being watched')")
    page.click("text=choose what to play")
    page.wait_for_selector("[data-do=watch]")
    page.keyboard.press("Alt+2")
    page.get_by_role("heading", name="No net is open.").wait_for()
    page.keyboard.press("f")
    page.get_by_text("no net is open, so there is no part to be found").wait_for()


def test_a_log_is_played_and_looked_at_from_any_frame(serve, open_page, tmp_path):
    course = play(make_task("Goalie"), None, None, 1, 12)
    core, _ = next(course)
    with Film(tmp_path / "match.rcg", core) as film:
        film.add()
        for _ in course:
            film.add()
    page = open_page(serve(log=tmp_path / "match.rcg").address)
    page.wait_for_selector(".thing[data-number='0']")
    at(page, 0)
    page.click("[data-do=step]")
    at(page, 1)
    page.wait_for_selector(".thing[data-number='1']")
    last = int(page.get_attribute("[aria-label=cycle]", "max"))
    assert last >= 10
    page.focus("[aria-label=cycle]")
    page.keyboard.press("End")
    at(page, f"{last} of 1")
    assert page.locator(".net-here").is_hidden()
    assert "match.rcg" in page.inner_text("#what")
    for key in (".", ",", "b", "e", "w", "c", "ArrowLeft"):  # a log has no net to be asked
        page.keyboard.press(key)
    at(page, f"{last - 1} of 1")
    assert page.locator(".note.error").count() == 0


def test_other_beliefs_are_shown_and_a_player_without_a_net_says_so(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    page.fill("[aria-label='show another variable']", "o2")
    page.keyboard.press("Enter")
    page.wait_for_selector(".belief[data-variable='o2.facing']")
    page.click("text=those that the net reads")
    page.wait_for_selector(".belief[data-variable='o2.facing']", state="detached")
    served.studio.playing.watch("Goalie", "fsm", seed=2)
    page.wait_for_function("() => document.body.textContent.includes('which has no net to be seen')")
    page.wait_for_function("() => document.querySelectorAll('.field .thing').length >= 3")


def test_a_lost_connection_is_said_and_an_address_without_token_explains_itself(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    served.server.should_exit = True
    page.wait_for_selector("#link.lost")
    assert "no connection" in page.inner_text("#link")
    for key in ("ArrowRight", ".", "ArrowRight"):
        page.keyboard.press(key)
    page.wait_for_selector("text=the connection is lost")
    assert page.locator(".note").count() == 1
    page = open_page(serve().address.partition("?")[0])
    assert "lacks its token" in page.inner_text("main")


def test_a_connection_lost_while_the_run_is_opened_is_made_again_and_opens_it(serve, open_page):
    served, page = serve(demo="goalie", seed=2), open_page("about:blank")
    cut = []

    def between(socket):
        server = socket.connect_to_server()

        def passed(message):
            if "watch.open" in message and not cut:
                cut.append(message)
                socket.close()
            else:
                server.send(message)

        socket.on_message(passed)

    page.route_web_socket("**/ws*", between)
    page.goto(served.address)
    page.wait_for_function("() => document.body.textContent.includes('It cannot be opened: the connection is lost')")
    page.wait_for_selector(".netcanvas .node")
    at(page, 0)
    assert len(cut) == 1


def a_tall_net_is_moved_by_bars_and_keys(page):
    """It is shown so that names can be read, and all of it by one key."""

    def label():
        return page.evaluate("document.querySelector('.net-here .node[data-key=shut] .label').getBoundingClientRect().height")

    def top():
        return page.evaluate("new DOMMatrix(getComputedStyle(document.querySelector('.net-here .world')).transform).f")

    page.wait_for_selector(".net-here .scroll.down")
    readable = label()
    assert readable >= 9
    assert page.locator(".net-here .node[data-key=shut] .label").is_visible()
    first = top()
    page.keyboard.press("n")
    page.keyboard.press("PageDown")
    assert top() < first - 200
    page.keyboard.press("PageUp")
    assert top() == first
    grip = page.locator(".net-here .scroll.down > div").bounding_box()
    page.mouse.move(grip["x"] + 3, grip["y"] + 10)
    page.mouse.down()
    page.mouse.move(grip["x"] + 3, grip["y"] + 70, steps=3)
    page.mouse.up()
    assert top() < first - 100
    page.keyboard.press("0")
    page.wait_for_selector(".net-here .scroll.down", state="hidden")
    assert label() < readable
    page.keyboard.press("0")
    page.wait_for_selector(".net-here .scroll.down")
    assert label() == readable


def test_the_page_is_worked_by_keys_and_changes_its_colours(serve, open_page):
    _, page = opened(serve, open_page, demo="goalie", seed=2)
    page.keyboard.press("?")
    assert "one firing on" in page.inner_text("#keys")
    page.keyboard.press("Escape")
    before = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.keyboard.press("Shift+L")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != before
    page.keyboard.press("n")
    page.keyboard.press("ArrowDown")
    page.wait_for_selector(".netcanvas .selected")
    a_tall_net_is_moved_by_bars_and_keys(page)
    page.keyboard.press("Alt+4")
    page.wait_for_selector("[data-do=episodes]", state="visible")
    page.keyboard.press("Alt+1")
    page.wait_for_selector(".field", state="visible")


def test_curves_are_drawn_and_a_click_on_them_goes_to_that_cycle(serve, open_page):
    served, page = opened(serve, open_page, demo="goalie", seed=2)
    page.keyboard.press("g")
    served.studio.session.step(40)
    at(page, 40)
    page.fill("[aria-label='expression of a curve']", "P(ball.x < -45)")
    page.keyboard.press("Enter")
    page.wait_for_selector("[data-curve='P(ball.x < -45)']")
    assert page.locator("[data-curve]").count() == 3
    assert "(true " in page.inner_text("[data-curve='E(ball.x)']")
    plot = page.locator(".plot .u-over").bounding_box()
    page.mouse.click(plot["x"] + plot["width"] / 2, plot["y"] + plot["height"] / 2)
    page.wait_for_function("() => /^cycle (19|20|21) of 40/.test(document.querySelector('[data-show=cycle]').textContent)")
    page.fill("[aria-label='expression of a curve']", "nix")
    page.keyboard.press("Enter")
    page.wait_for_selector(".curves .bad:not(:empty)")
    assert "neither a percept nor a place" in page.inner_text(".curves .bad")
    page.click("[aria-label='remove the curve E(ball.y)']")
    page.wait_for_function("() => document.querySelectorAll('[data-curve]').length === 2")
    page.reload()
    page.wait_for_selector("[data-curve='P(ball.x < -45)']")
    assert page.locator("[data-curve]").count() == 2
