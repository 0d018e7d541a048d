"""Beliefs in which objects have other names: the same net, called differently."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ....errors import ModelError
from ..grounding.grounding import Grounding, Situation
from ..model.schema import canonical_tuple, parse_tuple
from . import filtering
from .compiled.cache import Recent
from .compiled.slice_info import SliceInfo
from .filtering import FilterSettings, FilterState


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
