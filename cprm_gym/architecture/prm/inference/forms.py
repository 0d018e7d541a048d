"""Steps of a filter by form: relations that wander over like objects need no step of their own for each set of objects.

Objects of a class are alike where nothing but relations tells them apart. So a belief about o3, whom the agent attends to, is one about
o1 with other names. A filter whose relations change all the time therefore gives each object a *place*: those in relations come
first, those that already were before those that are new. A step is one of places, of which there are a few; readings are sorted
into places on the way in, and names are looked up on the way out. This is exact: it is the same net with other names.

It holds for exact inference of models without references, static attributes and windows, and for relations without variables of
their own. Whatever else happens, the filter goes on in its own names from the same belief.

References
----------
Dissertation section 2.3.4 (clusters of relations that follow object tokens).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ....errors import CprmError, ModelError
from ..grounding.grounding import Grounding, Situation
from ..model.schema import canonical_tuple, parse_tuple
from . import filtering
from .compiled.belief import FactoredBelief, Layout, Piece, PieceFactor
from .compiled.cache import Recent
from .compiled.slice_info import NeedsVariable, SliceInfo
from .engines.exact import ExactEngine
from .evidence import Readings
from .filtering import FilterSettings, FilterState, Past
from .posterior import Posterior

NOBODY = 1 << 30
"""Code of an object that is in no relation."""


class Order(NamedTuple):
    """Who is in which place.

    Attributes
    ----------
    objects : tuple of int
        The object in each place.
    codes : tuple of int
        What relations it was in.
    relations : Situation
        What held in the last slice, in the objects' own names.
    settled : bool
        The same relations held in the slice before.
    """

    objects: tuple[int, ...]
    codes: tuple[int, ...]
    relations: Situation
    settled: bool = False


class Wanted(NamedTuple):
    """Relations as numbers: tuples of objects, and for each object a code of the relations it is in."""

    atoms: tuple[tuple[str, tuple[int, ...]], ...]
    codes: tuple[int, ...]


Content = tuple[tuple[tuple[tuple[str, int], ...], int, int], ...]
"""Factors of a piece: attributes and slice of their variables, column and size."""

Part = tuple[int, np.ndarray]
"""One of the arrays of a form, and the places in it."""


class Form(NamedTuple):
    """A layout without names: which place has what in which array. Arrays with the like in them, in whatever columns, count as one.

    Attributes
    ----------
    kinds : (N,) int array
        Places of one kind have the like in the same arrays.
    arrays : tuple of tuple of (int, int array or None)
        Arrays that count as one, and the order in which to take their columns (None: as they stand).
    contents : tuple of tuple of Content
        Pieces of each object in them.
    position : (arrays, N) int array
        Where a place stands in each, -1 for nowhere.
    held : tuple of frozenset of str
        Attributes of each place that every agent observed.
    targets : Recent
        For kinds in another order the layout, and which array and which places make each of its arrays.
    """

    kinds: np.ndarray
    arrays: tuple[tuple[tuple[int, np.ndarray | None], ...], ...]
    contents: tuple[tuple[Content, ...], ...]
    position: np.ndarray
    held: tuple[frozenset[str], ...]
    targets: Recent[bytes, tuple[Layout, tuple[Part, ...]]]


class Forms:
    """What a filter remembers of forms.

    Parameters
    ----------
    settings : FilterSettings
        For which `applies` holds.
    """

    def __init__(self, settings: FilterSettings) -> None:
        assert isinstance(settings.grounding, Grounding)
        assert isinstance(settings.engine, ExactEngine)
        self.settings, self.grounding, self.engine = settings, settings.grounding, settings.engine
        self.names = tuple(self.grounding.objects)
        self.number = {name: k for k, name in enumerate(self.names)}
        places: dict[str, list[int]] = {}
        for name, class_name in self.grounding.objects.items():
            places.setdefault(class_name, []).append(self.number[name])
        self.classes = tuple(tuple(p) for p in places.values() if len(p) > 1)
        self.simple = {r.name for r in self.grounding.model.relations if not r.attributes and r.conflict != "mixture"}
        self.base = filtering.indexed(settings, self.grounding.ground(()), {})
        variables = self.base.variables.values()
        self.owner = np.array([self.number[v.object_name] for v in variables], np.int64)
        self.start = np.searchsorted(self.owner, np.arange(len(self.names)))
        self.offset = np.arange(len(self.owner)) - self.start[self.owner]
        self._codes: dict[tuple[tuple[str, int], ...], int] = {(): NOBODY}
        self._atoms: Recent[str, tuple[str, tuple[int, ...]]] = Recent(4096)
        self._wanted: Recent[tuple[Any, ...], Wanted | None] = Recent(4096)
        self._slices: Recent[tuple[tuple[str, tuple[int, ...]], ...], tuple[Situation, SliceInfo]] = Recent(1024)
        self._forms: Recent[Layout, Form | None] = Recent(1024)

    @staticmethod
    def applies(settings: FilterSettings) -> bool:
        """Whether objects of a class are alike, and steps can be made in places."""
        grounding = settings.grounding
        return (
            isinstance(grounding, Grounding)
            and isinstance(settings.engine, ExactEngine)
            and not settings.window
            and not settings.static
            and not any(c.references for c in grounding.model.classes)
            and len(set(grounding.objects.values())) < len(grounding.objects)
        )

    # ------------------------------------------------------------------------------------------------- one step

    def step(
        self,
        state: FilterState,
        order: Order | None,
        evidence: Mapping[str, Any] | np.ndarray | None,
        relations: tuple[Any, ...],
        soft: Mapping[str, Any] | None,
    ) -> tuple[FilterState, Order, Posterior] | None:
        """Go on by one slice.

        Parameters
        ----------
        state : FilterState
            In places, or in own names where `order` is None.
        order : Order or None
        evidence, relations, soft
            As for `Filter.step`, in own names.

        Returns
        -------
        (FilterState, Order, Posterior) or None
            None where the step has to be made in own names: by its relations, because readings are impossible or refused, or because
            another variable has to be kept.
        """
        wanted = self._wanted.fetch(relations, lambda: self._read(relations))
        if wanted is None or state.fresh.any() or state.late or not state.step:
            return None
        before = order or Order(tuple(range(len(self.names))), (NOBODY,) * len(self.names), state.relations)
        came = self._came_from(before, wanted)
        objects = tuple([before.objects[q] for q in came])
        codes = tuple([wanted.codes[o] for o in objects])
        still = order is not None and objects == order.objects and codes == order.codes
        belief = state.belief if still and before.settled else self.turned(state.belief, came)
        if belief is None:
            return None
        place = dict(zip(objects, range(len(objects))))
        key = tuple(sorted([(name, tuple([place[o] for o in members])) for name, members in wanted.atoms]))
        try:
            situation, info = self._slices.fetch(key, lambda: self._slice(key))
            told = filtering.read(info, state.batch, evidence, soft)
            readings = Readings(told.hard[self.rows(np.array(objects))], {self._placed(n, place): s for n, s in told.soft.items()})
            result = self.engine.advance(belief, info, readings)
        except (CprmError, NeedsVariable):
            return None
        if result.impossible.any():
            return None
        after = state._replace(
            belief=result.belief,
            step=state.step + 1,
            log_likelihood=state.log_likelihood + result.increment,
            history=(Past(belief, info, readings, state.fresh, situation),),
            relations=situation,
            exact=state.exact and result.exact,
            info=info,
        )
        now = self.grounding.situation(relations, None, before.relations)
        places = {self.names[o]: self.names[p] for p, o in enumerate(objects)}
        posterior = Posterior(
            result, state.step, after.log_likelihood, after.exact, result.impossible, now, places, lambda: self.grounding.ground(now)
        )
        return after, Order(objects, codes, now, still), posterior

    def _read(self, relations: tuple[Any, ...]) -> Wanted | None:
        """Relations as numbers; None if they are not simple, or no relations."""
        try:
            atoms = [self.grounding.canonical(r) for r in relations]
        except CprmError:
            return None
        numbers = dict.fromkeys([self._atoms.fetch(atom, lambda: self._atom(atom)) for atom in atoms])  # noqa: B023
        if not all(name in self.simple for name, _ in numbers):
            return None
        roles: list[list[tuple[str, int]]] = [[] for _ in self.names]
        for name, members in numbers:
            for role, o in enumerate(members):
                roles[o].append((name, role))
        codes = [self._codes.setdefault(tuple(sorted(r)), len(self._codes)) for r in roles]
        return Wanted(tuple(numbers), tuple(codes))

    def _atom(self, text: str) -> tuple[str, tuple[int, ...]]:
        name, members = parse_tuple(text)
        return name, tuple(self.number[o] for o in members)

    def _came_from(self, before: Order, wanted: Wanted) -> list[int]:
        """For each new place the old one: by the relations an object is in, then by those it was in, then by where it was."""
        came = list(range(len(self.names)))
        objects, old, new = before.objects, before.codes, wanted.codes
        for places in self.classes:
            for p, (_, _, q) in zip(places, sorted([(new[objects[q]], old[q], q) for q in places])):
                came[p] = q
        return came

    def _slice(self, key: Sequence[tuple[str, tuple[int, ...]]]) -> tuple[Situation, SliceInfo]:
        atoms = sorted(canonical_tuple(name, [self.names[p] for p in places]) for name, places in key)
        situation = Situation(tuple(atoms))
        return situation, filtering.indexed(self.settings, self.grounding.ground(situation), {})

    def rows(self, came: np.ndarray) -> np.ndarray:
        """Where the readings of each place stand if those of place p are those of ``came[p]``."""
        return np.asarray(self.start[came[self.owner]] + self.offset)

    def _placed(self, variable: str, place: Mapping[int, int]) -> str:
        owner, dot, attribute = variable.partition(".")
        return self.names[place[self.number[owner]]] + dot + attribute

    # ------------------------------------------------------------------------------------------------- beliefs

    def turned(self, belief: FactoredBelief, came: Sequence[int]) -> FactoredBelief | None:
        """The belief with what was in place ``came[p]`` in place p; None where objects depend on each other."""
        form = self._forms.fetch(belief.layout, lambda: self._form(belief.layout))
        if form is None:
            return None
        moved = np.array(came)
        kinds = form.kinds[moved].tobytes()
        layout, parts = form.targets.fetch(kinds, lambda: self._target(form, moved))
        batch = belief.hard.shape[1]
        messages = []
        for array, at in parts:
            blocks = [belief.messages[g] if columns is None else belief.messages[g][:, columns] for g, columns in form.arrays[array]]
            m = blocks[0] if len(blocks) == 1 else np.concatenate(blocks)
            if len(at) > 1:
                where = form.position[array, moved[at]]
                m = m[where] if batch == 1 else m.reshape(len(at), batch, m.shape[1])[where].reshape(m.shape)
            messages.append(m)
        return FactoredBelief(layout, tuple(messages), belief.hard[self.rows(moved)])

    def _form(self, layout: Layout) -> Form | None:
        if layout.info is None or layout.info.names != self.base.names:
            return None
        contents: dict[tuple[int, int], list[Content]] = {}
        owner: dict[tuple[int, int], int] = {}
        for piece in layout.pieces:
            at = piece.group, piece.instance
            owners = {self.number[name.partition(".")[0]] for f in piece.factors for name, _ in f.scope} | {owner.get(at, -1)} - {-1}
            if len(owners) != 1:
                return None
            owner[at] = owners.pop()
            factors = tuple((tuple((n.partition(".")[2], t) for n, t in f.scope), f.column, f.size) for f in piece.factors)
            contents.setdefault(at, []).append(factors)
        alike: dict[tuple[Content, ...], list[tuple[int, np.ndarray | None]]] = {}
        for g, count in enumerate(layout.counts):
            found = {tuple(contents.get((g, b), ())) for b in range(count)}
            if len(found) != 1:
                return None
            if () not in found:  # else the array carries nothing on
                pieces, columns = self._sorted(found.pop(), next(o for at, o in owner.items() if at[0] == g))
                alike.setdefault(pieces, []).append((g, columns))
        position = np.full((len(alike), len(self.names)), -1, np.int64)
        for s, arrays in enumerate(alike.values()):
            for k, at in enumerate((g, b) for g, _ in arrays for b in range(layout.counts[g])):
                position[s, owner[at]] = k
        held: list[set[str]] = [set() for _ in self.names]
        for name in layout.held:
            held[self.number[name.partition(".")[0]]].add(name.partition(".")[2])
        kinds: dict[Any, int] = {}
        numbers = [
            kinds.setdefault((c, frozenset(h), (p >= 0).tobytes()), len(kinds))
            for c, h, p in zip(self.grounding.objects.values(), held, position.T)
        ]
        named = tuple(alike)
        return Form(
            np.array(numbers, np.int32), tuple(map(tuple, alike.values())), named, position, tuple(map(frozenset, held)), Recent(1024)
        )

    def _sorted(self, pieces: Sequence[Content], owner: int) -> tuple[tuple[Content, ...], np.ndarray | None]:
        """Pieces, their factors and the axes of these in the order of their attributes, and where the columns then come from."""
        made: list[Content] = []
        columns: list[np.ndarray] = []
        for factors in sorted(tuple(sorted((tuple(sorted(scope)), scope, at) for scope, at, _ in factors)) for factors in pieces):
            piece = []
            for ordered, scope, at in factors:
                cards = [int(self.base.cards[self.base.row[f"{self.names[owner]}.{a}"]]) for a, _ in scope]
                numbers = at + np.arange(math.prod(cards)).reshape(cards).transpose([scope.index(v) for v in ordered]).ravel()
                piece.append((ordered, sum(len(c) for c in columns), len(numbers)))
                columns.append(numbers)
            made.append(tuple(piece))
        order = np.concatenate(columns)
        return tuple(made), None if np.array_equal(order, np.arange(len(order))) else order

    def _target(self, form: Form, came: np.ndarray) -> tuple[Layout, tuple[Part, ...]]:
        members = [np.flatnonzero(position[came] >= 0) for position in form.position]
        order = sorted(range(len(members)), key=lambda s: (members[s].tolist(), repr(form.contents[s])))
        pieces = []
        for g, s in enumerate(order):
            for b, p in enumerate(members[s]):
                for factors in form.contents[s]:
                    named = [PieceFactor(tuple((f"{self.names[p]}.{a}", t) for a, t in scope), *size) for scope, *size in factors]
                    pieces.append(Piece(g, b, tuple(named)))
        held = sorted((self.base.row[f"{self.names[p]}.{a}"], f"{self.names[p]}.{a}") for p, q in enumerate(came) for a in form.held[q])
        widths = tuple(sum(size for factors in form.contents[s] for _, _, size in factors) for s in order)
        counts = tuple(len(members[s]) for s in order)
        layout = self.engine.compiler.layouts.one(tuple(pieces), widths, counts, {name: row for row, name in held}, self.base)
        return layout, tuple((s, members[s]) for s in order)

    # ------------------------------------------------------------------------------------------------- own names

    def in_own_names(self, state: FilterState, order: Order) -> FilterState:
        """A state in places with objects under their own names."""
        to = {self.names[p]: self.names[o] for p, o in enumerate(order.objects)}
        info = filtering.indexed(self.settings, self.grounding.ground(order.relations), {})
        pairs = tuple(_renamed(self.base, to).items())
        (past,) = state.history
        place = np.argsort(np.array(order.objects))
        soft = {pair[1]: past.readings.soft[pair[0]] for pair in pairs if pair[0] in past.readings.soft}
        history = past._replace(
            before=self.engine.renamed(past.before, self.base, pairs),
            info=info,
            readings=Readings(past.readings.hard[self.rows(place)], soft),
            relations=order.relations,
        )
        belief = self.engine.renamed(state.belief, info, pairs)
        return state._replace(belief=belief, history=(history,), relations=order.relations, info=info)


def _renamed(info: SliceInfo, to: Mapping[str, str]) -> dict[str, str]:
    """Old and new name of each variable of objects."""
    return {name: to[v.object_name] + name[len(v.object_name) :] for name, v in info.variables.items()}


# ----------------------------------------------------------------------------------------------------- other names


class Renamings:
    """Gives the objects of a state other names, and remembers how.

    Parameters
    ----------
    settings : FilterSettings
    grounding : Grounding
    """

    def __init__(self, settings: FilterSettings, grounding: Grounding) -> None:
        self.settings, self.grounding = settings, grounding
        self._known: Recent[Any, tuple[Situation, SliceInfo, tuple[tuple[str, str], ...]]] = Recent(1024)

    def of(self, state: FilterState, names: Mapping[str, str]) -> FilterState:
        """A state in which objects have other names."""
        if state.step == 0:
            return state
        assert state.info is not None
        key = state.info, state.relations, tuple(names.items())
        settled, info, pairs = self._known.fetch(key, lambda: self._renaming(state, names))
        belief = self.settings.engine.renamed(state.belief, info, pairs)
        return state._replace(belief=belief, relations=settled, history=(), info=info)

    def _renaming(self, state: FilterState, names: Mapping[str, str]) -> tuple[Situation, SliceInfo, tuple[tuple[str, str], ...]]:
        """What holds under other names, the slice with them, and old and new name of each variable."""
        assert state.info is not None
        situation = self._renamed_situation(state.relations, names)
        name_of = {v.name: rename_variable(v.name, v.object_name, names) for v in state.info.variables.values()}
        # what entered with the slice is nothing to the next one; the common form lets beliefs be joined
        settled = Situation(situation.relations, situation.objects)
        info = filtering.indexed(self.settings, self.grounding.ground(settled), {})
        if set(name_of.values()) != set(info.names):
            info = filtering.indexed(self.settings, self.grounding.ground(situation, first=state.step == 1), {})
        strange = set(name_of.values()) ^ set(info.names)
        if strange:
            raise ModelError(f"a belief cannot be renamed: {', '.join(sorted(strange)[:3])}")
        return settled, info, tuple(name_of.items())

    def _renamed_situation(self, situation: Situation, names: Mapping[str, str]) -> Situation:
        relations = tuple(rename_tuple(r, names) for r in situation.relations)
        objects = None if situation.objects is None else tuple(names.get(o, o) for o in situation.objects)
        entering = tuple(rename_tuple(x, names) if "(" in x else names.get(x, x) for x in situation.entering)
        return Situation(self.grounding.situation(relations).relations, objects, entering)


def rename_tuple(text: str, names: Mapping[str, str]) -> str:
    """A relation tuple of objects with other names."""
    relation, objects = parse_tuple(text)
    return canonical_tuple(relation, (names.get(o, o) for o in objects))


def rename_variable(variable: str, owner: str, names: Mapping[str, str]) -> str:
    """A variable of an object, or of a relation tuple, with another name."""
    if not owner or not variable.startswith(owner):
        return variable
    return (rename_tuple(owner, names) if "(" in owner else names.get(owner, owner)) + variable[len(owner) :]


def fronted(engaged: Sequence[bool]) -> list[int]:
    """An order of places that begins with the engaged ones: those in front stay, whom they drive out come next."""
    count = sum(engaged)
    late = [k for k in range(count, len(engaged)) if engaged[k]]
    front = [k if engaged[k] else late.pop(0) for k in range(count)]
    return [*front, *(k for k in range(len(engaged)) if not engaged[k])]
