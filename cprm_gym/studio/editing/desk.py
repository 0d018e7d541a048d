"""The desk: documents that are open, and what a page can ask about them (room ``edit``)."""

from __future__ import annotations

import contextlib
import re
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...agents.catalogue import shipped_net, shipped_nets
from ...architecture.petri import PetriNet
from ...architecture.petri.drawing.plan import drawing_plan
from ...architecture.petri.files.json import FORMAT as NET_FORMAT
from ...architecture.petri.files.json import net_from_dict
from ...architecture.prm import Model
from ...architecture.prm.interchange.json import FORMAT as MODEL_FORMAT
from ...errors import CprmError, FormatError, ParameterError, unknown_name
from .checks import SECONDS, Checker
from .document import Document, Value, form_of
from .expressions import check_expression
from .files import FORMS, FileChanged, Files, content
from .named import is_named, named_value

Publish = Callable[..., None]
NEW = "new:"
BESIDE = 160.0
"""Pixels between what is seen and the quantities that are not."""
DEFAULT_KINDS: Mapping[str, dict[str, Any]] = {
    "net": {"format": NET_FORMAT, "version": 1, "net": "net", "definitions": {"net": {"places": [], "transitions": []}}},
    "model": {"format": MODEL_FORMAT, "version": 1, "model": {"is": "Model", "name": "model"}, "objects": {}, "references": {}},
}


@dataclass
class Open:
    """A document that is open.

    Attributes
    ----------
    document : Document
    source : str
        Path from the root, ``package.module:NAME``, or ``new:`` and a name.
    path : Path or None
        Where it is saved.
    stamp : str
        Of the file's content when it was read or written last.
    saved : int
        Revision that the file holds, -1 for none.
    told : str
        What there is to say about how it was opened.
    """

    document: Document
    source: str
    path: Path | None = None
    stamp: str = ""
    saved: int = -1
    told: str = ""


class Desk:
    """What is being edited.

    Parameters
    ----------
    publish : callable
        Tells all pages of an event: (name, content).
    root : path
        Folder whose files may be opened.
    drafts : path, optional
        Folder of drafts.
    seconds : float
        What one check may take.
    """

    def __init__(self, publish: Publish, root: Path, drafts: Path | None = None, seconds: float = SECONDS) -> None:
        self.publish = publish
        self.files = Files(root, drafts)
        self._open: dict[str, Open] = {}
        self._count = 0
        self._lock = threading.RLock()
        self._first: Callable[[], object] | None = None
        self._checker = Checker(self._checked, seconds)
        for source in self.files.unnamed_drafts():
            held = self.files.draft(source)
            if held is not None:
                made = self._put(Document(source.removeprefix(NEW), held[0]), source)
                self._open[made].told = "not saved yet; kept from before"

    def close(self) -> None:
        """End what runs in the background."""
        self._checker.close()

    def calls(self) -> dict[str, Callable[..., Any]]:
        """What a page can call."""
        names = (
            "list browse logs shipped open new ship read view apply undo redo expression save discard export check take_file take_shipped"
        )
        return {name: getattr(self, name) for name in names.split()} | {"close": self.close_document}

    # -- opening --------------------------------------------------------------------------------------------------------------------

    def open_named(self, named: str) -> str:
        """Open what the command line names: a file, also outside the folder, or ``package.module:NAME``.

        Raises
        ------
        CprmError
            When there is no net, model or CPRM.
        """
        if is_named(named):
            return self.add(named.partition(":")[2].lower(), named_value(named), named)
        self.files.allow(named)
        return str(self.open(str(Path(named).resolve()))["id"])

    def begin_with(self, opening: Callable[[], object]) -> None:
        """Open something when a page first asks what is open: it may take time to make."""
        self._first = opening

    def add(self, name: str, value: Value, source: str) -> str:
        """Open a value that is no file yet; a draft from before takes its place."""
        with self._lock:
            document = Document(name, form_of(value))
            key = self._put(document, source)
            self._restore(self._open[key])
            return key

    def _put(self, document: Document, source: str) -> str:
        for key, held in self._open.items():
            if held.source == source:
                return key
        self._count += 1
        key = f"d{self._count}"
        self._open[key] = Open(document, source)
        self._ask_checks(key)
        return key

    def _restore(self, held: Open) -> None:
        """Take up a draft from before."""
        draft = self.files.draft(held.source)
        if draft is None or draft[0] == held.document.data:
            return
        data, stamp = draft
        held.document.put(data, "the draft from before")
        held.told = "changes that were not saved are kept from before"
        if stamp != held.stamp:
            held.told += "; the file was changed since"
            held.stamp = stamp

    def open(self, path: str, net: str | None = None) -> dict[str, Any]:
        """Open a file of the folder."""
        with self._lock:
            found = self.files.inside(path)
            source = self.files.shown(found)
            for key, held in self._open.items():
                if held.source == source:
                    return self.read(key)
            form, stamp = self.files.read(found, net)
            key = self._put(Document(found.name, form), source)
            held = self._open[key]
            held.path, held.stamp, held.saved = found, stamp, held.document.revision
            self._restore(held)
            return self.read(key)

    def new(self, kind: str, name: str) -> dict[str, Any]:
        """A new, empty net or model."""
        if kind not in DEFAULT_KINDS:
            raise unknown_name("kind of document", kind, DEFAULT_KINDS)
        with self._lock:
            form = dict(DEFAULT_KINDS[kind])
            if kind == "net":
                form |= {"net": name, "definitions": {name: {"places": [], "transitions": []}}}
                net_from_dict(form)
            else:
                form["model"] = {"is": "Model", "name": name}
            return self._new(Document(name, form))

    def _new(self, document: Document) -> dict[str, Any]:
        taken = {held.source for held in self._open.values()}
        source, number = NEW + document.name, 1
        while source in taken:
            number += 1
            source = f"{NEW}{document.name}-{number}"
        document.name = source.removeprefix(NEW)
        key = self._put(document, source)
        self.files.keep_draft(source, document, "")
        return self.read(key)

    def shipped(self) -> list[str]:
        """Names of the nets that come with the package."""
        return list(shipped_nets())

    def ship(self, name: str) -> dict[str, Any]:
        """A copy of a net that comes with the package, to be changed and saved under a name of its own."""
        with self._lock:
            return self._new(Document(name, form_of(shipped_net(name))))

    def take_file(self, id: str, path: str) -> dict[str, Any]:
        """Bring the definitions of another net's file into a document, to be embedded."""
        form, _ = self.files.read(self.files.inside(path))
        return self._take(id, form)

    def _take(self, id: str, form: dict[str, Any]) -> dict[str, Any]:
        net = Document("other", form).net
        if net is None:
            raise FormatError("there is no net in it")
        return self.apply(id, {"op": "take", "definitions": net["definitions"], "layout": net.get("layout", {})})

    def take_shipped(self, id: str, name: str, embed: dict[str, Any]) -> dict[str, Any]:
        """Bring a net that comes with the package into a document, and embed it, as one operation."""
        net = shipped_net(name)
        form = form_of(net)
        known = (self._held(id).document.net or {"definitions": {}})["definitions"]
        number, key = 1, name
        while key in known and known[key] != form["definitions"][name]:  # as the operation `take` names it
            number += 1
            key = f"{name}_{number}"
        ops = [{"op": "take", "definitions": form["definitions"]}, {**embed, "definition": key}]
        return self.apply(id, {"op": "all", "ops": ops, "what": f"embed {name}"})

    def list(self) -> dict[str, Any]:
        """What is open, in short."""
        with self._lock:
            opening, self._first = self._first, None
            if opening is not None:
                opening()
            return {"open": [self._short(key) for key in self._open], "root": str(self.files.root)}

    def browse(self) -> list[str]:  # type: ignore[valid-type]
        """Files that can be opened."""
        return self.files.listing()

    def logs(self) -> list[str]:  # type: ignore[valid-type]
        """Files that may be logs of readings."""
        return self.files.listing((".csv", ".json"))

    def close_document(self, id: str) -> dict[str, Any]:
        """Close a document; what was not saved is lost."""
        with self._lock:
            held = self._held(id)
            self.files.forget_draft(held.source)
            del self._open[id]
            return self.list()

    # -- reading --------------------------------------------------------------------------------------------------------------------

    def _held(self, id: str) -> Open:
        held = self._open.get(id)
        if held is None:
            raise unknown_name("document", str(id), self._open)
        return held

    def document(self, id: str) -> Document:
        """A document that is open."""
        with self._lock:
            return self._held(id).document

    def _short(self, id: str) -> dict[str, Any]:
        held = self._open[id]
        document = held.document
        return {"id": id, "name": document.name, "kind": document.kind, "source": held.source, "revision": document.revision,
                "saved": held.saved == document.revision, "path": self.files.shown(held.path) if held.path else "",
                "net": document.net is not None, "model": document.model is not None}  # fmt: skip

    def read(self, id: str) -> dict[str, Any]:
        """A document with its content."""
        with self._lock:
            held = self._held(id)
            document = held.document
            told, held.told = held.told, ""
            return {**self._short(id), "data": document.data, "history": document.history, "told": told,
                    "problem": "" if document.kind == "net" else document.problem()}  # fmt: skip

    def view(self, id: str, definition: str, unfold: Sequence[str] = (), quantities: bool = True) -> dict[str, Any]:
        """The drawing of one definition.

        Parameters
        ----------
        id, definition : str
        unfold : list of str
            Paths of the instances that are shown with their inside.
        quantities : bool
            Inputs, beliefs, math and continuous places, too.
        """
        with self._lock:
            document = self._held(id).document
            net = document.definition(definition)
            positions = document.positions
        return drawing_plan(net, frozenset(unfold), positions, all_ports=True, quantities=quantities)

    def expression(self, id: str, definition: str, text: str, candidate: str = "") -> dict[str, Any]:
        """Whether an expression can stand in a definition, while it is being typed."""
        net = self._held(id).document.net
        if net is None:
            raise FormatError(f"document {id} has no net")
        return check_expression(net, definition, text, candidate)

    # -- changing -------------------------------------------------------------------------------------------------------------------

    def apply(self, id: str, op: dict[str, Any], part: str = "net", revision: int | None = None, quantities: bool = True) -> dict[str, Any]:
        """Do an operation (`net_operations`, `model_operations`).

        Parameters
        ----------
        id : str
        op : dict
        part : {"net", "model"}
        revision : int, optional
            The one that the page has seen; a document that was changed since is not changed.
        quantities : bool
            Whether the page shows quantities: what is put by hand stands among what is shown.

        Raises
        ------
        CprmError
            When it does not fit; the document is as before.
        """
        with self._lock:
            held = self._held(id)
            if revision is not None and revision != held.document.revision:
                raise ParameterError("the document was changed on another page meanwhile; its newest state is shown now")
            if part == "net" and op.get("op") in ("move", "add_place", "add_transition", "embed", "all"):
                self._fix_positions(held.document, op, quantities)
            held.document.apply(op, part)
            return self._after(id, str(op.get("in", "")))

    def _fix_positions(self, document: Document, op: Mapping[str, Any], quantities: bool) -> None:
        """When something is put by hand, everything else of its definition stays where the automatic layout had put it."""
        ops = op.get("ops", []) if op.get("op") == "all" else [op]
        if document.net is None:
            return
        for one in ops:
            key = one.get("in") if isinstance(one, Mapping) else None
            known = document.net["definitions"]
            if not isinstance(key, str) or key not in known or not one.get("at") or document.positions.get(key):
                continue
            at = _standing(document.definition(key), True)
            if not quantities:  # the quantities, which are not seen, stand beside
                shown = _standing(document.definition(key), False)
                right = max((x for x, _ in shown.values()), default=0.0)
                at = {name: (x + right + BESIDE, y) for name, (x, y) in at.items()} | shown
            if at:
                document.freeze(key, at)

    def undo(self, id: str) -> dict[str, Any]:
        """Take back the last operation."""
        with self._lock:
            self._held(id).document.undo()
            return self._after(id)

    def redo(self, id: str) -> dict[str, Any]:
        """Do again what was taken back."""
        with self._lock:
            self._held(id).document.redo()
            return self._after(id)

    def replace(self, id: str, value: Value, what: str) -> dict[str, Any]:
        """Take another value as the content, one operation that can be undone."""
        with self._lock:
            document = self._held(id).document
            document.put(form_of(value), what)
            return self._after(id)

    def _after(self, id: str, changed: str = "") -> dict[str, Any]:
        held = self._held(id)
        self.files.keep_draft(held.source, held.document, held.stamp)
        self._ask_checks(id, changed)
        self.publish("edit.changed", {"id": id, "revision": held.document.revision})
        return self.read(id)

    # -- files ----------------------------------------------------------------------------------------------------------------------

    def save(self, id: str, path: str = "", force: bool = False) -> dict[str, Any]:
        """Write a document to its file, or to another.

        Returns
        -------
        dict
            As `read`; with ``conflict``, what happened to the file meanwhile, when nothing was written.
        """
        with self._lock:
            held = self._held(id)
            target = self.files.inside(path) if path else held.path
            if target is None:
                raise FormatError("give the file a name, with .json or .pnml at its end")
            stamp = held.stamp if target == held.path else ""
            try:
                stamp = self.files.write(target, held.document, stamp, force)
            except FileChanged as error:
                return {**self.read(id), "conflict": str(error)}
            if target.suffix == ".py":  # an export: the document stays that of its own file
                return {**self.read(id), "written": self.files.shown(target)}
            self.files.forget_draft(held.source)
            held.path, held.stamp, held.saved = target, stamp, held.document.revision
            held.source, held.document.name = self.files.shown(target), target.name
            self.publish("edit.changed", {"id": id, "revision": held.document.revision})
            return {**self.read(id), "written": self.files.shown(target)}

    def discard(self, id: str) -> dict[str, Any]:
        """Go back to what the file holds; this can be undone."""
        with self._lock:
            held = self._held(id)
            if held.path is None:
                raise FormatError(f"{held.document.name} was never saved")
            form, stamp = self.files.read(held.path)
            held.document.put(form, "back to the file")
            held.stamp, held.saved = stamp, held.document.revision
            made = self._after(id)
            self.files.forget_draft(held.source)
            return made

    def export(self, id: str, form: str) -> dict[str, str]:
        """The text of a document as JSON, PNML or Python, with a name for its file."""
        if form not in FORMS:
            raise unknown_name("form", form, FORMS)
        document = self._held(id).document
        stem = re.sub(r"\W+", "_", document.name.partition(".")[0], flags=re.ASCII).strip("_") or "net"
        return {"name": stem + {"json": ".json", "pnml": ".pnml", "python": ".py"}[form], "text": content(document, form)}

    # -- checks ---------------------------------------------------------------------------------------------------------------------

    def _ask_checks(self, id: str, first: str = "") -> None:
        document = self._held(id).document
        if document.net is None:
            return
        try:
            outermost_first = list(document.definitions().items())[::-1]
        except CprmError:
            return
        self._checker.ask(id, document.revision, dict(sorted(outermost_first, key=lambda item: item[0] != first)))

    def check(self, id: str, first: str = "") -> dict[str, Any]:
        """Check a document's nets again, one of them before the others; answers come as events ``edit.checked``."""
        with self._lock:
            self._ask_checks(id, first)
            return {"asked": True}

    def _checked(self, id: str, revision: int, definition: str, findings: Any) -> None:
        self.publish("edit.checked", {"id": id, "revision": revision, "definition": definition, "findings": findings})

    def nets(self) -> dict[str, PetriNet]:
        """The valid nets that are open, by the name of their document and, where it has several, definition."""
        found: dict[str, PetriNet] = {}
        with self._lock:
            for held in self._open.values():
                if held.document.net is not None:
                    net = held.document.definition()
                    found[net.name] = net
        return found

    def models(self) -> dict[str, Model]:
        """The valid models that are open, by name; one that is unfinished is left out."""
        found: dict[str, Model] = {}
        with self._lock:
            for held in self._open.values():
                if held.document.model is not None:
                    with contextlib.suppress(CprmError):
                        model = held.document.model_value()
                        found[model.name] = model
        return found


def _standing(net: PetriNet, quantities: bool) -> dict[str, tuple[float, float]]:
    """Where the automatic layout puts a net's own parts."""
    plan = drawing_plan(net, 0, all_ports=True, quantities=quantities)
    boxes = {box["key"]: (box["x"], box["y"]) for box in plan["boxes"]}
    return {n["key"]: (n["x"], n["y"]) for n in plan["nodes"] if n["key"].partition(".")[0] not in boxes} | boxes
