"""The pictures of `studio.md`, taken of the studio itself: ``python docs/studio_pictures.py``, with the system's Chromium.

The steps are those of the page, done by mouse and keys.
"""

from __future__ import annotations

import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

IMAGES = Path(__file__).parent / "images"
COLOURS = 256
"""Of a picture: enough for what is drawn, and half of the size."""


def take(page: Page, name: str) -> None:
    """A picture of the page as it is."""
    whole = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    picture = whole.quantize(COLOURS, kmeans=2, dither=Image.Dither.NONE)
    picture.save(IMAGES / f"studio_{name}.png", optimize=True)
    print(f"studio_{name}.png, {(IMAGES / f'studio_{name}.png').stat().st_size / 1e3:.0f} kB")


def watch(page: Page) -> None:
    """The goalie, stopped as he leaps."""
    page.wait_for_selector(".netcanvas .node", timeout=120_000)
    page.wait_for_timeout(2000)
    page.fill("[type=search]", "leap")
    page.keyboard.press("Enter")
    page.click("[data-do=break]")
    page.wait_for_selector(".break")
    page.click("[data-do=play]")
    page.wait_for_selector(".break.struck")
    page.wait_for_timeout(4500)
    take(page, "watch")


def ask(page: Page) -> None:
    """Why a transition did not fire, and which reading moved the belief about the ball."""
    page.fill("[type=search]", "hold")
    page.keyboard.press("Enter")
    page.wait_for_selector(".conditions")
    page.wait_for_timeout(300)
    take(page, "why")
    page.click(".belief[data-variable='ball.x']")
    page.wait_for_function("() => document.querySelector('.ask h3')?.textContent === 'What moved ball.x'")
    page.select_option("[data-show=compare]", "same")
    page.keyboard.press("c")
    page.select_option("[data-show=change-kind]", "blind")
    page.click("[data-do=change]")
    page.wait_for_timeout(300)
    for _ in range(6):
        page.keyboard.press("ArrowRight")
        page.wait_for_timeout(500)
    page.keyboard.press("l")
    take(page, "beside")


def edit(page: Page) -> None:
    """A goalie who runs out only where he is first by far."""
    page.fill("section[data-view=watch] [type=search]", "loose")
    page.keyboard.press("Enter")
    page.click("[data-do=edit]")
    field = page.locator("section[data-view=nets]").get_by_label("expression", exact=True)
    field.fill(field.inner_text().replace("+ 20", "- 20"))
    field.press("Enter")
    page.wait_for_timeout(2500)
    take(page, "nets")


def play(page: Page) -> None:
    """Both goalies in the same hundred worlds."""
    page.keyboard.press("Alt+4")
    page.wait_for_selector("[data-do=episodes]")
    page.fill("[data-field=count]", "100")
    for changed in (False, True):
        if changed:
            page.check("[data-net=goalie]")
        page.click("[data-do=episodes]")
        page.wait_for_timeout(1000)
        page.wait_for_function("() => /of 100 succeeded/.test(document.querySelector('[data-show=episodes]').textContent)", timeout=300_000)
        print("changed:" if changed else "as it ships:", page.inner_text("[data-show=episodes]"))
    take(page, "run")


def main() -> None:
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    with tempfile.TemporaryDirectory() as folder:
        kernels = os.environ.get("CPRM_GYM_CACHE") or str(Path.home() / ".cache" / "cprm_gym")
        ours = {**os.environ, "HOME": folder, "CPRM_GYM_CACHE": kernels}
        ours.pop("XDG_STATE_HOME", None)
        command = [sys.executable, "-m", "cprm_gym", "studio", "--demo", "goalie", "--seed", "0", "--no-browser"]
        server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=ours, cwd=folder)
        try:
            assert server.stdout is not None
            found = re.search(r"http\S+", server.stdout.readline())
            assert found is not None, "the studio did not start"
            with sync_playwright() as playwright:
                made = playwright.chromium.launch(executable_path=browser, args=["--no-sandbox"])
                page = made.new_page(viewport={"width": 1280, "height": 800})
                page.goto(found[0])
                for step in (watch, ask, edit, play):
                    step(page)
                made.close()
        finally:
            server.terminate()
            server.wait(10)


if __name__ == "__main__":
    main()
