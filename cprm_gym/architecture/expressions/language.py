"""The language: what may be written, the tree it becomes, and the errors that point at the mistake."""

from __future__ import annotations

import ast
import keyword
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from ...errors import ExpressionError, did_you_mean

MAX_LENGTH = 1000
"""Characters in one expression."""
MAX_DEPTH = 24
"""Operations nested in each other."""
MAX_NODES = 400
"""Numbers, names and operations in one expression."""
MAX_EXPONENT = 16
"""Largest exponent of ``**``, which is always a written number."""
MAX_NUMBER = 1e15
"""Largest written number."""

CONSTANTS: Mapping[str, float] = {"pi": 3.141592653589793, "True": 1.0, "False": 0.0}

FUNCTIONS: Mapping[str, int] = {
    "abs": 1, "sign": 1, "sqrt": 1, "exp": 1, "log": 1, "floor": 1, "ceil": 1, "round": 1,
    "sin": 1, "cos": 1, "tan": 1, "asin": 1, "acos": 1, "atan": 1, "atan2": 2, "hypot": 2,
    "degrees": 1, "radians": 1, "norm_angle": 1, "norm_deg": 1, "clip": 3, "min": -2, "max": -2,
}  # fmt: skip
"""Function -> number of arguments; -2 means two or more."""

_BINARY: Mapping[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Mod: "%"}
_COMPARE: Mapping[type[ast.cmpop], str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
WORDS = frozenset({"and", "or", "not", "if", "else", "True", "False", "None"})
"""Words of the language, beside functions and constants; no name may be one of them."""

_PYTHON_WORDS = re.compile(rf"\b({'|'.join(sorted(set(keyword.kwlist) - WORDS))})\b")
_PART = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
_PRECEDENCE = {"if": 0, "or": 1, "and": 2, "not": 3, "<": 4, "<=": 4, ">": 4, ">=": 4, "==": 4, "!=": 4, "+": 5, "-": 5,
               "*": 6, "/": 6, "%": 6, "neg": 7, "**": 8}  # fmt: skip


@dataclass(frozen=True)
class Node:
    """One operation, name or number of an expression.

    Parameters
    ----------
    op : str
        ``number``, ``name``, ``+ - * / % **``, ``neg``, ``< <= > >= == !=``, ``and``, ``or``, ``not``, ``if`` (condition, then,
        else) or a function of `FUNCTIONS`.
    args : tuple of Node
    value : float
        Of a number.
    name : str
        Of a name, parts joined by dots.
    at : int
        Column in the text; not part of the value.
    """

    op: str
    args: tuple[Node, ...] = ()
    value: float = 0.0
    name: str = ""
    at: int = field(default=0, compare=False)

    def walk(self) -> Iterator[Node]:
        """This node and all below it, arguments before operations."""
        for arg in self.args:
            yield from arg.walk()
        yield self


def complaint(text: str, at: int, message: str) -> ExpressionError:
    """The error that shows `text` with a caret under column `at`."""
    if len(text) > MAX_LENGTH or not text.isprintable():
        return ExpressionError(f"{message}: {text[:60]!r}{'...' if len(text) > 60 else ''}")
    return ExpressionError(f"{message}\n    {text}\n    {' ' * at}^")


def parse(text: str) -> Node:
    """The tree of an expression.

    Parameters
    ----------
    text : str
        At most `MAX_LENGTH` printable ASCII characters.

    Raises
    ------
    ExpressionError
        When anything outside the language is found; the message shows the text and a caret under the mistake.
    """
    if not isinstance(text, str):
        raise ExpressionError(f"an expression is text, got {type(text).__name__}: {text!r}")
    if len(text) > MAX_LENGTH:
        raise complaint(text, 0, f"expression of {len(text)} characters; at most {MAX_LENGTH} are allowed")
    if not text.strip():
        raise ExpressionError("empty expression")
    if not (text.isascii() and text.isprintable()):
        at = next(i for i, c in enumerate(text) if not (c.isascii() and c.isprintable()))
        raise ExpressionError(f"character {text[at]!r} at column {at} of {text!r}; an expression is printable ASCII")
    # Python's other keywords are names like any other here: hidden from its parser, read from the text afterwards
    source = _PYTHON_WORDS.sub(lambda word: "_" * len(word[0]), text.strip())
    shift = len(text) - len(text.lstrip())
    _check_nesting(text)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(source, mode="eval").body
    except SyntaxError as error:
        at = min(error.offset - 1 + shift, len(text)) if error.offset else len(text.rstrip())  # no offset: the text ends too early
        raise complaint(text, at, f"not an expression: {error.msg}") from None
    except (ValueError, MemoryError, RecursionError):
        raise complaint(text, 0, "not an expression: nested too deeply") from None
    node = _Reader(text, shift).read(tree, 1)
    count = sum(1 for _ in node.walk())
    if count > MAX_NODES:
        raise complaint(text, 0, f"expression of {count} parts; at most {MAX_NODES} are allowed")
    return node


def _check_nesting(text: str) -> None:
    depth = 0
    for at, c in enumerate(text):
        depth += (c in "([{") - (c in ")]}")
        if depth > 4 * MAX_DEPTH:
            raise complaint(text, at, "brackets nested too deeply")


class _Reader:
    """Turns Python's tree into ours, refusing whatever is not on the list."""

    def __init__(self, text: str, shift: int) -> None:
        self.text = text
        self.shift = shift

    def at(self, tree: ast.AST) -> int:
        return int(getattr(tree, "col_offset", 0)) + self.shift

    def written(self, tree: ast.expr, length: int) -> str:
        """The last `length` characters of a part of the text."""
        end = int(tree.end_col_offset or 0) + self.shift
        return self.text[end - length : end]

    def refuse(self, tree: ast.AST, message: str) -> ExpressionError:
        return complaint(self.text, self.at(tree), message)

    def read(self, tree: ast.expr, depth: int) -> Node:
        if depth > MAX_DEPTH:
            raise self.refuse(tree, f"more than {MAX_DEPTH} operations nested in each other")
        reader = _READERS.get(type(tree))
        if reader is None:
            raise self.refuse(tree, f"{_describe(tree)} is not part of the expression language")
        return reader(self, tree, depth)

    def number(self, tree: ast.Constant, depth: int) -> Node:
        value = tree.value
        if isinstance(value, bool):
            return Node("number", value=float(value), at=self.at(tree))
        if not isinstance(value, (int, float)):
            raise self.refuse(tree, f"{value!r} is not a number; only numbers may be written")
        if not abs(value) <= MAX_NUMBER:
            raise self.refuse(tree, f"number beyond {MAX_NUMBER:g}")
        return Node("number", value=float(value), at=self.at(tree))

    def name(self, tree: ast.Name | ast.Attribute, depth: int) -> Node:
        parts: list[str] = []
        inner: ast.expr = tree
        while isinstance(inner, ast.Attribute):
            parts.append(self.written(inner, len(inner.attr)))
            inner = inner.value
        if not isinstance(inner, ast.Name):
            raise self.refuse(tree, f"only names have dotted parts, not {_describe(inner)}")
        parts.append(self.written(inner, len(inner.id)))
        for part in parts:
            if not _PART.match(part):
                raise self.refuse(tree, f"{part!r} cannot be part of a name: names start with a letter")
        name = ".".join(reversed(parts))
        if name in CONSTANTS:
            return Node("number", value=CONSTANTS[name], at=self.at(tree))
        if name in FUNCTIONS:
            raise self.refuse(tree, f"{name!r} is a function; write {name}(...)")
        return Node("name", name=name, at=self.at(tree))

    def unary(self, tree: ast.UnaryOp, depth: int) -> Node:
        if isinstance(tree.op, ast.UAdd):
            return self.read(tree.operand, depth + 1)
        if isinstance(tree.op, ast.Invert):
            raise self.refuse(tree, "'~' is not part of the expression language")
        arg = self.read(tree.operand, depth + 1)
        if isinstance(tree.op, ast.Not):
            return Node("not", (arg,), at=self.at(tree))
        if arg.op == "number":
            return Node("number", value=-arg.value or 0.0, at=self.at(tree))  # there is one zero
        return Node("neg", (arg,), at=self.at(tree))

    def binary(self, tree: ast.BinOp, depth: int) -> Node:
        left = self.read(tree.left, depth + 1)
        if isinstance(tree.op, ast.Pow):
            right = self.read(tree.right, depth + 1)
            if right.op != "number":
                raise self.refuse(tree.right, "the exponent of ** must be a written number")
            if abs(right.value) > MAX_EXPONENT:
                raise self.refuse(tree.right, f"exponent beyond {MAX_EXPONENT}")
            return Node("**", (left, right), at=self.at(tree))
        op = _BINARY.get(type(tree.op))
        if op is None:
            raise self.refuse(tree, f"operator {_describe(tree.op)} is not part of the expression language")
        return Node(op, (left, self.read(tree.right, depth + 1)), at=self.at(tree))

    def boolean(self, tree: ast.BoolOp, depth: int) -> Node:
        op = "and" if isinstance(tree.op, ast.And) else "or"
        node = self.read(tree.values[0], depth + 1)
        for value in tree.values[1:]:
            node = Node(op, (node, self.read(value, depth + 1)), at=self.at(tree))
        return node

    def compare(self, tree: ast.Compare, depth: int) -> Node:
        operands = [self.read(operand, depth + 1) for operand in (tree.left, *tree.comparators)]
        node: Node | None = None
        for i, compare in enumerate(tree.ops):
            op = _COMPARE.get(type(compare))
            if op is None:
                raise self.refuse(tree, f"{_describe(compare)!r} is not part of the expression language")
            pair = Node(op, (operands[i], operands[i + 1]), at=self.at(tree))
            node = pair if node is None else Node("and", (node, pair), at=self.at(tree))
        assert node is not None
        return node

    def conditional(self, tree: ast.IfExp, depth: int) -> Node:
        parts = tuple(self.read(part, depth + 1) for part in (tree.test, tree.body, tree.orelse))
        return Node("if", parts, at=self.at(tree))

    def call(self, tree: ast.Call, depth: int) -> Node:
        if not isinstance(tree.func, ast.Name):
            raise self.refuse(tree, "only the functions of the language can be called")
        name = self.written(tree.func, len(tree.func.id))
        if name not in FUNCTIONS:
            known = f"{did_you_mean(name, FUNCTIONS)} Known: {', '.join(sorted(FUNCTIONS))}"
            raise self.refuse(tree, f"unknown function {name!r}.{known}")
        if tree.keywords or any(isinstance(arg, ast.Starred) for arg in tree.args):
            raise self.refuse(tree, f"{name} takes its arguments by position")
        arity, given = FUNCTIONS[name], len(tree.args)
        if given != arity if arity > 0 else given < -arity:
            wanted = str(arity) if arity > 0 else f"{-arity} or more"
            raise self.refuse(tree, f"{name} takes {wanted} argument{'' if arity == 1 else 's'}, got {given}")
        args = [self.read(arg, depth + 1) for arg in tree.args]
        if arity > 0:
            return Node(name, tuple(args), at=self.at(tree))
        node = args[0]
        for arg in args[1:]:
            node = Node(name, (node, arg), at=self.at(tree))
        return node


_READERS: Mapping[type[ast.expr], Callable[..., Node]] = {
    ast.Constant: _Reader.number, ast.Name: _Reader.name, ast.Attribute: _Reader.name, ast.UnaryOp: _Reader.unary,
    ast.BinOp: _Reader.binary, ast.BoolOp: _Reader.boolean, ast.Compare: _Reader.compare, ast.IfExp: _Reader.conditional,
    ast.Call: _Reader.call,
}  # fmt: skip

_DESCRIPTIONS: Mapping[str, str] = {
    "Subscript": "a subscript", "List": "a list", "Tuple": "a tuple", "Dict": "a dictionary", "Set": "a set",
    "JoinedStr": "a formatted string", "NamedExpr": "an assignment", "Starred": "a starred expression", "Constant": "a number",
    "Call": "a call", "FloorDiv": "//", "MatMult": "@", "LShift": "<<", "RShift": ">>", "BitOr": "|", "BitAnd": "&", "BitXor": "^",
}  # fmt: skip


def _describe(tree: ast.AST) -> str:
    name = type(tree).__name__
    return _DESCRIPTIONS.get(name, name)


def unparse(node: Node, rename: Callable[[str], str] | None = None) -> str:
    """The text of a tree, with every bracket it needs and no other.

    Parameters
    ----------
    node : Node
    rename : callable, optional
        Maps every name to the one that is written.
    """
    return _write(node, rename or str)[0]


def _write(node: Node, rename: Callable[[str], str]) -> tuple[str, int]:
    if node.op == "number":
        text = repr(int(node.value)) if node.value == int(node.value) else repr(node.value)
        return text, 10 if node.value >= 0 else 7
    if node.op == "name":
        return rename(node.name), 10
    if node.op in FUNCTIONS:
        return f"{node.op}({', '.join(_write(arg, rename)[0] for arg in node.args)})", 10
    level = _PRECEDENCE[node.op]

    def part(index: int, least: int) -> str:
        text, own = _write(node.args[index], rename)
        return text if own >= least else f"({text})"

    if node.op == "if":
        return f"{part(1, 1)} if {part(0, 1)} else {part(2, 0)}", level
    if node.op == "not":
        return f"not {part(0, 3)}", level
    if node.op == "neg":
        # a bare number after the minus would be read as a negative number
        return (f"-({part(0, 0)})" if node.args[0].op == "number" else f"-{part(0, 7)}"), level
    if node.op == "**":
        return f"{part(0, 9)} ** {part(1, 7)}", level
    if level == 4:
        return f"{part(0, 5)} {node.op} {part(1, 5)}", level
    return f"{part(0, level)} {node.op} {part(1, level + 1)}", level
