"""What a page can ask about the models that are open (room ``model``): tables, the ground net, queries, learning."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from ...architecture.cprm import CPRM
from ...architecture.prm import Grounding
from ...errors import ParameterError
from . import model_view
from .desk import Desk
from .document import Value
from .expressions import check_text
from .logs import ITERATIONS, learn, read_log


class Models:
    """The models of a desk.

    Parameters
    ----------
    desk : Desk
    """

    def __init__(self, desk: Desk) -> None:
        self.desk = desk

    def calls(self) -> dict[str, Callable[..., Any]]:
        """What a page can call."""
        return {
            "expression": self.expression,
            "table": self.table,
            "graph": self.graph,
            "query": self.query,
            "tuples": self.tuples,
            "learn": self.learn,
        }

    def table(self, id: str, kind: str, owner: str, label: str, part: str = "cpd") -> dict[str, Any]:
        """A CPD as a table (`model_view.cpd_table`)."""
        return model_view.cpd_table(self.desk.document(id).model_value(), kind, owner, label, part)

    def expression(self, id: str, text: str, names: Sequence[str]) -> dict[str, Any]:
        """Whether an expression can stand in a CPD with parents of these names, while it is being typed."""
        self.desk.document(id)
        return check_text(text, {str(name): None for name in names})

    def tuples(self, id: str) -> dict[str, Any]:
        """The objects, and the relations that can be in force."""
        grounding = self.desk.document(id).grounding()
        return {"objects": grounding.objects, "tuples": model_view.tuples(grounding)}

    def graph(self, id: str, relations: Sequence[str] = (), first: bool = False) -> dict[str, Any]:
        """The ground net of one slice (`model_view.graph`)."""
        return model_view.graph(self.desk.document(id).grounding(), relations, first)

    def query(self, id: str, slices: Sequence[dict[str, Any]], engine: str = "exact") -> dict[str, Any]:
        """What is believed after some slices (`model_view.query`)."""
        return model_view.query(self.desk.document(id).grounding(), slices, engine)

    def learn(self, id: str, path: str, method: str = "em", prior: float | None = None, iterations: int = ITERATIONS) -> dict[str, Any]:
        """Learn the CPDs from a log; the document then holds the learned model, which can be undone."""
        document = self.desk.document(id)
        grounding, revision = document.grounding(), document.revision
        model, told = learn(grounding, read_log(self.desk.files.inside(path)), method, prior, iterations)
        if document.revision != revision:
            raise ParameterError(f"{document.name}: was changed while its model was being learned; learn again")
        value = document.value()
        made: Value = model
        if isinstance(value, CPRM):
            made = replace(value, model=model)
        elif isinstance(value, Grounding):
            made = Grounding(model, grounding.objects, document.data.get("references") or {})
        return {**self.desk.replace(id, made, f"learned from {path}"), "learned": told}
