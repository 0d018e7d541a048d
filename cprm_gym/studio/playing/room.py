"""What the view Run calls."""

from __future__ import annotations

import contextlib
import re
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ...agents.catalogue import shipped_nets
from ...agents.registry import AGENTS
from ...architecture.petri import PetriNet
from ...architecture.petri.drawing.plan import drawing_plan
from ...architecture.prm import Model
from ...benchmark.statistics import wilson_interval
from ...envs.others.registry import controller_entries
from ...envs.tasks import TASKS
from ...errors import CprmError, FormatError, unknown_name
from ...wrappers.disturbances import DISTURBANCES, Disturbance
from ..running.kept_run import KeptRun, keep_run, read_run
from ..running.setup import WITH_MODEL, Setup
from ..watching.session import Session
from .episodes import Episode, play_episodes
from .results import Results
from .witnesses import analysis

Nets = Callable[[], Mapping[str, PetriNet]]
Names = list[str] | None
Models = Callable[[], Mapping[str, Model]]


class RunRoom:
    """Setups, episodes, results, analyses.

    Parameters
    ----------
    session : Session
        Where what is chosen is watched.
    nets, models : callable
        The nets and models that were opened or edited, by name.
    results : Results, optional
        That were opened.
    kept : Path, optional
        File in which the run that is watched is kept, to go on with it after the server has ended.
    """

    def __init__(self, session: Session, nets: Nets, models: Models, results: Results | None = None, kept: Path | None = None) -> None:
        self.session, self.nets, self.models, self.results = session, nets, models, results
        self.last: KeptRun | None = None
        """The run of the last time."""
        if kept is not None:
            with contextlib.suppress(FormatError):  # none, or one of another version
                self.last = read_run(kept)
            session.stood.append(lambda run: keep_run(kept, run))
        self._episodes: list[Episode] = []
        self._setup: Setup | None = None
        self._wanted = 0
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self._analyses: dict[tuple[PetriNet, float], dict[str, Any]] = {}

    def calls(self) -> Mapping[str, Callable[..., Any]]:
        """The room ``run``."""
        return {"choices": self.choices, "watch": self.watch, "episodes": self.episodes, "stop": self.stop, "played": self.played,
                "go_on": self.go_on, "results": self.table, "replay": self.replay, "analyze": self.analyze, "plan": self.plan}  # fmt: skip

    def choices(self) -> dict[str, Any]:
        """What can be chosen."""
        return {
            "tasks": list(TASKS),
            "played": sorted(AGENTS),
            "controllers": [WITH_MODEL, *controller_entries()],
            "disturbances": {name: _described(d) for name, d in DISTURBANCES.items()},
            "nets": sorted(self.nets()),
            "models": sorted(self.models()),
            "shipped": sorted(shipped_nets()),
            "setup": None if self.session.setup is None else self.session.setup.said(),
            "results": self.results is not None,
            "last": None if self.last is None else self.last.said(),
        }

    def _made(self, task: str, controller: str, seed: int, world: int, disturbance: str | None, nets: Names, models: Names) -> Setup:
        there, learned = self.nets(), self.models()
        for kind, names, known in (("net", nets, there), ("model", models, learned)):
            for name in names or ():
                if name not in known:
                    raise unknown_name(f"opened {kind}", str(name), known)
        changed = {name: there[name] for name in nets or ()}, {name: learned[name] for name in models or ()}
        return Setup(task, controller, seed, world, disturbance or None, {}, *changed)

    def watch(
        self, task: str, controller: str = WITH_MODEL, seed: int = 0, world: int = 0, disturbance: str | None = None,
        nets: Names = None, models: Names = None,
    ) -> dict[str, Any]:  # fmt: skip
        """Watch an episode."""
        self.session.begin(self._made(task, controller, seed, world, disturbance, nets, models))
        return self.session.about()

    def go_on(self) -> dict[str, Any]:
        """Watch the run of the last time, where it stood and as it was changed.

        Raises
        ------
        CprmError
            When there is none, or it was played with edited nets or models that are not open.
        """
        if self.last is None:
            raise CprmError("no run was kept")
        self.session.begin(self.last.made(self.nets(), self.models()), self.last.changes, self.last.cycle)
        return self.session.about()

    # ------------------------------------------------------------------ many episodes

    def episodes(
        self, task: str, count: int, controller: str = WITH_MODEL, seed: int = 0, world: int = 0, disturbance: str | None = None,
        nets: Names = None, models: Names = None,
    ) -> dict[str, Any]:  # fmt: skip
        """Begin to play many episodes; pages are told of each few that end."""
        if self._thread is not None and self._thread.is_alive():
            raise CprmError("episodes are being played; stop them first")
        setup = self._made(task, controller, seed, world, disturbance, nets, models)
        batches = play_episodes(setup, count, lambda: not self._stop.is_set())
        self._stop.clear()
        self._setup, self._wanted, self._episodes = setup, count, []

        def play() -> None:
            error = None
            try:
                for batch in batches:
                    self._episodes += batch
                    self._tell(True)
            except CprmError as wrong:
                error = str(wrong)
            self._tell(False, error)

        self._thread = threading.Thread(target=play, name="studio episodes", daemon=True)
        self._tell(True)  # before what the thread tells
        self._thread.start()
        return self.played()

    def _tell(self, going: bool, error: str | None = None) -> None:
        self.session.publish("episodes", {**self.played(), "going": going and len(self._episodes) < self._wanted, "error": error})

    def stop(self) -> dict[str, Any]:
        """End them; what has been played stays."""
        self._stop.set()
        return self.played()

    def played(self) -> dict[str, Any]:
        """The episodes so far."""
        done = sum(e.success for e in self._episodes)
        interval = wilson_interval(done, len(self._episodes)) if self._episodes else None
        return {
            "setup": None if self._setup is None else self._setup.said(),
            "wanted": self._wanted,
            "going": self._thread is not None and self._thread.is_alive() and len(self._episodes) < self._wanted,
            "success": done,
            "low": None if interval is None else interval.low,
            "high": None if interval is None else interval.high,
            "episodes": [e.said() for e in self._episodes],
            "error": None,
        }

    # ------------------------------------------------------------------ results and analyses

    def table(self) -> dict[str, Any]:
        """The results that were opened.

        Raises
        ------
        CprmError
            When there are none.
        """
        if self.results is None:
            raise CprmError("no results are open: start the studio with --log FOLDER, a folder that cprm-gym benchmark wrote")
        return self.results.table()

    def replay(self, task: str, controller: str, world: int) -> dict[str, Any]:
        """Watch the episode behind a number."""
        if self.results is None:
            return self.table()
        return self.watch(**self.results.setup(task, controller, world))

    def _net(self, net: str) -> PetriNet:
        known = {**shipped_nets(), **self.nets()}
        if net not in known:
            raise unknown_name("net", net, known)
        return known[net]

    def analyze(self, net: str, seconds: float = 20.0) -> dict[str, Any]:
        """What the analysis says of a net, and the runs that show it."""
        if isinstance(seconds, bool) or not isinstance(seconds, (int, float)) or not 0 < seconds <= 600:
            raise CprmError(f"seconds: above 0, at most 600, got {seconds!r}")
        wanted = self._net(net)
        if (wanted, seconds) not in self._analyses:
            while len(self._analyses) > 20:
                self._analyses.pop(next(iter(self._analyses)))
            self._analyses[wanted, seconds] = analysis(wanted, seconds)
        return self._analyses[wanted, seconds]

    def plan(self, net: str) -> dict[str, Any]:
        """Where everything in its drawing stands."""
        return drawing_plan(self._net(net), -1, quantities=False)

    def close(self) -> None:
        """End what runs."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(3.0)


def _described(disturbance: Disturbance) -> str:
    """What it does, with its sizes."""
    line = (type(disturbance).__doc__ or "").partition("\n")[0]
    return re.sub(r"`(\w+)`", lambda found: str(getattr(disturbance, found[1], found[1])), line)
