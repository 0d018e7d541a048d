"""Extended Petri nets: frozen values that run in real time, in any number of copies, and can be analysed.

The firing rule (dissertation §2.2 and §4.1, with its open questions decided)
=============================================================================

**Marking.** A discrete place holds tokens, an object place at most one object of its class. Continuous, input, belief and math
places hold a real number that transitions never change.

**Enabled.** A transition is enabled iff, in the current marking m,

* every input place holds at least the weight of its arc, and every test arc finds at least its threshold; a place with both
  needs the larger of the two. Test arcs reserve nothing;
* every inhibitor arc finds *less* than its threshold (default 1). A test and an inhibitor arc of one threshold are exact
  complements, on real-valued places too;
* no place would exceed its capacity after consuming and producing. (``Semantics(capacity="weak")``: nor with the tokens
  produced but none yet consumed.) An occupied object place is full. Capacity never clips.

Set arcs never affect enabledness; the output arc beside a set arc still needs its room.

**Firing.** First the command of an output transition is read, in the marking that enabled it. Then input tokens are consumed,
output tokens produced, and set arcs applied, in this order; so a set value stands. The object of the one object input goes to
each object output; setting an object place to 0 empties it. Math places that depend on what changed follow at once.

**Priority.** Of several enabled transitions of one kind the highest priority fires first, at a tie the first declared (in a
hierarchy: a net's own transitions before its modules', modules in order). The dissertation calls that order arbitrary: analysis
explores every order, and execution reports each choice it made in which one firing disabled another (`Executor.conflicts`).
``Semantics(choice="random")`` draws among equal priorities of immediate transitions by weight.

**Time** is counted in cycles. An immediate transition (delay 0) fires in the instant in which it is enabled. A timed transition
fires when it has been enabled for its delay: its clock starts at 0 when it becomes enabled, counts cycles, and is forgotten when
it is disabled (*enabling memory*), by any firing in between too, or by one that takes and returns a token it needs.
Options: ``memory="age"`` keeps the clock's value while disabled, ``memory="resampling"`` resets it at any firing,
``Semantics(persistence="atomic")`` looks only at the marking after each firing. One clock per transition runs whatever its
enabling degree (*single server*) and starts again after each firing; ``servers=k`` or ``INFINITE`` gives one per degree, the
youngest stopping first and, with age memory, the oldest going on first.

**One cycle**

1. observations set input places; after inference, belief places are set; object places with a selection receive their object;
2. math places are evaluated, each after those it reads. (When a selection reads math places, they are evaluated before it too.)
   A value that is not finite is an error naming the place, its expression and the operands;
3. immediate transitions fire until none is enabled. If that does not end, `LivelockError` names the circle of transitions;
4. clocks of the timed transitions that are enabled now start or go on;
5. timed transitions that are due fire, one at a time, each followed by immediate transitions until none is enabled. One that is
   disabled by an earlier firing of the same instant does not fire;
6. commands go out. Of two in one exclusive group the one of higher transition priority does, at a tie the first; the other is
   reported as overruled, or is an error in strict mode.

**Modules.** A module is a net with ports. Embedding it under an instance name gives its places the names ``instance.place``; only
ports may be touched from outside: entries only receive tokens, exits only lose them. Two instances share nothing. A hierarchy
means its flat net (`flatten`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...lazy import lazy_face

if TYPE_CHECKING:
    from .drawing.dot import save_drawing as save_drawing
    from .drawing.dot import to_dot as to_dot
    from .drawing.dot import to_svg as to_svg
    from .execution.commands import Commands as Commands
    from .execution.compiled_net import UNBOUNDED as UNBOUNDED
    from .execution.compiled_net import Arcs as Arcs
    from .execution.compiled_net import CompiledNet as CompiledNet
    from .execution.compiled_net import Memory as Memory
    from .execution.compiled_net import PlaceKind as PlaceKind
    from .execution.compiled_net import compile_net as compile_net
    from .execution.executor import Executor as Executor
    from .execution.state import Conflict as Conflict
    from .execution.state import Snapshot as Snapshot
    from .execution.tracing import Firing as Firing
    from .execution.tracing import Trace as Trace
    from .files.json import net_from_json as net_from_json
    from .files.json import net_to_json as net_to_json
    from .files.json import save_net as save_net
    from .files.load import load_net as load_net
    from .files.load import net_names as net_names
    from .files.pnml_reader import parse_pnml as parse_pnml
    from .files.pnml_reader import read_pnml as read_pnml
    from .files.pnml_writer import expanded_net as expanded_net
    from .files.pnml_writer import to_pnml as to_pnml
    from .files.pnml_writer import write_pnml as write_pnml
    from .net.modules import Instance as Instance
    from .net.modules import flatten as flatten
    from .net.modules import instances as instances
    from .net.net import PetriNet as PetriNet
    from .net.places import AnyPlace as AnyPlace
    from .net.places import Belief as Belief
    from .net.places import Continuous as Continuous
    from .net.places import Input as Input
    from .net.places import Math as Math
    from .net.places import ObjectPlace as ObjectPlace
    from .net.places import Place as Place
    from .net.places import Selection as Selection
    from .net.ports import Ports as Ports
    from .net.semantics import Semantics as Semantics
    from .net.set_arcs import eliminate_set_arcs as eliminate_set_arcs
    from .net.transitions import INFINITE as INFINITE
    from .net.transitions import Command as Command
    from .net.transitions import Transition as Transition
    from .net.values import FrozenMap as FrozenMap
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "drawing.dot": "save_drawing to_dot to_svg",
            "execution.commands": "Commands",
            "execution.compiled_net": "Arcs CompiledNet Memory PlaceKind UNBOUNDED compile_net",
            "execution.executor": "Executor",
            "execution.state": "Conflict Snapshot",
            "execution.tracing": "Firing Trace",
            "files.json": "net_from_json net_to_json save_net",
            "files.load": "load_net net_names",
            "files.pnml_reader": "parse_pnml read_pnml",
            "files.pnml_writer": "expanded_net to_pnml write_pnml",
            "net.modules": "Instance flatten instances",
            "net.net": "PetriNet",
            "net.places": "AnyPlace Belief Continuous Input Math ObjectPlace Place Selection",
            "net.ports": "Ports",
            "net.semantics": "Semantics",
            "net.set_arcs": "eliminate_set_arcs",
            "net.transitions": "Command INFINITE Transition",
            "net.values": "FrozenMap",
        },
    )
