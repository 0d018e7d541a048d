"""What an editor can do to the JSON form of a model, each operation a small JSON object.

================  ================================================================================================================
``set``           ``{path, value}``: put a value at a place of the form, ``["model", "classes", 0, "attributes", 1, "cpd"]``; null
                  takes an entry away
``insert``        ``{path, value}``: into a list, before the index that ends the path; the list is made if it is not there
``remove``        ``{path}``: an entry of a list or an object
``move``          ``{path, to}``: an entry of a list to another index
``rename``        ``{what, owner?, name, to}``: what is class, attribute, reference, given, relation, role or object; wherever it is
                  named, in parents and expressions too
``rename_state``  ``{owner, attribute, name, to}``: a state of a class's attribute, in its own tables and those of its children
``all``           ``{ops, what?}``: several as one, called so
================  ================================================================================================================
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import Any

from ...errors import CprmError, ModelError, unknown_name
from .model_renaming import rename, rename_state

Form = dict[str, Any]
Path = list[str | int]


def apply(form: Form, op: Mapping[str, Any]) -> Form:
    """The form after an operation; the one before stays as it is.

    Raises
    ------
    ModelError
        When the operation does not fit the form. Whether a valid model comes out is seen when it is built.
    """
    given = dict(op)
    name = given.pop("op", None)
    function = OPERATIONS.get(name) if isinstance(name, str) else None
    if function is None:
        raise unknown_name("operation", str(name), OPERATIONS)
    made = copy.deepcopy(form)
    try:
        function(made, **given)
    except (KeyError, IndexError) as error:
        raise ModelError(f"operation {name!r}: the model has no {error}") from None
    except (TypeError, AttributeError, ValueError) as error:
        if isinstance(error, CprmError):
            raise
        raise ModelError(f"operation {name!r}: its values are not of the right kind: {error}") from None
    _check_shape(made)
    return made


def _check_shape(form: Form) -> None:
    """Refuse a form that an editor could not show: whether the model is well defined is another question."""
    model = form.get("model")
    ok = isinstance(model, dict) and all(isinstance(form.get(part, {}), dict) for part in ("objects", "references"))
    lists: list[Any] = [model.get("classes", []), model.get("relations", [])] if isinstance(model, dict) else []
    for owner in [item for part in lists if isinstance(part, list) for item in part if isinstance(item, dict)]:
        lists += [owner.get(part, []) for part in ("attributes", "references", "given", "changes") if part in owner]
    ok = ok and all(isinstance(part, list) and all(isinstance(item, dict) for item in part) for part in lists)
    if not ok:
        raise ModelError("classes, relations and their parts are lists of objects, objects and references are objects")


def _holder(form: Form, path: Path) -> tuple[Any, Any]:
    """The list or object that holds the end of a path, and its key there."""
    if not isinstance(path, list) or not path or not all(isinstance(p, (str, int)) for p in path):
        raise ModelError(f"a path is a list of names and indices, got {path!r:.80}")
    at: Any = form
    for step in path[:-1]:
        if isinstance(at, dict) and step not in at:
            at[step] = [] if isinstance(path[path.index(step) + 1], int) else {}
        at = at[step]
    if not isinstance(at, (list, dict)) or isinstance(at, list) != isinstance(path[-1], int):
        raise ModelError(f"the path {path!r:.120} leads nowhere")
    return at, path[-1]


def _set(form: Form, path: Path, value: Any) -> None:
    holder, key = _holder(form, path)
    if value is None and isinstance(holder, dict):
        holder.pop(key, None)
    else:
        holder[key] = copy.deepcopy(value)


def _insert(form: Form, path: Path, value: Any) -> None:
    holder, key = _holder(form, path)
    if not isinstance(holder, list):
        raise ModelError(f"the path {path!r:.120} does not lead into a list")
    holder.insert(int(key), copy.deepcopy(value))


def _remove(form: Form, path: Path) -> None:
    holder, key = _holder(form, path)
    del holder[key]


def _move(form: Form, path: Path, to: int) -> None:
    holder, key = _holder(form, path)
    if not isinstance(holder, list):
        raise ModelError(f"the path {path!r:.120} does not lead into a list")
    holder.insert(to, holder.pop(key))


def _all(form: Form, ops: list[dict[str, Any]], what: str = "") -> None:
    for op in ops:
        given = dict(op)
        name = given.pop("op", "")
        if name not in OPERATIONS:
            raise unknown_name("operation", str(name), OPERATIONS)
        OPERATIONS[name](form, **given)


OPERATIONS: Mapping[str, Callable[..., None]] = {
    "set": _set, "insert": _insert, "remove": _remove, "move": _move, "rename": rename, "rename_state": rename_state, "all": _all,
}  # fmt: skip
