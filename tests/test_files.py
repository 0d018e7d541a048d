"""Files that are there whole or not at all."""

import os
import stat

import pytest

from cprm_gym.errors import FormatError
from cprm_gym.files import parse_json, write_atomically


def test_a_written_file_has_the_permissions_of_any_new_file(tmp_path):
    write_atomically(tmp_path / "ours", "text")
    (tmp_path / "plain").write_text("text")
    assert (tmp_path / "ours").read_bytes() == b"text"
    assert stat.S_IMODE((tmp_path / "ours").stat().st_mode) == stat.S_IMODE((tmp_path / "plain").stat().st_mode)


def test_a_failed_write_leaves_the_old_content_and_nothing_else(tmp_path, monkeypatch):
    write_atomically(tmp_path / "file", b"old")

    def fail(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(KeyboardInterrupt):
        write_atomically(tmp_path / "file", b"new")
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("file", b"old")]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[" * 200_000, "x: nested too deeply; at most 64 levels"),
        ("[" * 70 + "]" * 70, "x: nested too deeply; at most 64 levels"),
        ('{"a": [1, 1e999]}', "x: a number is too large"),
        ('{"a": -1e999}', "x: a number is too large"),
        ("[NaN]", "x: not JSON: NaN is not a number"),
        ("[1" + "0" * 5000 + "]", "x: not JSON"),
        ("{", "x: not JSON"),
    ],
)
def test_a_json_text_that_is_none_or_unreasonable_is_refused(text, message):
    with pytest.raises(FormatError, match=message):
        parse_json(text, "x")


def test_a_json_text_is_read():
    assert parse_json('{"a": [1, 2.5, "x", null, true, {"b": []}]}', "x") == {"a": [1, 2.5, "x", None, True, {"b": []}]}
