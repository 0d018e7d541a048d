"""The expression language: its values three ways, what it refuses, and its bounds."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cprm_gym.architecture.expressions import FUNCTIONS, Assembler, Expression, Node, parse, unparse
from cprm_gym.architecture.expressions import kernels as k
from cprm_gym.architecture.expressions.interpreter import interpret
from cprm_gym.errors import ExpressionError

NAMES = ("x", "y", "ball.distance")


def compiled(text: str, values: dict[str, float]) -> float:
    """The value by the byte code; NaN for undefined."""
    assembler = Assembler(list(values).index)
    assembler.add(Expression(text).tree)
    code = assembler.finish()
    return k.run(code.code, code.constants, 0, len(code.code), np.array(list(values.values())), np.zeros(code.depth))


def value(text: str, **values: float) -> float:
    """The value, the same in both forms."""
    interpreted = interpret(Expression(text).tree, values)
    fast = compiled(text, values)
    assert fast == pytest.approx(interpreted, rel=1e-14, abs=1e-300, nan_ok=True)
    return interpreted


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2 * 3", 7), ("(1 + 2) * 3", 9), ("(2 ** 3) ** 2 / 4", 16), ("-2 ** 2", -4), ("7 % 3", 1), ("-7 % 3", 2), ("7 % -3", -2),
        ("1 / 4", 0.25), ("2 ** -1", 0.5), ("4 ** 0.5", 2), ("+3", 3), ("- -3", 3), ("1e3", 1000), ("0x10", 16), ("True + True", 2),
        ("1 < 2", 1), ("2 < 1", 0), ("1 < 2 < 3", 1), ("1 < 3 < 2", 0), ("1 == 1.0", 1), ("1 != 1", 0), ("2 >= 2", 1), ("2 <= 1", 0),
        ("1 and 2", 1), ("0 and 2", 0), ("0 or 0", 0), ("0 or 5", 1), ("not 3", 0), ("not 0", 1), ("not 1 < 2", 0),
        ("3 if 1 else 4", 3), ("3 if 0 else 4", 4), ("1 if 0 else 2 if 0 else 3", 3),
        ("abs(-3)", 3), ("sign(-2)", -1), ("sign(0)", 0), ("sqrt(9)", 3), ("exp(0)", 1), ("log(1)", 0),
        ("floor(-1.5)", -2), ("ceil(-1.5)", -1), ("round(2.5)", 2), ("round(3.5)", 4), ("sin(0)", 0),
        ("cos(pi)", -1), ("tan(0)", 0), ("asin(1)", math.pi / 2), ("acos(1)", 0),
        ("atan(1)", math.pi / 4), ("atan2(1, -1)", 3 * math.pi / 4), ("hypot(3, 4)", 5), ("degrees(pi)", 180), ("radians(180)", math.pi),
        ("norm_deg(190)", -170), ("norm_deg(-180)", 180), ("norm_deg(180)", 180), ("norm_deg(900)", 180), ("norm_deg(-725)", -5),
        ("norm_angle(3 * pi / 2)", -math.pi / 2), ("clip(5, 0, 3)", 3), ("clip(-5, 0, 3)", 0), ("clip(2, 0, 3)", 2),
        ("min(3, 1, 2)", 1), ("max(3, 1, 2, 9)", 9),
    ],
)  # fmt: skip
def test_values_are_those_of_mathematics(text, expected):
    assert value(text) == pytest.approx(expected, abs=1e-12)


def test_names_have_dotted_parts():
    text = "clip(6 * ball.distance, 0, 100) + x"
    assert Expression(text).names == ("ball.distance", "x")
    assert Expression(text).evaluate({"ball.distance": 5, "x": 1}) == 31
    assert compiled(text, {"ball.distance": 5, "x": 1}) == 31


def test_a_long_chain_of_conditions_is_allowed():
    assert Expression(" and ".join(["x"] * 120)).evaluate({"x": 1}) == 1


def test_python_keywords_are_names():
    assert Expression("pass.target + in * from.x - lambda").names == ("pass.target", "in", "from.x", "lambda")
    assert Expression("pass.target + in").evaluate({"pass.target": 2, "in": 3}) == 5


@pytest.mark.parametrize(
    "text",
    ["1 / 0", "1 % 0", "sqrt(-1)", "log(0)", "log(-1)", "exp(1000)", "asin(2)", "acos(-2)", "0 ** -1", "(-8) ** 0.5",
     "1e15 ** 16 * 1e15 ** 16", "1 / 0 < 2", "min(1, 1 / 0)", "max(log(0), 3)", "not sqrt(-1)", "1 and 1 / 0",
     "0 or 1 / 0", "1 / 0 and 0", "1 / (1 / 0)",
     "1 / 0 if 1 else 2", "3 if 1 / 0 else 3", "clip(1 / 0, 0, 1)"],
)  # fmt: skip
def test_undefined_is_an_error_with_the_text(text):
    assert math.isnan(value(text))
    with pytest.raises(ExpressionError, match="has no finite value at no operands"):
        Expression(text).evaluate({})


@pytest.mark.parametrize(
    ("text", "expected"),
    [("0 and 1 / 0", 0), ("1 or 1 / 0", 1), ("2 if 1 else 1 / 0", 2), ("1 / 0 if 0 else 3", 3), ("x != 0 and 1 / x > 2", 0)],
)
def test_a_text_can_guard_itself(text, expected):
    assert value(text, x=0.0) == expected


def test_undefined_shows_the_operands():
    with pytest.raises(ExpressionError, match=r"expression 'x / y' has no finite value at x = 3, y = 0"):
        Expression("x / y").evaluate({"x": 3, "y": 0})


def test_unknown_names_get_a_suggestion_and_a_caret():
    with pytest.raises(ExpressionError) as error:
        Expression("2 * speeed").evaluate({"speed": 1})
    assert str(error.value) == "unknown name 'speeed'. Did you mean 'speed'? Known: speed\n    2 * speeed\n        ^"


def test_not_finite_operands_make_it_undefined():
    for bad in (math.nan, math.inf, -math.inf):
        assert math.isnan(value("x < 3", x=bad))
        assert value("5 if y else x", x=bad, y=1.0) == 5


# -- what is refused ----------------------------------------------------------------------------------------------------------------

REFUSED = [
    ("", "empty expression"),
    ("   ", "empty expression"),
    ("__import__('os').system('ls')", "only the functions of the language can be called"),
    ("().__class__.__bases__[0]", "a subscript is not part of the expression language"),
    ("x.__class__", "'__class__' cannot be part of a name"),
    ("_x", "'_x' cannot be part of a name"),
    ("x._y", "'_y' cannot be part of a name"),
    ("(1).real", "only names have dotted parts, not a number"),
    ("abs(x).y", "only names have dotted parts, not a call"),
    ("open('f')", "unknown function 'open'"),
    ("eval('1')", "unknown function 'eval'"),
    ("x.append(1)", "only the functions of the language can be called"),
    ("abs", "'abs' is a function; write abs"),
    ("abs()", "abs takes 1 argument, got 0"),
    ("min(1)", "min takes 2 or more arguments, got 1"),
    ("clip(1, 2)", "clip takes 3 arguments, got 2"),
    ("max(*x)", "max takes its arguments by position"),
    ("max(x, y=1)", "max takes its arguments by position"),
    ("max(x, **y)", "max takes its arguments by position"),
    ("2 ** 1000", "exponent beyond 16"),
    ("2 ** 2 ** 2 ** 2", "the exponent of .* must be a written number"),
    ("2 ** x", "the exponent of .* must be a written number"),
    ("1e400", "number beyond 1e.15"),
    ("9" * 40, "number beyond"),
    ("x // y", "operator // is not part"),
    ("x @ y", "operator @ is not part"),
    ("x << 1", "operator << is not part"),
    ("x | y", "operator .* is not part"),
    ("~x", "'~' is not part"),
    ("'text'", "'text' is not a number"),
    ("b'text'", "is not a number"),
    ("1j", "is not a number"),
    ("None", "None is not a number"),
    ("...", "Ellipsis is not a number"),
    ("f'{x}'", "a formatted string is not part"),
    ("[1, 2]", "a list is not part"),
    ("x, y", "a tuple is not part"),
    ("{1: 2}", "a dictionary is not part"),
    ("{1, 2}", "a set is not part"),
    ("x[0]", "a subscript is not part"),
    ("(x := 3)", "an assignment is not part"),
    ("lambda: 0", "not an expression"),
    ("[x for x in y]", "not an expression"),
    ("x in y", "not an expression"),
    ("x is y", "not an expression"),
    ("import os", "not an expression"),
    ("x = 1", "not an expression"),
    ("x; y", "not an expression"),
    ("1 +", "not an expression"),
    (")", "not an expression"),
    ("x y", "not an expression"),
    ("x\ny", "character '.n' at column 1"),
    ("x\0", "character '.x00' at column 1"),
    ("größe", "character 'ö' at column 2"),
    ("ｘ", "an expression is printable ASCII"),
    ("x" * 1001, "expression of 1001 characters; at most 1000 are allowed"),
    ("(" * 150 + "x" + ")" * 150, "brackets nested too deeply"),
    ("-" * 900 + "x", "nested"),
    ("not " * 200 + "x", "more than 24 operations nested in each other"),
    ("+".join(["x"] * 300), "more than 24 operations nested in each other"),
    (",".join(["max(x"] * 30) + ",1)" * 30, "more than 24 operations nested"),
    ("max(" + ",".join(["x"] * 300) + ")", "expression of 599 parts; at most 400 are allowed"),
]


@pytest.mark.parametrize(("text", "message"), REFUSED, ids=[text[:20] for text, _ in REFUSED])
def test_everything_outside_the_language_is_refused(text, message):
    with pytest.raises(ExpressionError, match=message):
        Expression(text)


@pytest.mark.parametrize("thing", [None, 3, b"x", ["x"]])
def test_only_text_is_an_expression(thing):
    with pytest.raises(ExpressionError, match="an expression is text, got"):
        Expression(thing)


@pytest.mark.parametrize(("text", "at"), [("1 + open(x)", 4), ("  x + [1]", 6), ("x ** 99", 5), ("x +* y", 3), ("a.b + c.__d__", 6)])
def test_errors_show_the_text_and_a_caret_under_the_mistake(text, at):
    with pytest.raises(ExpressionError) as error:
        Expression(text)
    lines = str(error.value).split("\n")
    assert lines[1:] == [f"    {text}", "    " + " " * at + "^"]


PIECES = [
    "x", "y", "ball.distance", "1", "2.5", "0", "1e9", "(", ")", "(", ")", "+", "-", "*", "/", "%", "**", " ", ",", ".", "<", "<=", "==",
    "and ", "or ", "not ", " if ", " else ", "min(", "clip(", "sqrt(", "norm_deg(", "abs(", "pi", "__class__", "_", "[", "]", "{", "}",
    ":", "'", '"', "=", "lambda ", "import ", "\\", "#", "@", "~", "!", ";", "f'", "0x", "1_0", "1e", "j", "…", "\n", "\t", "\0", "None",
    "True", "open(", "exec(", "in ", "is ", "await ",
]  # fmt: skip


def fuzz(count: int, seed: int) -> int:
    """Throw random texts at the parser; whatever it accepts must have one value in both forms. Returns how many it accepted."""
    rng = np.random.default_rng(seed)
    accepted = 0
    values = {"x": 1.5, "y": -2.0, "ball.distance": 7.25}
    for _ in range(count):
        if rng.random() < 0.2:
            text = bytes(rng.integers(0, 256, rng.integers(1, 40)).tolist()).decode("latin-1")
        else:
            text = "".join(PIECES[i] for i in rng.integers(0, len(PIECES) if rng.random() < 0.3 else 34, rng.integers(1, 14)))
        try:
            expression = Expression(text)
        except ExpressionError:
            continue
        accepted += 1
        if set(expression.names) <= set(values):
            result = interpret(expression.tree, values)
            assert compiled(text, values) == pytest.approx(result, rel=1e-12, abs=1e-12, nan_ok=True), text
            assert parse(unparse(expression.tree)) == expression.tree, text
    return accepted


def test_random_texts_are_refused_or_have_a_value():
    assert fuzz(10_000, 1) > 100


@pytest.mark.slow
def test_a_hundred_thousand_random_texts_are_refused_or_have_a_value():
    assert fuzz(100_000, 2) > 1000


# -- one tree, three readings -------------------------------------------------------------------------------------------------------

NUMBERS = st.floats(-50, 50, allow_nan=False).map(lambda x: round(x, 2))
LEAVES = st.one_of(NUMBERS.map(lambda x: Node("number", value=x)), st.sampled_from(NAMES).map(lambda name: Node("name", name=name)))


def operations(inner):
    """Nodes over the nodes of `inner`."""
    unary = [name for name, arity in FUNCTIONS.items() if arity == 1] + ["not"]
    binary = ["+", "-", "*", "/", "%", "<", "<=", ">", ">=", "==", "!=", "and", "or", "min", "max", "atan2", "hypot"]
    exponent = st.sampled_from([-2.0, -1.0, 0.0, 0.5, 1.0, 2.0, 3.0]).map(lambda x: Node("number", value=x))
    names = st.sampled_from(NAMES).map(lambda name: Node("name", name=name))
    return st.one_of(
        st.builds(lambda op, a: Node(op, (a,)), st.sampled_from(unary), inner),
        st.builds(lambda a: Node("neg", (a,)), names),
        st.builds(lambda op, a, b: Node(op, (a, b)), st.sampled_from(binary), inner, inner),
        st.builds(lambda a, b: Node("**", (a, b)), inner, exponent),
        st.builds(lambda op, a, b, c: Node(op, (a, b, c)), st.sampled_from(["if", "clip"]), inner, inner, inner),
    )


TREES = st.recursive(LEAVES, operations, max_leaves=9)


@given(TREES)
def test_text_of_a_tree_parses_to_the_tree(tree):
    assert parse(unparse(tree)) == tree


@given(TREES, NUMBERS, NUMBERS, NUMBERS)
def test_byte_code_and_interpreter_agree(tree, x, y, z):
    values = dict(zip(NAMES, (x, y, z)))
    assert compiled(unparse(tree), values) == pytest.approx(interpret(tree, values), rel=1e-11, abs=1e-11, nan_ok=True)


RANGES = st.tuples(NUMBERS, st.sampled_from([0.0, 0.5, 3.0, 40.0])).map(lambda r: (r[0], r[0] + r[1]))


@given(TREES, RANGES, RANGES, RANGES, st.lists(st.tuples(*[st.floats(0, 1)] * 3), min_size=5, max_size=20))
def test_bounds_enclose_every_value(tree, a, b, c, points):
    ranges = dict(zip(NAMES, (a, b, c)))
    expression = Expression(unparse(tree))
    bounds = expression.bounds({name: ranges[name] for name in expression.names})
    for point in [(0, 0, 0), (1, 1, 1), *points]:
        values = {name: min(max(low + t * (high - low), low), high) for (name, (low, high)), t in zip(ranges.items(), point)}
        result = interpret(tree, values)
        if math.isnan(result):
            assert not bounds.total
        else:
            assert bounds.low <= result <= bounds.high


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("x + y", -3, 4), ("x * y", -4, 4), ("abs(x)", 0, 2), ("x ** 2", 0, 4), ("clip(x, 0, 1)", 0, 1), ("x > 5", 0, 0), ("x < 5", 1, 1),
        ("norm_deg(x + 360)", -1, 2), ("min(x, y)", -2, 2), ("1 if x > 5 else 2", 2, 2), ("sqrt(x + 2)", 1, 2), ("hypot(x, y)", 0, 8**0.5),
        ("sin(x)", -math.sin(1), 1), ("not x > 5", 1, 1), ("x > 5 and 1 / 0 > 1", 0, 0),
    ],
)  # fmt: skip
def test_bounds_are_tight_where_they_can_be(text, low, high):
    bounds = Expression(text).bounds({name: {"x": (-1, 2), "y": (-2, 2)}[name] for name in Expression(text).names})
    assert (bounds.low, bounds.high) == pytest.approx((low, high), abs=1e-8)
    assert bounds.total


def test_bounds_say_where_a_text_may_be_undefined():
    assert not Expression("1 / x").bounds({"x": (-1, 1)}).total
    assert Expression("1 / x").bounds({"x": (1, 2)}).total
    assert Expression("1 / x").bounds({"x": (0, 0)}).empty
    assert Expression("1 / x if x > 1 else 0").bounds({"x": (2, 4)}).total


def test_bounds_need_a_finite_range_for_every_name():
    with pytest.raises(ExpressionError, match="no range for 'x'"):
        Expression("x").bounds({})
    with pytest.raises(ExpressionError, match=r"the range of 'x' is \(low, high\), finite"):
        Expression("x").bounds({"x": (0, math.inf)})


def test_expressions_are_values():
    assert Expression("x + 1") == Expression("x + 1")
    assert len({Expression("x"), Expression("x")}) == 1
    assert Expression("x + y * x").rename(lambda name: f"a.{name}").text == "a.x + a.y * a.x"


def test_many_rows_at_once():
    assembler = Assembler(["x", "y"].index)
    first, second = (assembler.add(Expression(text).tree) for text in ("x + y", "x / y"))
    code = assembler.finish()
    rows, out = np.array([[1.0, 2.0], [3.0, 0.0]]), np.zeros(2)
    stack = np.zeros(code.depth)
    k.run_rows(code.code, code.constants, code.start[first], code.start[first + 1], rows, stack, out)
    assert out.tolist() == [3, 3]
    k.run_rows(code.code, code.constants, code.start[second], code.start[second + 1], rows, stack, out)
    assert out[0] == 0.5
    assert math.isnan(out[1])


EXTREMES = (-1.7976931348623157e308, -1e308, -1.0, -5e-324, 0.0, 5e-324, 0.3, 1.0, 1e308, 1.7976931348623157e308)


@pytest.mark.parametrize(
    "text",
    ["x % 0.5", "x % -1e-10", "x % x", "x / 1e-10", "x ** 16", "x ** -15", "norm_deg(x)", "norm_angle(2 * x)", "hypot(x, x)", "floor(x)",
     "round(x)", "tan(x)", "exp(x)", "log(x)", "degrees(x)", "atan2(x, x)"],
)  # fmt: skip
def test_bounds_hold_up_to_the_largest_numbers(text):
    expression = Expression(text)
    for i, low in enumerate(EXTREMES):
        for high in EXTREMES[i:]:
            bounds = expression.bounds({"x": (low, high)})
            for x in (low, high):
                result = interpret(expression.tree, {"x": x})
                assert not bounds.total if math.isnan(result) else bounds.low <= result <= bounds.high, (low, high, x)


def test_there_is_one_zero():
    assert value("atan2(-0, -1)") == math.pi
    assert Expression("-0.0 + x").rename(str) == Expression("0 + x")
