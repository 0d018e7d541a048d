"""Numbers to text and back: what Python's own functions give, for every kind of number that a log holds."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cprm_gym.simulator.kernels.digits import put_real, put_whole, read_real, read_whole

BUFFER = np.zeros(64, np.uint8)


def written(value: float) -> str | None:
    size = put_real(BUFFER, 0, float(value))
    return None if size < 0 else BUFFER[:size].tobytes().decode()


def bytes_of(text: str) -> np.ndarray:
    return np.frombuffer(text.encode(), np.uint8)


def test_numbers_are_written_as_python_writes_them():
    draw = np.random.default_rng(5)
    some = [
        draw.uniform(-60, 60, 20_000), draw.integers(-(10**6), 10**6, 20_000) * 1e-4, draw.integers(-(10**6), 10**6, 20_000) * 1e-3,
        draw.uniform(0, 8000, 20_000), draw.integers(0, 1_999_998, 20_000) * 0.5, draw.integers(0, 2**20, 20_000) / 256,
        10 ** draw.uniform(-3.9, 5.9, 20_000),
    ]  # fmt: skip
    wrong = [value for value in np.concatenate(some).tolist() if abs(value) >= 1e-4 and written(value) != f"{value:g}"]
    assert wrong == []


@pytest.mark.parametrize(
    "value", [0.1, 0.01, 0.001, 1e-4, 1.0, 10.0, 99999.95, 9.999995, 0.9999995, 999998.5, 0.0, -0.0, -2.5, 7900.125, 7900.375]
)
def test_numbers_at_the_edges_are_written_as_python_writes_them(value):
    for near in (value, math.nextafter(value, math.inf)):
        if near == 0.0 or near >= 1e-4:
            assert written(near) == f"{near:g}"


def test_what_needs_an_exponent_is_left_to_python_and_nan_is_0():
    assert [written(value) for value in (1e6, 999999.5, 9e-5, -5e-324, math.inf)] == [None] * 5
    assert written(math.nan) == "0"


@given(st.from_regex(r"-?[0-9]{0,12}\.?[0-9]{0,12}", fullmatch=True))
def test_a_number_is_read_as_python_reads_it_or_not_at_all(text):
    value, end = read_real(bytes_of(text), 0)
    if end >= 0:
        assert (math.copysign(1.0, value), value, end) == (math.copysign(1.0, float(text)), float(text), len(text))
    else:
        assert value == 0.0


@given(st.floats(-1e5, 1e5).filter(lambda x: x == 0 or abs(x) > 1e-4))
def test_what_was_written_is_read_back(value):
    text = written(value)
    assert text is not None
    assert read_real(bytes_of(text), 0) == (float(text), len(text))


@given(st.integers(-(10**9), 10**9))
def test_whole_numbers_go_both_ways(value):
    size = put_whole(BUFFER, 0, value)
    assert BUFFER[:size].tobytes().decode() == str(value)
    assert read_whole(BUFFER[:size], 0) == (value, size)


@pytest.mark.parametrize("text", ["", "-", "12345678901", "x"])
def test_what_is_no_whole_number_is_not_read(text):
    assert read_whole(bytes_of(text), 0) == (0, -1)
