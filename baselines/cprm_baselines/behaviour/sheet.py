"""Named quantities of all worlds, computed once in each cycle from the texts in which nets have them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cprm_gym.architecture.expressions import Assembler, Code, Expression
from cprm_gym.architecture.expressions.kernels import run_columns, run_rows
from cprm_gym.errors import ModelError, unknown_name


class Sheet:
    """One column for each quantity, one row for each world.

    Quantities are added first (`observe`, `constant`, `derive`), in any order; then `fill` computes them. A text reads columns by name.
    """

    def __init__(self) -> None:
        self._columns: dict[str, int] = {}
        self._observed: dict[str, str] = {}
        self._constants: dict[str, float] = {}
        self._texts: dict[str, Expression] = {}
        self._asked: dict[str, Code] = {}
        self._code: Code | None = None
        self._targets = np.zeros(0, np.int32)
        self.rows: NDArray[np.float64] = np.zeros((0, 0))

    @property
    def names(self) -> tuple[str, ...]:
        """Of all columns."""
        return tuple(self._columns)

    def __contains__(self, name: str) -> bool:
        return name in self._columns

    def _add(self, name: str) -> str:
        if name in self._columns:
            raise ModelError(f"the quantity {name!r} is there already")
        self._columns[name] = len(self._columns)
        self._code = None
        return name

    def observe(self, percept: str) -> str:
        """A column for an observed quantity, by its own name; returns the name. It may be asked for again."""
        if percept not in self._columns:
            self._observed[self._add(percept)] = percept
        return percept

    def constant(self, name: str, value: float) -> str:
        """A column that a structure may write to (`rows`); it holds `value` at first and in worlds that begin."""
        self._constants[self._add(name)] = float(value)
        return name

    def derive(self, name: str, text: str, names: Mapping[str, str] | None = None) -> str:
        """A column that follows from others.

        Parameters
        ----------
        name, text : str
        names : mapping of str to str, optional
            Names in the text -> columns, where they differ.
        """
        expression = Expression(text)
        self._texts[self._add(name)] = expression.rename(lambda n: names.get(n, n)) if names else expression
        return name

    def evaluate(self, text: str, names: Mapping[str, str]) -> NDArray[np.float64]:
        """The value of a text now, one for each world; NaN where it is not defined.

        Raises
        ------
        UnknownName
            For a name that is no column.
        """
        if text not in self._asked:
            expression = Expression(text).rename(lambda n: names.get(n, n))
            for read in expression.names:
                if read not in self._columns:
                    raise unknown_name(f"quantity in {text!r}:", read, self._columns)
            assembler = Assembler(self._columns.__getitem__)
            assembler.add(expression.tree)
            self._asked[text] = assembler.finish()
        code, out = self._asked[text], np.empty(len(self.rows))
        run_rows(code.code, code.constants, 0, len(code.code), self.rows, np.zeros(code.depth + 1), out)
        return out

    def _compile(self) -> None:
        """The texts in an order in which each reads only what is known.

        Raises
        ------
        UnknownName
            For a name that is no column.
        ModelError
            For quantities that follow from themselves.
        """
        order: list[str] = []
        waiting: set[str] = set()

        def visit(name: str) -> None:
            if name in waiting:
                raise ModelError(f"the quantity {name!r} follows from itself")
            waiting.add(name)
            for read in self._texts[name].names:
                if read not in self._columns:
                    raise unknown_name(f"quantity in {self._texts[name].text!r}:", read, self._columns)
                if read in self._texts and read not in done:
                    visit(read)
            waiting.discard(name)
            if name not in done:
                done.add(name)
                order.append(name)

        done: set[str] = set()
        for name in self._texts:
            if name not in done:
                visit(name)
        assembler = Assembler(self._columns.__getitem__)
        for name in order:
            assembler.add(self._texts[name].tree)
        self._code = assembler.finish()
        self._targets = np.array([self._columns[name] for name in order], np.int32)

    def begin(self, worlds: int) -> None:
        """Rows for so many worlds."""
        if self._code is None:
            self._compile()
        self.rows = np.zeros((worlds, len(self._columns)))
        for name, value in self._constants.items():
            self.rows[:, self._columns[name]] = value

    def restart(self, worlds: NDArray[np.bool_]) -> None:
        """Constants as at first in the worlds that begin anew."""
        for name, value in self._constants.items():
            self.rows[worlds, self._columns[name]] = value

    def fill(self, percepts: Mapping[str, NDArray[np.float64]]) -> None:
        """Read the percepts and compute the rest; a quantity that is not defined is NaN, and no condition on it holds."""
        for name in self._observed:
            self.rows[:, self._columns[name]] = percepts[name]
        self.derive_all()

    def derive_all(self) -> None:
        """Compute what follows from the rest again, after a constant was written to."""
        code = self._code
        assert code is not None
        run_columns(code.code, code.constants, code.start, self._targets, self.rows, np.zeros(code.depth + 1))

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """The column of a quantity, one value for each world."""
        return self.rows[:, self._columns[name]]
