"""What is asked and changed of the run under watch, and where it stops: the rest of the room ``watch``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ...architecture.petri import ObjectPlace, PetriNet, instances
from ...architecture.petri.drawing.plan import drawing_plan
from ...errors import CprmError, ParameterError, unknown_name
from ..running.changes import Change, failing
from ..running.frames import Message, quantities, variables
from ..running.memory import runner_of
from ..running.run import Run
from . import questions
from .breakpoints import MOST, Breakpoint, read_breakpoints, write_breakpoints
from .session import Session

LOOK_BACK = 2000
"""Cycles that are searched for when a condition last held."""


class Debugger:
    """Breakpoints, questions and changes.

    Parameters
    ----------
    session : Session
    place : Path
        File of the breakpoints.

    Raises
    ------
    FormatError
        When that file is damaged.
    """

    def __init__(self, session: Session, place: Path) -> None:
        self.session, self.place = session, place
        self.breakpoints = read_breakpoints(place)
        self._held: dict[tuple[str, str], bool] = {}
        session.stops.append(self.stop)
        session.begun.append(self._begin)
        session.extras.append(self._add)

    def calls(self) -> Mapping[str, Callable[..., Any]]:
        """What pages may call."""
        return {"inside": self.inside, "plan": self.plan, "firings": self.firings, "why": self.why, "moved": self.moved,
                "change": self.change, "undo": self.undo, "breakpoints": self.list_breakpoints, "break": self.set_breakpoint,
                "unbreak": self.remove_breakpoint}  # fmt: skip

    # ------------------------------------------------------------------ what there is

    def inside(self, agent: str, beside: bool = False) -> Message:
        """What an agent is made of, in this run or in the one beside it: the names of which one can ask, and his variables."""
        with self.session.lock:
            run = self.session.there(beside)
            if agent not in run.agents:
                raise unknown_name("agent", agent, run.agents)
            runner = runner_of(run.players[run.agents.index(agent)])
            if runner is None:
                return {"net": None, "kind": run.setup.controller}
            compiled, cprm = runner.executor.net, runner.cprm
            holds = {
                p.name: [o for o, c in cprm.objects.items() if c == p.class_name] for p in compiled.net.places if isinstance(p, ObjectPlace)
            }
            known = {}
            for name, v in variables(runner).items():
                known[name] = {
                    "states": list(v.states) if v.edges is None else [],
                    "edges": None if v.edges is None else [float(e) for e in v.edges],
                    "unit": v.unit,
                    "auxiliary": v.auxiliary,
                }
            return {
                "net": cprm.net.name,
                "places": list(compiled.place_names),
                "transitions": list(compiled.transition_names),
                "quantities": sorted(quantities(runner)),
                "delays": {n: int(d) for n, d in zip(compiled.transition_names, compiled.delay) if d},
                "modules": _ongoing(cprm.net),
                "failing": failing(cprm.net),
                "holds": holds,
                "variables": known,
                "readings": [o.variable for o in cprm.observations],
                "percepts": sorted(runner._percepts),
                "reads": {b.name: b.variable for b in runner.executor.belief_places},
            }

    def plan(self, agent: str, unfold: list[str] | int = 0, quantities: bool = False, beside: bool = False) -> Message:
        """Where everything in a drawing of an agent's net stands."""
        with self.session.lock:
            net = questions.runner_in(self.session.there(beside), agent).cprm.net
        if not isinstance(unfold, int) and not (isinstance(unfold, list) and all(isinstance(u, str) for u in unfold)):
            raise ParameterError(f"unfold: levels or paths of modules, got {unfold!r}")
        return drawing_plan(net, unfold if isinstance(unfold, int) else frozenset(unfold), quantities=bool(quantities))

    # ------------------------------------------------------------------ questions

    def firings(self, agent: str, cycle: int | None = None, beside: bool = False) -> list[Message]:
        """What fired in a cycle, one after the other."""
        with self._standing(cycle, beside) as run:
            return questions.firings(run, agent)

    def why(self, agent: str, transition: str, cycle: int | None = None, beside: bool = False) -> Message:
        """Why a transition did not fire."""
        with self._standing(cycle, beside) as run:
            return questions.why_not(run, agent, transition, self._earlier(agent, run.cycle, beside))

    @contextmanager
    def _standing(self, cycle: int | None, beside: bool) -> Iterator[Run]:
        """The run, or the one beside it, in a cycle: the present one if none is given."""
        with self.session.lock:
            run = self.session.there(beside)
            with run.standing_in(run.cycle if cycle is None or (beside and run.over and cycle > run.cycle) else cycle):
                yield run

    def _earlier(self, agent: str, cycle: int, beside: bool) -> Iterator[tuple[int, Mapping[str, Any]]]:
        frames = self.session.frames
        for earlier in range(cycle - 1, max(-1, cycle - LOOK_BACK), -1):
            shown = frames.get(earlier, {})
            shown = (shown.get("other", {}) if beside else shown).get("agents", {}).get(agent)
            if shown is None or "marking" not in shown:
                return
            yield earlier, shown["marking"]

    def moved(self, agent: str, variable: str, cycle: int | None = None, beside: bool = False) -> Message:
        """Which readings moved a belief."""
        with self._standing(cycle, beside) as run:
            return questions.moved(run, agent, variable)

    # ------------------------------------------------------------------ changes by hand

    def change(self, kind: str, whom: str = "", name: str = "", values: list[float] | None = None, cycles: int = 1) -> Message:
        """Change something before the run goes on."""
        self.session.pause()
        with self.session.lock:
            run = self.session.there()
            if run.over:
                raise CprmError("the episode is over: go back to change something")
            run.change(Change(run.cycle, kind, whom, name, tuple(values or ()), cycles))
            return self.session.again()

    def undo(self) -> Message:
        """Take back the last change of this cycle."""
        with self.session.lock:
            run = self.session.there()
            if not run.hands.log or run.hands.log[-1].cycle != run.cycle:
                raise CprmError("nothing was changed in this cycle")
            run.hands.log.pop()
            return self.session.again()

    # ------------------------------------------------------------------ breakpoints

    def list_breakpoints(self) -> Message:
        """By net, and where they are kept."""
        return {"nets": {net: [asdict(b) for b in of] for net, of in self.breakpoints.items()}, "file": _short(self.place)}

    def set_breakpoint(self, net: str, kind: str, what: str = "", on: bool = True) -> Message:
        """Set a breakpoint, or switch it on or off."""
        made = Breakpoint(kind, what, on)
        with self.session.lock:
            run = self.session.there()
            nets = {r.cprm.net.name: r for r in map(runner_of, run.players) if r is not None}
            if net not in nets:
                raise unknown_name("net", net, nets)
            made.check(nets[net])
            others = [b for b in self.breakpoints.get(net, []) if b.key != made.key]
            if len(others) >= MOST:
                raise ParameterError(f"net {net!r} has {MOST} breakpoints already")
            self.breakpoints[net] = [*others, made]
            self._note_all(run)
        return self._changed()

    def remove_breakpoint(self, net: str, kind: str, what: str = "") -> Message:
        """Take a breakpoint away."""
        key = Breakpoint(kind, what).key
        with self.session.lock:
            left = [b for b in self.breakpoints.get(net, []) if b.key != key]
            if len(left) == len(self.breakpoints.get(net, [])):
                raise unknown_name("breakpoint", key, [b.key for b in self.breakpoints.get(net, [])])
            self.breakpoints[net] = left
        return self._changed()

    def _changed(self) -> Message:
        write_breakpoints(self.place, self.breakpoints)
        listed = self.list_breakpoints()
        self.session.publish("breakpoints", {"breakpoints": listed})
        return listed

    def _begin(self, run: Run) -> None:
        self._held.clear()
        self._note_all(run)

    def _note_all(self, run: Run) -> None:
        for name, _, b, holds in self._each(run):
            self._held[name, b.key] = holds

    def _each(self, run: Run) -> Iterator[tuple[str, str, Breakpoint, bool]]:
        """Every breakpoint of every agent, and whether it holds now."""
        for name, player in zip(run.agents, run.players):
            runner = runner_of(player)
            of = [] if runner is None else self.breakpoints.get(runner.cprm.net.name, [])
            if runner is None or not of:
                continue
            fired = set() if run.over or runner.executor.trace is None else {f.transition for f in runner.executor.trace.firings(0)}
            for b in of:
                yield name, runner.cprm.net.name, b, b.holds(runner, fired, run.cycle, run.over)

    def stop(self, run: Run, made: Message) -> str | None:
        """Why the run stops in this cycle: a firing, or something that holds now and did not before."""
        why = []
        hit: list[Message] = []
        for name, net, b, holds in self._each(run):
            before = self._held.get((name, b.key), False)
            self._held[name, b.key] = holds
            if b.on and holds and (b.kind == "fires" or not before):
                text = {"fires": f"{b.what} fired", "marked": f"{b.what} is marked", "when": b.what, "ends": "the episode has ended"}[
                    b.kind
                ]
                why.append(f"{name}: {text}")
                hit.append({"agent": name, "net": net, **asdict(b)})
        if hit:
            made["hit"] = hit
        return "; ".join(why) or None

    def _add(self, run: Run, made: Message) -> None:
        """How many changes could be taken back in this cycle."""
        made["undo"] = sum(c.cycle == run.cycle for c in run.hands.log)


def _ongoing(net: PetriNet) -> dict[str, str]:
    """Module path -> the place that is marked while it is at work."""
    return {path: inst.places[inst.net.ports.ongoing] for path, inst in instances(net).items() if path and inst.net.ports.ongoing}


def _short(path: Path) -> str:
    """A path as one says it, with ``~`` for the own folder."""
    home = Path.home()
    return f"~/{path.relative_to(home).as_posix()}" if home in path.parents else str(path)
