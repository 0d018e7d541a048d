"""The studio's server answers who knows the token and comes from its own page, and nobody else."""

import contextlib
import json
import urllib.error
import urllib.request

import numpy as np
import pytest

from cprm_gym.errors import CprmError, ParameterError, UnknownName
from cprm_gym.studio.arguments import types_of
from cprm_gym.studio.calls import Calls

TOKEN = "token-of-the-tests"
client = pytest.importorskip("websockets.sync.client")


def fetched(port, path, host=None):
    request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", headers={} if host is None else {"Host": host})
    try:
        with urllib.request.urlopen(request) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def connected(served, token=TOKEN, origin=None):
    origin = f"http://127.0.0.1:{served.port}" if origin is None else origin
    return client.connect(f"ws://127.0.0.1:{served.port}/ws?token={token}", origin=origin)


def asked(ws, name, number=1, **given):
    ws.send(json.dumps({"id": number, "call": name, "with": given}))
    while True:
        message = json.loads(ws.recv(timeout=20))
        if message.get("re") == number:
            return message


def test_the_page_is_given_to_who_knows_the_token(serve):
    served = serve()
    assert fetched(served.port, f"/?token={TOKEN}")[0] == 200
    for path in ("/", "/?token=", "/?token=wrong"):
        code, text = fetched(served.port, path)
        assert code == 403
        assert "main.js" not in text
    assert fetched(served.port, f"/?token={TOKEN}", host="evil.example")[0] == 403


def test_files_come_from_the_folder_of_the_page_alone(serve):
    served = serve()
    assert fetched(served.port, "/static/js/main.js")[0] == 200
    for path in ("/static/../server.py", "/static/%2e%2e/server.py", "/static/js/../../command.py", "/static/js", "/static/none.js",
                 "/static/a%00b.js", f"/static/{'a' * 5000}.js", "/static//etc/passwd"):  # fmt: skip
        assert fetched(served.port, path)[0] == 404


@pytest.mark.parametrize(("token", "origin"), [("wrong", None), (TOKEN, "http://evil.example"), (TOKEN, "null"), ("", None)])
def test_the_socket_refuses_another_origin_and_a_wrong_token(serve, token, origin):
    served = serve()
    with pytest.raises(Exception, match="403"), connected(served, token, origin):
        pass
    with connected(served) as ws:
        assert asked(ws, "studio.about")["result"]["title"] == "studio"


def test_what_a_call_does_wrong_is_answered_and_the_connection_stays(serve):
    served = serve()
    with connected(served) as ws:
        assert asked(ws, "watch.stepp")["error"].startswith("unknown call 'watch.stepp'. Did you mean 'watch.step'?")
        assert "unexpected keyword argument" in asked(ws, "watch.step", cycle=3)["error"]
        assert asked(ws, "watch.step")["kind"] == "CprmError"
        ws.send("[1, 2")
        assert json.loads(ws.recv(timeout=20))["kind"] == "FormatError"
        ws.send(json.dumps({"id": 5, "call": ["a"]}))
        assert json.loads(ws.recv(timeout=20))["kind"] == "FormatError"
        halves = ('{"id": "\\ud800", "call": "studio.about"}', '{"id": 6, "call": "\\uD800.about"}')
        for broken in ("[" * 100_000, '{"id": NaN, "call": "studio.about"}', '{"id": 1e999, "call": "studio.about"}', *halves):
            ws.send(broken)
            assert json.loads(ws.recv(timeout=20))["kind"] == "FormatError"
        assert asked(ws, "studio.about", 9)["result"]["view"] == "run"


def test_calls_are_found_by_name_and_bound_by_their_arguments():
    calls = Calls()
    calls.add("room", {"twice": lambda x: 2 * x})
    assert calls.answer("room.twice", {"x": 4}) == 8
    with pytest.raises(UnknownName, match=r"unknown call 'room\.twise'"):
        calls.answer("room.twise", {})
    with pytest.raises(ParameterError, match="missing a required argument: 'x'"):
        calls.answer("room.twice", {})
    with pytest.raises(ParameterError, match="is there already"):
        calls.add("room", {"twice": abs})


@pytest.mark.parametrize(
    ("call", "given", "words"),
    [
        ("watch.step", {"cycles": "3"}, "call 'watch.step', argument 'cycles': a whole number is needed, got '3'"),
        ("watch.step", {"cycles": True}, "a whole number is needed, got True"),
        ("watch.step", {"cycles": 10**400}, "a whole number is needed, got a number of too many digits"),
        ("watch.speed", {"cycles": float("inf")}, "argument 'cycles': a finite number is needed, got inf"),
        ("watch.why", {"agent": 1, "transition": "leap"}, "argument 'agent': a text is needed, got 1"),
        ("watch.why", {"agent": "left_1", "transition": ["leap"]}, "argument 'transition': a text is needed, got ['leap']"),
        ("watch.plan", {"agent": "a", "unfold": [1]}, "argument 'unfold': a list of texts or a whole number is needed, got [1]"),
        ("watch.show", {"agents": [], "variables": {"a": "b"}}, "an object of lists of texts or null is needed, got {'a': 'b'}"),
        ("edit.apply", {"id": "d1", "op": "x" * 500}, "argument 'op': an object is needed, got 'xxx"),
        ("edit.view", {"id": "d1", "definition": "a", "quantities": 0}, "argument 'quantities': true or false is needed, got 0"),
        ("model.query", {"id": "d1", "slices": [1]}, "argument 'slices': a list of objects is needed, got [1]"),
    ],
)
def test_arguments_of_another_type_are_named_with_what_is_allowed(serve, call, given, words):
    with pytest.raises(ParameterError) as told:
        serve().studio.calls.answer(call, given)
    assert words in str(told.value)
    assert len(str(told.value)) < 250


def test_whatever_a_page_sends_is_answered_by_an_error_of_ours(serve):
    """Junk of every type for every argument of every call: none of them fails in another way."""
    calls = serve(demo="goalie", seed=2).studio.calls
    calls.answer("watch.open", {})
    (document,) = (one["id"] for one in calls.answer("edit.list", {})["open"])
    junk = [
        None,
        True,
        0,
        -1,
        2.5,
        10**30,
        "",
        "left_1",
        document,
        "a" * 300,
        [],
        ["a"],
        [[]],
        [{}],
        {},
        {"a": 1},
        {"op": "add_place", "in": 3},
    ]
    random = np.random.default_rng(7)
    for name in calls.names():
        if name in ("run.analyze", "run.episodes", "edit.close", "watch.play"):  # long ones, and those that end what the others need
            continue
        for _ in range(12):
            arguments = [a for a in types_of(calls.function(name)) if a != "cycles"]
            given = {argument: junk[random.integers(len(junk))] for argument in arguments if random.random() < 0.9}
            with contextlib.suppress(CprmError, OSError):
                json.dumps(calls.answer(name, given), allow_nan=False)


def test_a_port_that_is_taken_is_named():
    from cprm_gym.studio.server import listen

    with listen("127.0.0.1", 0) as taken:
        taken.listen()
        with pytest.raises(CprmError, match=f"--port {taken.getsockname()[1]}"):
            listen("127.0.0.1", taken.getsockname()[1])
