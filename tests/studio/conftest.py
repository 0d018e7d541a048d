"""A studio behind a real server, and a real browser before it; skipped with a reason where there is none."""

import contextlib
import shutil
import threading
import time

import pytest

TOKEN = "token-of-the-tests"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


class Served:
    """A studio that is reached at `address`."""

    def __init__(self, **options):
        from cprm_gym.studio.server import listen, make_app
        from cprm_gym.studio.sockets import Pages
        from cprm_gym.studio.studio import Studio

        uvicorn = pytest.importorskip("uvicorn")
        pytest.importorskip("starlette")
        self.pages = Pages()
        self.studio = Studio(self.pages.publish, **options)
        self.socket = listen("127.0.0.1", 0)
        self.port = self.socket.getsockname()[1]
        self.address = f"http://127.0.0.1:{self.port}/?token={TOKEN}"
        app = make_app(self.studio.calls, self.pages, TOKEN, (f"127.0.0.1:{self.port}",))
        config = uvicorn.Config(app, log_level="error", ws="websockets-sansio", lifespan="off", timeout_graceful_shutdown=1)
        self.server = uvicorn.Server(config)
        self.thread = threading.Thread(target=self.server.run, args=([self.socket],), daemon=True)
        self.thread.start()
        for _ in range(200):
            if self.server.started:
                break
            time.sleep(0.05)

    def close(self):
        self.server.should_exit = True
        self.thread.join(10)
        self.socket.close()
        self.studio.close()


@pytest.fixture
def serve(monkeypatch, tmp_path):
    """Starts studios; their breakpoints and drafts lie in the test's own folder."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.chdir(tmp_path)
    with contextlib.ExitStack() as stack:

        def start(**options):
            made = Served(**options)
            stack.callback(made.close)
            return made

        yield start


@pytest.fixture(scope="session")
def browser():
    """The system's Chromium, without a window."""
    sync_api = pytest.importorskip("playwright.sync_api")
    path = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if path is None:
        pytest.skip("no browser: apt-get install -y chromium")
    with sync_api.sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield made
        made.close()


@pytest.fixture
def open_page(browser):
    """Opens pages at 1280 x 800; an error in one of them fails the test."""
    wrong = []
    with contextlib.ExitStack() as stack:

        def open_at(address):
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            stack.callback(page.close)
            page.set_default_timeout(15000)
            page.on("pageerror", lambda error: wrong.append(f"{error}"))
            page.goto(address)
            return page

        yield open_at
    assert wrong == []
