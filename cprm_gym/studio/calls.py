"""Which function answers which call of a page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..errors import ParameterError, unknown_name
from .arguments import check_arguments

Function = Callable[..., Any]
"""Takes its arguments by name, gives what JSON can say."""


class Calls:
    """The functions that pages may call, by names such as ``watch.step``: the room, then what is done there."""

    def __init__(self) -> None:
        self._functions: dict[str, Function] = {}

    def add(self, room: str, functions: Mapping[str, Function]) -> None:
        """Let the functions of a room be called.

        Raises
        ------
        ParameterError
            When one of them is there already.
        """
        for name, function in functions.items():
            full = f"{room}.{name}"
            if full in self._functions:
                raise ParameterError(f"call {full!r} is there already")
            self._functions[full] = function

    def names(self) -> tuple[str, ...]:
        """All that can be called."""
        return tuple(sorted(self._functions))

    def function(self, name: str) -> Function:
        """The function of a name.

        Raises
        ------
        UnknownName
            When there is none.
        """
        if name not in self._functions:
            raise unknown_name("call", name, self.names())
        return self._functions[name]

    def answer(self, name: str, given: Mapping[str, Any]) -> Any:
        """Call a function.

        Raises
        ------
        UnknownName
            When there is none of that name.
        ParameterError
            When the arguments are not its, or not of the types that it names.
        CprmError
            What the function says.
        """
        function = self.function(name)
        check_arguments(name, function, given)
        return function(**given)
