"""Renaming a part of a model wherever its JSON form names it: parents, expressions, targets, tables, objects."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from ...architecture.prm.model import aggregates
from ...errors import CprmError, ModelError, unknown_name
from .net_parts import renamed_text

Form = dict[str, Any]
Rename = Callable[[str, str | None], str]
"""(text of a parent, class or None for an attribute of a relation) -> the text with the new name."""
KINDS = ("class", "attribute", "reference", "given", "relation", "role", "object")
PREVIOUS = "prev."


def rename(form: Form, what: str, name: str, to: str, owner: str = "") -> None:
    """Rename a class, attribute, reference, given, relation, role or object; `owner` is the class or relation that has it.

    Raises
    ------
    ModelError
        When it is not there.
    """
    if what not in KINDS:
        raise unknown_name("kind of part", str(what), KINDS)
    if not isinstance(to, str) or not to:
        raise ModelError(f"{what} {name!r}: the new name is text, got {to!r}")
    _Names(form).rename(what, name, to, owner)


class _Names:
    """What names mean in a form."""

    def __init__(self, form: Form) -> None:
        self.form = form
        self.classes: list[Form] = form["model"].get("classes", [])
        self.relations: list[Form] = form["model"].get("relations", [])
        self.by_name = {c["name"]: c for c in self.classes}

    def lineage(self, name: str) -> Iterator[Form]:
        """A class and those it inherits from."""
        seen: set[str] = set()
        while name in self.by_name and name not in seen:
            seen.add(name)
            yield self.by_name[name]
            name = self.by_name[name].get("extends", "")

    def family(self, owner: str, kind: str, name: str) -> set[str]:
        """The classes for which `name` is what it is for `owner`: those below the first in its lineage that has it."""
        having = [c["name"] for c in self.lineage(owner) if any(x["name"] == name for x in c.get(kind, []))]
        if not having:
            raise ModelError(f"class {owner!r} has no {name!r}")
        return {c["name"] for c in self.classes if any(a["name"] == having[-1] for a in self.lineage(c["name"]))}

    def rename(self, what: str, name: str, to: str, owner: str) -> None:
        objects: dict[str, str] = self.form.get("objects", {})
        if what == "class":
            self._named(self.classes, name, what)["name"] = to
            for c in self.classes:
                if c.get("extends") == name:
                    c["extends"] = to
                for reference in c.get("references", []):
                    reference["target"] = to if reference["target"] == name else reference["target"]
            for relation in self.relations:
                relation["roles"] = [[r, to if c == name else c] for r, c in relation["roles"]]
            self._objects({o: to if c == name else c for o, c in objects.items()})
        elif what == "relation":
            self._named(self.relations, name, what)["name"] = to
        elif what == "object":
            if name not in objects:
                raise ModelError(f"there is no object {name!r}")
            self._objects({to if o == name else o: c for o, c in objects.items()})
            references = self.form.get("references", {})
            moved = {o: {s: [to if t == name else t for t in targets] for s, targets in slots.items()} for o, slots in references.items()}
            if "references" in self.form:
                self.form["references"] = {to if o == name else o: slots for o, slots in moved.items()}
        elif what == "role":
            self._role(self._named(self.relations, owner, "relation"), name, to)
        elif owner in self.by_name:
            kind = {"attribute": "attributes", "reference": "references", "given": "given"}[what]
            family = self.family(owner, kind, name)
            self._everywhere(self._segment(family, name, to, last=what != "reference"))
            self._targets(family, name, to)
            if what == "reference":
                held = self.form.get("references", {})
                for o in held:
                    if objects.get(o) in family:
                        held[o] = {to if slot == name else slot: targets for slot, targets in held[o].items()}
            for c in self.classes:
                for part in c.get(kind, []) if c["name"] in family else []:
                    part["name"] = to if part["name"] == name else part["name"]
        else:
            relation = self._named(self.relations, owner, "relation")
            self._named(relation.get("attributes", []), name, what)["name"] = to
            for part in (*relation.get("changes", []), *relation.get("attributes", [])):
                _in_part(part, lambda text: to if text == name else text)

    @staticmethod
    def _named(parts: list[Form], name: str, what: str) -> Form:
        found = next((p for p in parts if p["name"] == name), None)
        if found is None:
            raise ModelError(f"there is no {what} {name!r}")
        return found

    def _objects(self, objects: dict[str, str]) -> None:
        if "objects" in self.form:
            self.form["objects"] = objects

    def _role(self, relation: Form, name: str, to: str) -> None:
        if name not in [r for r, _ in relation["roles"]]:
            raise ModelError(f"relation {relation['name']!r} has no role {name!r}")
        relation["roles"] = [[to if r == name else r, c] for r, c in relation["roles"]]

        def renamed(text: str) -> str:
            head = PREVIOUS if text.startswith(PREVIOUS) else ""
            first, dot, rest = text.removeprefix(head).partition(".")
            return head + (to if first == name and dot else first) + dot + rest

        for part in (*relation.get("changes", []), *relation.get("attributes", [])):
            _in_part(part, renamed)
        for change in relation.get("changes", []):
            change["target"] = renamed(change["target"])
        if "keep_joint" in relation:
            relation["keep_joint"] = [[renamed(t) for t in group] for group in relation["keep_joint"]]

    def _segment(self, family: set[str], name: str, to: str, last: bool) -> Rename:
        """Renames one step of a slot chain where it starts from a class of the family."""

        def renamed(text: str, start: str | None) -> str:
            head = PREVIOUS if text.startswith(PREVIOUS) else ""
            steps = text.removeprefix(head).split(".")
            at = start
            for k, step in enumerate(steps):
                if at is None:
                    break
                end = k == len(steps) - 1
                if at in family and step == name and end == last:
                    steps[k] = to
                slots = [r for c in self.lineage(at) for r in c.get("references", []) if r["name"] == step]
                at = slots[0]["target"] if slots else None
            return head + ".".join(steps)

        return renamed

    def _everywhere(self, renamed: Rename) -> None:
        for c in self.classes:
            for attribute in c.get("attributes", []):
                _in_part(attribute, lambda text, owner=c["name"]: renamed(text, owner))  # type: ignore[misc]
        for relation in self.relations:
            roles = dict(relation["roles"])

            def in_role(text: str, roles: dict[str, str] = roles) -> str:
                head = PREVIOUS if text.startswith(PREVIOUS) else ""
                role, dot, rest = text.removeprefix(head).partition(".")
                return head + role + dot + renamed(rest, roles[role]) if dot and role in roles else text

            for part in (*relation.get("changes", []), *relation.get("attributes", [])):
                _in_part(part, in_role)

    def _targets(self, family: set[str], name: str, to: str) -> None:
        for relation in self.relations:
            roles = dict(relation["roles"])

            def renamed(text: str, roles: dict[str, str] = roles) -> str:
                role, _, attribute = text.partition(".")
                return f"{role}.{to}" if attribute == name and roles.get(role) in family else text

            for change in relation.get("changes", []):
                change["target"] = renamed(change["target"])
            if "keep_joint" in relation:
                relation["keep_joint"] = [[renamed(t) for t in group] for group in relation["keep_joint"]]


def _in_part(part: Form, renamed: Callable[[str], str]) -> None:
    """Rename in the parents and CPDs of an attribute or change."""
    names: dict[str, str] = {}
    for field in ("parents", "initial_parents"):
        changed: list[Any] = []
        for parent in part.get(field, []):
            if isinstance(parent, str):
                names[parent] = renamed(parent)
                changed.append(names[parent])
            else:
                before = _text(parent)
                made = {**parent, "path": renamed(parent["path"])}
                names[before] = _text(made)
                changed.append(made)
        if field in part:
            part[field] = changed
    for field in ("cpd", "initial"):
        if field in part:
            _in_cpd(part[field], lambda text: names.get(text, text))


def _text(aggregate: Form) -> str:
    """How an aggregate is called in expressions."""
    fields = {key: value for key, value in aggregate.items() if key != "is"}
    try:
        made: aggregates.Aggregate = getattr(aggregates, str(aggregate.get("is")))(**fields)
        return made.text
    except (AttributeError, TypeError, ValueError, CprmError):
        return str(aggregate.get("path"))


def _usual_state(aggregate: Form) -> str | None:
    """The state that an aggregate looks for when it does not say which."""
    usual = getattr(getattr(aggregates, str(aggregate.get("is")), None), "state", None)
    return usual if isinstance(usual, str) else None


def _in_cpd(cpd: Form, renamed: Callable[[str], str]) -> None:
    for field in ("mean", "sd", "p"):
        if isinstance(cpd.get(field), str):
            cpd[field] = renamed_text(cpd[field], renamed)
    if "parent" in cpd:
        cpd["parent"] = renamed(cpd["parent"])
    for pair in (*cpd.get("cases", []), *cpd.get("parts", [])):
        _in_cpd(pair[1], renamed)


def rename_state(form: Form, owner: str, attribute: str, name: str, to: str) -> None:
    """Rename a state of an attribute (or given) of a class, in tables of its own and of those that have it as a parent.

    Raises
    ------
    ModelError
        When the attribute has no such state.
    """
    names = _Names(form)
    family: set[str] = set()
    for kind in ("attributes", "given"):
        if any(x["name"] == attribute for c in names.lineage(owner) for x in c.get(kind, [])):
            family = names.family(owner, kind, attribute)
            for c in names.classes:
                for part in c.get(kind, []) if c["name"] in family else []:
                    if part["name"] == attribute:
                        _in_domain(part, name, to, owner, attribute)
    if not family:
        raise ModelError(f"class {owner!r} has no attribute {attribute!r}")
    probe = names._segment(family, attribute, "\0", last=True)
    for c in names.classes:
        for part in c.get("attributes", []):
            _in_states(part, lambda text, start=c["name"]: probe(text, start).endswith("\0"), name, to)  # type: ignore[misc]
    for relation in names.relations:
        roles = dict(relation["roles"])

        def reaches(text: str, roles: dict[str, str] = roles) -> bool:
            role, dot, rest = text.removeprefix(PREVIOUS).partition(".")
            return bool(dot) and role in roles and probe(rest, roles[role]).endswith("\0")

        for part in (*relation.get("changes", []), *relation.get("attributes", [])):
            _in_states(part, reaches, name, to)


def _in_domain(part: Form, name: str, to: str, owner: str, attribute: str) -> None:
    states = part["domain"].get("names")
    if not states or name not in states:
        raise ModelError(f"attribute {owner}.{attribute} has no named state {name!r}")
    part["domain"]["names"] = [to if s == name else s for s in states]
    if part.get("default") == name:
        part["default"] = to


def _in_states(part: Form, reaches: Callable[[str], bool], name: str, to: str) -> None:
    """Rename a state in the tables, switches and aggregates of a part, where a parent is the attribute."""
    for field, parents in (("cpd", part.get("parents", [])), ("initial", part.get("initial_parents", []))):
        for parent in parents:
            if isinstance(parent, dict) and reaches(parent["path"]) and parent.get("state", _usual_state(parent)) == name:
                parent["state"] = to
        hits = [k for k, parent in enumerate(parents) if isinstance(parent, str) and reaches(parent)]
        texts = [p if isinstance(p, str) else _text(p) for p in parents]
        if field in part and hits:
            _state_in_cpd(part[field], texts, {texts[k] for k in hits}, name, to)


def _state_in_cpd(cpd: Form, parents: list[str], hits: set[str], name: str, to: str) -> None:
    if "rows" in cpd:
        cpd["rows"] = [
            [[to if s == name and parents[k : k + 1] and parents[k] in hits else s for k, s in enumerate(key)], row]
            for key, row in cpd["rows"]
        ]
    rest = parents
    if "cases" in cpd:
        rest = [p for p in parents if p != cpd["parent"]]
        if cpd["parent"] in hits:
            cpd["cases"] = [[to if s == name else s, inner] for s, inner in cpd["cases"]]
    for pair in (*cpd.get("cases", []), *cpd.get("parts", [])):
        _state_in_cpd(pair[1], rest, hits, name, to)
