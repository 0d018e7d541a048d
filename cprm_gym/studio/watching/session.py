"""The run that the pages watch, and the thread that plays it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from ...errors import CprmError, ParameterError, unknown_name
from ..running.changes import Change
from ..running.frames import Message, frame
from ..running.recording import Recording
from ..running.run import Run
from ..running.setup import Setup
from .frame_store import Frames

MOST_STEPS = 6000
"""Cycles of one step: a match."""
FASTEST = 1000.0
"""Most cycles in a second that may be asked for; as many are played as can be."""
PICTURES = 30.0
"""Most frames in a second that are sent while it plays."""
LOG = 300
"""Most cycles of which a page that opens, or was not told for a while, is given a line."""
Call = Callable[..., Any]


class Session:
    """A run under watch. Pages call, one at a time; a thread of its own plays.

    Parameters
    ----------
    publish : callable
    setup : Setup, optional
        What is watched first; it is made when a page first asks, for that takes a while.
    """

    def __init__(self, publish: Call, setup: Setup | None = None) -> None:
        self.publish, self.setup = publish, setup
        self.run: Run | None = None
        self.recording: Recording | None = None
        """A log that is looked at instead of a run."""
        self.beside: Run | None = None
        """Another run in the same cycle, with which this one is compared."""
        self.shown: list[str] = []
        self.asked: dict[str, list[str]] = {}
        self.speed = 10.0
        self._frames = Frames()
        self._untold: list[int] = []
        self._lock = threading.RLock()
        self._playing = threading.Event()
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None
        self.stops: list[Callable[[Run, Message], str | None]] = []
        """Each is asked after a cycle whether the run stops there, and says why."""
        self.begun: list[Callable[[Run], object]] = []
        """Told of a run that has been made."""
        self.stood: list[Callable[[Run], object]] = []
        """Told of a run that stands somewhere, paused."""
        self.extras: list[Callable[[Run, Message], object]] = []
        """Each may add something to a frame."""

    # ------------------------------------------------------------------ what pages call

    def calls(self) -> Mapping[str, Call]:
        """The room ``watch``."""
        return {"open": self.open, "state": self.state, "frame": self.frame, "play": self.play, "pause": self.pause, "step": self.step,
                "go": self.go, "show": self.show, "speed": self.set_speed}  # fmt: skip

    def open(self) -> dict[str, Any]:
        """All that a page needs to begin: who plays, and the cycle in which the run stands."""
        with self._lock:
            if self.run is None and self.recording is None:
                if self.setup is None:
                    return {"run": None}
                self.begin(self.setup, told=False)  # a page that opens is given it as the answer
            log = [brief(made, self.shown) for made in self._frames.last(LOG)]
            return {"run": self.about(), "state": self.state(), "frame": self._now(), "log": log}

    def about(self) -> dict[str, Any]:
        """What does not change from cycle to cycle."""
        return self._shown_run().about()

    def state(self) -> dict[str, Any]:
        """Whether it plays, and which agents are shown in full."""
        return {"playing": self._playing.is_set(), "speed": self.speed, "shown": list(self.shown), "cycles": self._span()}

    def frame(self, cycle: int) -> Message:
        """A cycle that was played."""
        with self._lock:
            if self.recording is not None and isinstance(cycle, int) and 0 <= cycle < len(self.recording):
                return self.recording.picture(cycle)
            if cycle not in self._frames:
                raise ParameterError(f"cycle {cycle!r} is not among those played: {self._span()}")
            return self._frames[cycle]

    def play(self) -> dict[str, Any]:
        """Let it go on."""
        with self._lock:
            run = self._shown_run()
            if run.over:
                raise CprmError("the episode is over: go back, or begin anew")
            if self._thread is None:
                self._thread = threading.Thread(target=self._play, name="studio run", daemon=True)
                self._thread.start()
            self._playing.set()
        return self._say_state()

    def pause(self) -> dict[str, Any]:
        """Stop at the next decision."""
        self._playing.clear()
        with self._lock:
            if self._untold:  # cycles since the last frame that was sent
                self._tell()
            return self._say_state()

    def step(self, cycles: int = 1) -> Message:
        """Go on by some cycles, and stop."""
        if isinstance(cycles, bool) or not isinstance(cycles, int) or not 1 <= cycles <= MOST_STEPS:
            raise ParameterError(f"cycles: 1 to {MOST_STEPS}, got {cycles!r}")
        self.pause()
        with self._lock:
            run = self._shown_run()
            for _ in range(cycles):
                run.advance()
                stopped = self._stopped(self._note())
                if run.over or stopped:
                    break
            return self._tell()

    def go(self, cycle: int) -> Message:
        """Stand in another cycle, and stop."""
        self.pause()
        with self._lock:
            run = self._shown_run()
            if cycle < 0:
                raise ParameterError(f"cycle: a whole number from 0 is needed, got {cycle}")
            if self.recording is None:
                self._frames.drop_after(cycle)
            run.go_to(cycle, lambda _: self._note())
            self._note()
            return self._tell()

    def show(self, agents: list[str], variables: dict[str, list[str]] | None = None) -> Message:
        """Choose whom to show in full, and which of his beliefs."""
        with self._lock:
            run = self._there()
            for name in agents:
                if name not in run.agents:
                    raise unknown_name("agent", str(name), run.agents)
            self.shown = list(agents)
            self.asked = {} if variables is None else {str(k): [str(v) for v in names] for k, names in variables.items()}
            self._say_state()
            self._note()
            return self._tell()

    def set_speed(self, cycles: float) -> dict[str, Any]:
        """How many cycles are played in a second."""
        if isinstance(cycles, bool) or not isinstance(cycles, (int, float)) or not 0 < cycles <= FASTEST:
            raise ParameterError(f"speed: above 0, at most {FASTEST:g} cycles in a second, got {cycles!r}")
        self.speed = float(cycles)
        return self._say_state()

    # ------------------------------------------------------------------ inside

    def begin(self, setup: Setup, changes: Iterable[Change] = (), cycle: int = 0, told: bool = True) -> None:
        """Make another run the one that is watched, with what was changed by hand in it, up to a cycle."""
        self._playing.clear()
        with self._lock:
            run = Run(setup)
            run.hands.log = list(changes)
            self.setup, self.run, self.recording = setup, run, None
            self._frames.clear()
            self.shown = [name for name in self.shown if name in run.agents] or list(run.agents[:1])
            for hear in self.begun:
                hear(run)
            self._note()
            run.go_to(cycle, lambda _: self._note())
        if told:
            self.publish("run", {"run": self.about()})

    def look_at(self, recording: Recording) -> None:
        """Show a log instead of a run."""
        self._playing.clear()
        with self._lock:
            self.recording, self.run, self.shown = recording, None, []
            self._frames.clear()
            self._note()

    @property
    def lock(self) -> threading.RLock:
        """Held while the run is used."""
        return self._lock

    @property
    def frames(self) -> Mapping[int, Message]:
        """Cycle -> frame of those that can be looked at again."""
        return self._frames

    def keep(self, made: Message) -> None:
        """Put back a frame to which something was added."""
        self._frames.put(made)

    def there(self, beside: bool = False) -> Run:
        """The run, or the one beside it.

        Raises
        ------
        CprmError
            When there is none.
        """
        run = self._there()
        if not beside:
            return run
        if self.beside is None:
            raise CprmError("no other run is beside this one: choose one above the field")
        return self.beside

    def again(self) -> Message:
        """Make the frame of this cycle anew, because something was changed."""
        self._note()
        return self._tell()

    def _stopped(self, made: Message) -> str | None:
        """Why the run stops in this cycle, told to the pages."""
        run = self.run
        reasons = [] if run is None else [reason for stop in self.stops if (reason := stop(run, made)) is not None]
        if not reasons:
            return None
        self.publish("stopped", {"cycle": made["cycle"], "why": reasons})
        made["stopped"] = reasons
        return reasons[0]

    def _there(self) -> Run:
        if self.recording is not None:
            raise CprmError(f"{self.recording.path} is a log, which holds no nets and beliefs, and can only be looked at")
        if self.run is None:
            raise CprmError("nothing is being watched: choose what to play in the view Run")
        return self.run

    def _shown_run(self) -> Run | Recording:
        return self.recording or self._there()

    def _span(self) -> list[int]:
        if self.recording is not None:
            return [0, len(self.recording) - 1]
        return self._frames.span()

    def _note(self) -> Message:
        """Keep the frame of the cycle in which the run stands."""
        run = self._shown_run()
        if isinstance(run, Recording):
            made = run.picture()
        else:
            made = frame(run, self.shown, self.asked)
            for add in self.extras:
                add(run, made)
        self._frames.put(made)
        self._untold.append(run.cycle)
        return made

    def _now(self) -> Message:
        return self._frames[self._shown_run().cycle]

    def _tell(self, passing: bool = False) -> Message:
        now = self._now()
        if self.run is not None and self.recording is None and not passing:
            for told in self.stood:
                told(self.run)
        passed = [brief(self._frames[c], self.shown) for c in self._untold[-LOG:] if c in self._frames]
        self._untold.clear()
        if passed:
            self.publish("log", {"passed": passed})
        self.publish("frame", {"frame": now, "cycles": self._span()}, passing=passing)
        return now

    def _say_state(self) -> dict[str, Any]:
        state = self.state()
        self.publish("state", {"state": state})
        return state

    def _play(self) -> None:
        """Of the playing thread: cycle after cycle, in time."""
        due = sent = time.monotonic()
        while not self._ended.is_set():
            if not self._playing.wait(0.2):
                due = time.monotonic()
                continue
            try:
                with self._lock:
                    if not self._playing.is_set():
                        continue
                    run = self._shown_run()
                    run.advance()
                    stop = self._stopped(self._note()) is not None or run.over
                    if stop:
                        self._playing.clear()
                    now = time.monotonic()
                    if stop or now - sent >= 1 / PICTURES:
                        self._tell(passing=not stop)
                        sent = now
                    if stop:
                        self._say_state()
            except CprmError as error:
                self._playing.clear()
                self.publish("trouble", {"error": str(error)})
                self._say_state()
                continue
            due = max(due + 1 / self.speed, time.monotonic() - 0.5)
            self._ended.wait(max(0.0, due - time.monotonic()))

    def close(self) -> None:
        """End the playing thread."""
        self._ended.set()
        self._playing.clear()
        if self._thread is not None:
            self._thread.join(2.0)
        if self.run is not None and self.recording is None:
            for told in self.stood:
                told(self.run)


def brief(made: Message, shown: list[str]) -> Message:
    """A line of the log of decisions."""
    inner = made["agents"].get(shown[0], {}) if shown else {}
    said: Message = {key: made[key] for key in ("cycle", "over", "status", "changes", "stopped") if key in made}
    command = made["commands"].get(shown[0], "") if shown else ""
    return {**said, "command": command, "commands": inner.get("commands", {}), "fired": inner.get("fired", [])}
