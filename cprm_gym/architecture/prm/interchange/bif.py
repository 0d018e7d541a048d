"""Flat nets in the Bayesian Interchange Format: written exactly, read from any program that writes it.

Read are the format's version 0.15 too (JavaBayes: names in quotation marks, the child first, no ``|`` and no commas), and states of any
letters, ``<7.5`` and ``>=7.5``. A file's tables have at most `MAX_FILE_CELLS` cells together.

Names that other programs would not take (``ball.dist#1``, ``2..5``) are replaced by plain ones, and kept in properties, so that a
net read back is the one that was written: names, states, bins, and tables to the last bit. A slice with parents in the previous
one is unrolled first (`grounding.unroll`).

References
----------
Cozman, "The Interchange Format for Bayesian Networks", 1998.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from ....errors import FormatError, ModelError, did_you_mean
from ....files import write_atomically
from ..grounding.grounding import SAME, GroundCPD, GroundSlice, GroundVariable
from .json import read_text

ROUNDING = 1e-2
"""How far a row of a foreign file may be from summing to 1; it is normalised. Rows within 1e-9 are left as they are."""

MAX_FILE_CELLS = 5_000_000
"""Most cells that all tables of a file may have together, 40 MB; ``default`` and few words can ask for any number."""

MAX_PARENTS = 30
"""A table has fewer axes than arrays may have."""

_PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
_TOKEN = re.compile(r'//[^\n]*|/\*.*?(?:\*/|\Z)|"(?:[^"\\]|\\.)*(?:"|\Z)|[{}()\[\]|,;]|[^\s{}()\[\]|,;"]+', re.DOTALL)
_PROPERTY = re.compile(r'([^\s="]+)\s*=\s*("(?:[^"\\]|\\.)*")\Z', re.DOTALL)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?\Z", re.ASCII)
_WORDS = ("network", "variable", "probability", "property", "type", "discrete", "table", "default")


class Token(NamedTuple):
    """A word of a file and the line it is on."""

    text: str
    line: int


def to_bif(ground: GroundSlice, name: str = "net") -> str:
    """A static net as BIF text.

    Parameters
    ----------
    ground : GroundSlice
        Without lags. What is given becomes a root with a uniform distribution and a property that says so.
    name : str
        Of the network.

    Raises
    ------
    ModelError
        If a parent is in another slice.
    """
    need_static(ground, "BIF")
    labels = dict(zip(ground.variables, plain_names(ground.variables)))
    states = {n: plain_names(v.states) for n, v in ground.variables.items()}
    out = [f"network {plain_names([name])[0]} {{", "}"]
    for n, v in ground.variables.items():
        out.append(f"variable {labels[n]} {{")
        out.append(f"  type discrete [ {v.card} ] {{ {', '.join(states[n])} }};")
        out += [f"  property {key} = {json.dumps(value)} ;" for key, value in _properties(v, n in ground.given).items()]
        out.append("}")
    for n in ground.order():
        v = ground.variables[n]
        if n in ground.given:
            out += [f"probability ( {labels[n]} ) {{", f"  table {', '.join([repr(1.0 / v.card)] * v.card)};", "}"]
            continue
        cpd = ground.by_child[n]
        parents = [p for p, _ in cpd.parents]
        given = f" | {', '.join(labels[p] for p in parents)}" if parents else ""
        out.append(f"probability ( {labels[n]}{given} ) {{")
        for index in np.ndindex(cpd.table.shape[:-1]):
            row = ", ".join(repr(float(x)) for x in cpd.table[index])
            head = ", ".join(states[p][k] for p, k in zip(parents, index))
            out.append(f"  ({head}) {row};" if parents else f"  table {row};")
        out.append("}")
    return "\n".join(out) + "\n"


def from_bif(text: str, where: str = "BIF") -> GroundSlice:
    """The net that a BIF text holds.

    Parameters
    ----------
    text : str
    where : str
        Named in errors.

    Raises
    ------
    FormatError
        If the text is not BIF, names something unknown, or misses a row; the message says the line.
    """
    try:
        return _Reader(text, where).read()
    except ModelError as error:
        raise FormatError(f"{where}: {error}") from None


def save_bif(ground: GroundSlice, path: str | os.PathLike[str], name: str = "net") -> None:
    """Write a static net to a file, all or nothing."""
    write_atomically(path, to_bif(ground, name))


def load_bif(path: str | os.PathLike[str]) -> GroundSlice:
    """Read a net from a file, or a `FormatError` that names the file and the line."""
    return from_bif(read_text(path), str(path))


def need_static(ground: GroundSlice, what: str) -> None:
    """Refuse a slice with parents in another slice.

    Raises
    ------
    ModelError
    """
    for cpd in ground.cpds:
        if cpd.density is not None:
            raise ModelError(f"{what} has states only: {cpd.child!r} is or depends on a real number; take `Model.binned`")
        for parent, lag in cpd.parents:
            if lag != SAME:
                raise ModelError(f"{what} has no time: {cpd.child!r} has the parent {parent!r} in another slice; unroll the slices first")


def plain_names(names: Iterable[str]) -> list[str]:
    """Distinct identifiers of letters, digits and ``_`` for some names; plain names stay as they are."""
    wanted = list(names)
    taken = {n for n in wanted if _PLAIN.match(n)}
    out = []
    for n in wanted:
        if not _PLAIN.match(n):
            base = re.sub(r"[^A-Za-z0-9_]+", "_", n).strip("_") or "x"
            base = base if base[0].isalpha() else f"s{base}"
            n = base
            k = 2
            while n in taken:
                n = f"{base}_{k}"
                k += 1
            taken.add(n)
        out.append(n)
    return out


def _properties(v: GroundVariable, is_given: bool) -> dict[str, Any]:
    """What a variable is beyond its plain name and states."""
    every: dict[str, Any] = {
        "cprm_name": v.name,
        "cprm_states": "" if plain_names(v.states) == list(v.states) else "|".join(_escaped(s) for s in v.states),
        "cprm_edges": "" if v.edges is None else " ".join(repr(float(e)) for e in v.edges),
        "cprm_circular": "yes" if v.circular else "",
        "cprm_clip": "yes" if v.clip else "",
        "cprm_unit": v.unit,
        "cprm_class": v.class_name,
        "cprm_object": v.object_name,
        "cprm_attribute": v.attribute,
        "cprm_given": "yes" if is_given else "",
        "cprm_auxiliary": "yes" if v.auxiliary else "",
    }
    if _PLAIN.match(v.name):
        del every["cprm_name"]
    return {key: value for key, value in every.items() if value}


def _escaped(state: str) -> str:
    return state.replace("%", "%25").replace("|", "%7C")


def _unescaped(text: str) -> str:
    return text.replace("%7C", "|").replace("%25", "%")


def _closed(text: str) -> bool:
    """A text in quotation marks ends with one that is not escaped."""
    body = text[1:-1]
    return len(text) > 1 and text[-1] == '"' and (len(body) - len(body.rstrip("\\"))) % 2 == 0


class _Reader:
    """Reads one text, once."""

    def __init__(self, text: str, where: str) -> None:
        self.where = where
        self.tokens: list[Token] = []
        line = 1
        end = 0
        for match in _TOKEN.finditer(text):
            line += text.count("\n", end, match.start())
            word = match.group()
            if (word.startswith("/*") and not (len(word) > 3 and word.endswith("*/"))) or (word[0] == '"' and not _closed(word)):
                raise FormatError(f"{where}, line {line}: {'a comment' if word[0] == '/' else 'a text'} is not closed")
            if not word.startswith(("//", "/*")):
                self.tokens.append(Token(word, line))
            line += word.count("\n")
            end = match.end()
        self.at = 0
        self.cells = 0
        self.has_default = False
        self.states: dict[str, dict[str, int]] = {}
        self.properties: dict[str, dict[str, str]] = {}
        self.tables: dict[str, tuple[list[str], np.ndarray]] = {}

    def fail(self, message: str) -> FormatError:
        line = self.tokens[max(self.at - 1, 0)].line if self.tokens else 1
        return FormatError(f"{self.where}, line {line}: {message}")

    def next(self, wanted: str = "") -> str:
        """The next word; with `wanted`, it must be that one."""
        if self.at >= len(self.tokens):
            raise self.fail(f"the text ends where {wanted or 'more'} is expected")
        word = self.tokens[self.at].text
        self.at += 1
        if wanted and word != wanted:
            raise self.fail(f"{wanted!r} expected, got {word!r}")
        return word.strip('"') if word.startswith('"') else word

    def peek(self) -> str:
        return self.tokens[self.at].text if self.at < len(self.tokens) else ""

    def read(self) -> GroundSlice:
        while self.at < len(self.tokens):
            word = self.next()
            if word == "network":
                while self.next() != "{":
                    pass
                while self.peek() != "}":
                    self.property({})
                self.next("}")
            elif word == "variable":
                self.variable()
            elif word == "probability":
                self.probability()
            else:
                raise self.fail(f"'network', 'variable' or 'probability' expected, got {word!r}.{did_you_mean(word, _WORDS)}")
        for name in self.states:
            if name not in self.tables:
                raise FormatError(f"{self.where}: variable {name!r} has no probability")
        return self.net()

    def property(self, into: dict[str, str]) -> None:
        self.next("property")
        words = []
        while self.peek() not in (";", ""):
            words.append(self.tokens[self.at].text)
            self.at += 1
        self.next(";")
        given = _PROPERTY.match(" ".join(words))
        if given is not None:
            try:
                into[given.group(1)] = str(json.loads(given.group(2), strict=False))
            except ValueError:
                raise self.fail(f"property {given.group(1)!r} is not a text: {given.group(2)[:80]}") from None

    def variable(self) -> None:
        name = self.next()
        if name in self.states:
            raise self.fail(f"variable {name!r} is defined twice")
        found: dict[str, str] = {}
        self.next("{")
        while self.peek() != "}":
            if self.peek() == "property":
                self.property(found)
                continue
            self.next("type")
            if name in self.states:
                raise self.fail(f"variable {name!r} has two types")
            self.next("discrete")
            self.next("[")
            size = self.next()
            self.next("]")
            self.next("{")
            states = self.list_until("}")
            self.next(";")
            if size != str(len(states)):
                raise self.fail(f"variable {name!r} has {len(states)} states, announced are {size}")
            if len(set(states)) != len(states):
                raise self.fail(f"variable {name!r} has two states of one name: {', '.join(states)}")
            if not states:
                raise self.fail(f"variable {name!r} has no states")
            self.states[name] = {state: k for k, state in enumerate(states)}
        self.next("}")
        if name not in self.states:
            raise self.fail(f"variable {name!r} has no type")
        self.properties[name] = found

    def list_until(self, end: str) -> list[str]:
        words: list[str] = []
        while self.peek() != end:
            mark = self.peek()
            word = self.next()
            if mark != ",":
                words.append(word)
        self.next(end)
        return words

    def known(self, name: str) -> str:
        if name not in self.states:
            raise self.fail(f"unknown variable {name!r}.{did_you_mean(name, self.states)}")
        return name

    def numbers(self, count: int, what: str) -> np.ndarray:
        words = self.list_until(";")
        wrong = [w for w in words if not _NUMBER.match(w)]
        if wrong:
            raise self.fail(f"{what}: numbers expected, got {' '.join(wrong[:5])[:80]}")
        values = np.array([float(w) for w in words])
        if len(values) != count:
            raise self.fail(f"{what}: {len(values)} numbers for {count}")
        return values

    def row(self, values: np.ndarray, what: str) -> np.ndarray:
        total = float(values.sum())
        if not np.isfinite(values).all() or (values < 0.0).any() or abs(total - 1.0) > ROUNDING:
            raise self.fail(f"{what} is not a distribution: {values[:20].tolist()}{' ...' if len(values) > 20 else ''}")
        return values if abs(total - 1.0) <= 1e-9 else values / total

    def probability(self) -> None:
        self.next("(")
        child = self.known(self.next())
        if child in self.tables:
            raise self.fail(f"{child!r} has two probabilities")
        if self.peek() in ("|", ","):  # format 0.15 has neither: the first name is the child
            self.next()
        parents = [self.known(p) for p in self.list_until(")")]
        if len({child, *parents}) != 1 + len(parents):
            raise self.fail(f"a variable stands twice in the probability of {child!r}")
        card = len(self.states[child])
        shape = tuple(len(self.states[p]) for p in parents)
        self.cells += math.prod((*shape, card))
        if self.cells > MAX_FILE_CELLS or len(shape) >= MAX_PARENTS:
            raise self.fail(f"with the table of {child!r} the file has more than {MAX_FILE_CELLS} cells, or it has {MAX_PARENTS} parents")
        table = np.full((*shape, card), np.nan)
        self.next("{")
        self.has_default = False
        while self.peek() != "}":
            self.entry(child, parents, table)
        self.next("}")
        missing = np.isnan(table[..., 0])
        if missing.any():
            gap = np.unravel_index(int(np.argmax(missing)), shape)
            names = tuple([*self.states[p]][int(k)] for p, k in zip(parents, gap))
            raise self.fail(f"probability of {child!r} has no row for {names}")
        self.tables[child] = parents, table

    def entry(self, child: str, parents: list[str], table: np.ndarray) -> None:
        """One line of a probability block."""
        card, shape = table.shape[-1], table.shape[:-1]
        what = f"probability of {child!r}"
        word = self.peek()
        if word == "property":
            self.property({})
        elif word == "table":
            self.next()
            values = self.numbers(table.size, what).reshape(card, *shape)
            table[...] = np.moveaxis(values, 0, -1)
            for index in np.ndindex(*shape):
                table[index] = self.row(table[index], what)
        elif word == "default":
            self.next()
            if self.has_default:
                raise self.fail(f"{what} has two defaults")
            self.has_default = True
            values = self.row(self.numbers(card, what), what)
            table[...] = np.where(np.isnan(table), values, table)
        else:
            self.next("(")
            given = self.list_until(")")
            if len(given) != len(parents):
                raise self.fail(f"{what}: {len(given)} states for {len(parents)} parents")
            for p, s in zip(parents, given):
                if s not in self.states[p]:
                    raise self.fail(f"{what}: {p!r} has no state {s!r}.{did_you_mean(s, self.states[p])}")
            index = tuple(self.states[p][s] for p, s in zip(parents, given))
            table[index] = self.row(self.numbers(card, f"{what}, row {tuple(given)}"), f"{what}, row {tuple(given)}")

    def net(self) -> GroundSlice:
        names = {n: self.properties[n].get("cprm_name", n) for n in self.states}
        variables, given = {}, []
        for n, full in names.items():
            p = self.properties[n]
            states = tuple(_unescaped(s) for s in p["cprm_states"].split("|")) if "cprm_states" in p else tuple(self.states[n])
            try:
                edges = np.array([float(e) for e in p["cprm_edges"].split()]) if "cprm_edges" in p else None
            except ValueError:
                raise FormatError(f"{self.where}: edges of {full!r} are not numbers: {p['cprm_edges']}") from None
            variables[full] = GroundVariable(
                full, states, edges, p.get("cprm_circular") == "yes", p.get("cprm_class", ""), p.get("cprm_object", ""),
                p.get("cprm_attribute", ""), p.get("cprm_clip") == "yes", p.get("cprm_unit", ""),
                p.get("cprm_auxiliary") == "yes",
            )  # fmt: skip
            _ = variables[full].domain  # refuses edges that do not increase
            if "yes" in (p.get("cprm_given"), p.get("cprm_input")):
                given.append(full)
        cpds = []
        for n, (parents, table) in self.tables.items():
            if names[n] not in given:
                table.flags.writeable = False
                cpds.append(GroundCPD(names[n], tuple((names[p], SAME) for p in parents), table, ("bif", names[n])))
        return GroundSlice(variables, tuple(cpds), tuple(given))
