"""What the runner of one agent has ready: his belief places as questions that are asked together, and slices imagined beforehand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..petri.execution.executor import Executor
from ..prm.inference.alone.questions import Question
from ..prm.inference.filter_bank import FilterBank
from ..prm.inference.links import Link, Role
from ..prm.inference.views import View
from .rehearsal import rehearse
from .sights import Sight
from .value import CPRM


def questions_of(
    beliefs: Sequence[tuple[str, str, View, float]], class_at: Mapping[str, str], executor: Executor, bank: FilterBank
) -> tuple[Question, ...]:
    """The belief places as questions to a bank of one agent; none where one is about a relation's variable.

    Parameters
    ----------
    beliefs : sequence of (place, variable, view, default)
    class_at : mapping of str to str
        Class of the objects that each object place holds.
    executor : Executor
    bank : FilterBank
    """
    questions = []
    for _, variable, view, default in beliefs:
        owner, _, attribute = variable.partition(".")
        meant = owner in class_at
        class_name = class_at[owner] if meant else bank.grounding.objects.get(owner)
        if class_name is None:
            return ()
        number = executor.object_names.index(owner) if meant else bank.members[class_name].index(owner)
        questions.append(Question(view, class_name, number, meant, attribute, default))
    return tuple(questions)


def imagine(
    cprm: CPRM,
    bank: FilterBank,
    sights: Sequence[Sight],
    class_at: Mapping[str, str],
    questions: tuple[Question, ...],
    counts: Sequence[int],
    slices: int,
) -> None:
    """Imagine slices; what is observed under one condition is observed together.

    Parameters
    ----------
    cprm : CPRM
    bank : FilterBank
    sights : sequence of Sight
    class_at : mapping of str to str
        As for `questions_of`.
    questions : tuple of Question
    counts : sequence of int
        How many objects there are for each object place.
    slices : int
    """
    together: dict[str, list[str]] = {}
    for sight in sights:
        together.setdefault(sight.when.text, []).append(sight.name)
    place = {name: k for k, name in enumerate(class_at)}

    def links(held: NDArray[np.int32]) -> tuple[Link, ...]:
        def role(name: str) -> str | Role:
            return name[1:] if name.startswith("=") else Role(class_at[name], held[place[name] : place[name] + 1])

        return tuple(Link(cluster.relation, tuple(map(role, cluster.places))) for cluster in cprm.clusters)

    rehearse(bank, list(together.values()), counts, links, slices, lambda held: bank.views(questions, held[None]))
