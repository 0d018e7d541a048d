"""What the studio costs: ``python tests/benchmarks/bench_studio.py [--hour]``, with the system's Chromium.

CPU time of the server and of the page's thread for a cycle that is shown, frames per second of the largest net, the time until a page is
there; with ``--hour`` the memory of both while 36,000 cycles are played, as many as an hour of play has.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import uvicorn
from playwright.sync_api import Page, sync_playwright

from cprm_gym.agents.outfielder.agent import outfielder_cprm
from cprm_gym.architecture.petri.drawing.plan import drawing_plan
from cprm_gym.studio.running.frames import frame
from cprm_gym.studio.running.run import Run
from cprm_gym.studio.running.setup import Setup
from cprm_gym.studio.server import listen, make_app
from cprm_gym.studio.sockets import Pages, to_text
from cprm_gym.studio.studio import Studio

TOKEN = "benchmark"
CYCLES = 60
SHOWN = """async (plan) => {
  const { NetCanvas } = await import("./static/js/netcanvas.js");
  const holder = document.createElement("div");
  holder.style.cssText = "position: fixed; inset: 0; background: white; z-index: 99";
  document.body.append(holder);
  const canvas = new NetCanvas(holder, { editable: false });
  canvas.show(plan);
  window.shown = { canvas, plan };
}"""
FRAMES = """async () => {
  const { canvas, plan } = window.shown;
  const places = plan.nodes.filter((n) => n.kind === "place").map((n) => n.key);
  const transitions = plan.nodes.filter((n) => ["immediate", "timed", "output"].includes(n.kind)).map((n) => n.key);
  const start = performance.now();
  let count = 0;
  await new Promise((done) => {
    const draw = () => {
      const marking = {};
      for (let i = 0; i < 8; i += 1) marking[places[(8 * count + i) % places.length]] = count % 2;
      canvas.update({ marking, fired: [0, 1, 2, 3].map((i) => transitions[(4 * count + i) % transitions.length]) });
      count += 1;
      if (performance.now() - start < 4000) requestAnimationFrame(draw);
      else done();
    };
    requestAnimationFrame(draw);
  });
  return [count, (performance.now() - start) / 1000];
}"""


class Served:
    """A studio behind a server of this process."""

    def __init__(self, **options: Any) -> None:
        pages = Pages()
        self.studio = Studio(pages.publish, **options)
        self.socket = listen("127.0.0.1", 0)
        host = f"127.0.0.1:{self.socket.getsockname()[1]}"
        self.address = f"http://{host}/?token={TOKEN}"
        app = make_app(self.studio.calls, pages, TOKEN, (host,))
        self.server = uvicorn.Server(uvicorn.Config(app, log_level="error", ws="websockets-sansio", lifespan="off"))
        threading.Thread(target=self.server.run, args=([self.socket],), daemon=True).start()
        while not self.server.started:
            time.sleep(0.02)

    def close(self) -> None:
        self.server.should_exit = True
        self.studio.close()


def metrics(page: Page) -> dict[str, float]:
    """What Chromium says of the page, after a collection: bytes of its heap, elements."""
    client = page.context.new_cdp_session(page)
    client.send("Performance.enable")
    client.send("HeapProfiler.collectGarbage")
    found = {m["name"]: m["value"] for m in client.send("Performance.getMetrics")["metrics"]}
    client.detach()
    return found


def browser_seconds() -> float:
    """CPU seconds of all processes of browsers that this one started: the page's thread, what draws, what puts it together."""
    parents, spent = {}, {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                fields = (entry / "stat").read_text().rpartition(") ")[2].split()
            except OSError:
                continue
            parents[int(entry.name)], spent[int(entry.name)] = int(fields[1]), int(fields[11]) + int(fields[12])
    mine = {os.getpid()}
    while more := {pid for pid, parent in parents.items() if parent in mine} - mine:
        mine |= more
    return sum(spent[pid] for pid in mine - {os.getpid()}) / os.sysconf("SC_CLK_TCK")


def show(what: str, value: str) -> None:
    print(f"{what:80} {value:>16}", flush=True)


def of_a_cycle(open_page: Any) -> None:
    """22 agents, one in full: what the server and the page do for a cycle."""
    run = Run(Setup("Soccer11v11", seed=1, options={"controlled": "all"}))
    for _ in range(20):
        run.advance()
    size = spent = 0.0
    for _ in range(CYCLES):
        run.advance()
        start = time.thread_time()
        text = to_text({"event": "frame", "frame": frame(run, ["left_9"], {}), "cycles": [0, run.cycle]})
        spent += time.thread_time() - start
        size += len(text)
    show("22 agents, one in full: server, a frame made and written", f"{spent / CYCLES * 1e3:.1f} ms CPU")
    show("22 agents, one in full: a frame", f"{size / CYCLES / 1e3:.1f} kB")
    served = Served(demo="eleven", seed=1)
    page = open_page(served.address)
    page.wait_for_selector(".netcanvas .node", timeout=120_000)
    served.studio.session.show(["left_9"])
    page.wait_for_timeout(3000)
    spent = browser_seconds()
    for _ in range(CYCLES):
        cycle = served.studio.session.step()["cycle"]
        page.wait_for_function("(c) => document.querySelector('[data-show=cycle]').textContent === `cycle ${c}`", arg=cycle)
    show("22 players, one in full: the browser, a frame read and drawn", f"{(browser_seconds() - spent) / CYCLES * 1e3:.1f} ms CPU")
    page.close()
    served.close()


def of_two_runs(open_page: Any) -> None:
    """The goalie and, beside him, the one who is not blinded."""
    served = Served(demo="goalie", seed=4)
    page = open_page(served.address)
    page.wait_for_selector(".netcanvas .node", timeout=120_000)
    served.studio.debugger.change("blind", "left_1", cycles=20)
    page.keyboard.press("x")
    page.wait_for_selector(".net-there .netcanvas .node")
    page.wait_for_timeout(2000)
    ours, theirs, cycles = time.process_time(), browser_seconds(), 0
    while not served.studio.session.there().over and cycles < CYCLES:
        cycle = served.studio.session.step()["cycle"]
        page.wait_for_function("(c) => document.querySelector('[data-show=cycle]').textContent === `cycle ${c}`", arg=cycle)
        cycles += 1
    show("two runs side by side: both played, compared and written, a cycle", f"{(time.process_time() - ours) / cycles * 1e3:.1f} ms CPU")
    show("two runs side by side: the browser, a frame read and drawn", f"{(browser_seconds() - theirs) / cycles * 1e3:.1f} ms CPU")
    page.close()
    served.close()


def of_the_largest_net(open_page: Any) -> None:
    """The outfielder's net, unfolded with all quantities."""
    start = time.process_time()
    plan = drawing_plan(outfielder_cprm().net, -1)
    show("outfielder unfolded: layout", f"{time.process_time() - start:.2f} s CPU")
    served = Served()
    page = open_page(served.address)
    page.wait_for_selector("[data-do=watch]")
    page.evaluate(SHOWN, plan)
    for seen, look in (("all of it", "window.shown.canvas.fit()"), ("as large as can be read", "window.shown.canvas.read()")):
        page.evaluate(look)
        page.wait_for_timeout(2000)
        spent = browser_seconds()
        count, seconds = page.evaluate(FRAMES)
        spent = browser_seconds() - spent
        show(f"outfielder, {len(plan['nodes'])} nodes, {len(plan['links'])} arcs, 12 changing, {seen}", f"{count / seconds:.1f} frames / s")
        show(f"outfielder, {seen}: the browser, a frame", f"{spent / count * 1e3:.1f} ms CPU")
    page.close()
    served.close()


def of_opening(open_page: Any) -> None:
    """From the address to the net and the field of the striker."""
    for attempt in ("first", "second"):
        served = Served(demo="striker")
        start, spent, browser = time.perf_counter(), time.process_time(), browser_seconds()
        page = open_page(served.address)
        page.wait_for_selector(".netcanvas .node", timeout=60_000)
        page.wait_for_selector(".field .thing")
        cpu = time.process_time() - spent
        show(f"striker opened, {attempt} time", f"{time.perf_counter() - start:.2f} s")
        show(f"striker opened, {attempt} time: server, browser", f"{cpu:.2f}, {browser_seconds() - browser:.2f} s CPU")
        page.close()
        served.close()


def of_an_hour(open_page: Any) -> None:
    """36,000 cycles of a player in matches, a page watching."""
    served = Served()
    page = open_page(served.address)
    session = served.studio.session
    played = 0
    page.wait_for_selector("[data-do=watch]")
    page.click("[data-view=watch][role=tab]")
    for match in range(6):
        session.begin(Setup("Soccer11v11", seed=match, options={"controlled": "left_9", "others": "weak", "max_cycles": 6000}))
        session.set_speed(1000)
        session.play()
        while session._playing.is_set():
            page.wait_for_timeout(500)
        played += session.there().cycle
        rss = int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6
        heap = metrics(page)["JSHeapUsedSize"] / 1e6
        show(f"after {played:,} cycles: server, page's heap", f"{rss:.0f} MB, {heap:.1f} MB")
    page.close()
    served.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--hour", action="store_true", help="the memory of 36,000 cycles, some minutes")
    options = parser.parse_args()
    path = shutil.which("chromium") or shutil.which("google-chrome")
    print(json.dumps({"load": os.getloadavg(), "cpus": os.cpu_count()}))
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        os.environ["XDG_STATE_HOME"] = folder
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])

        def open_page(address: str) -> Page:
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.goto(address)
            return page

        if options.hour:
            of_an_hour(open_page)
        else:
            of_opening(open_page)
            of_a_cycle(open_page)
            of_two_runs(open_page)
            of_the_largest_net(open_page)
        browser.close()


if __name__ == "__main__":
    main()
