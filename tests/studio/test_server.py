"""The studio's server answers who knows the token and comes from its own page, and nobody else."""

import json
import urllib.error
import urllib.request

import pytest

from cprm_gym.errors import CprmError, ParameterError, UnknownName
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


def test_a_port_that_is_taken_is_named():
    from cprm_gym.studio.server import listen

    with listen("127.0.0.1", 0) as taken:
        taken.listen()
        with pytest.raises(CprmError, match=f"--port {taken.getsockname()[1]}"):
            listen("127.0.0.1", taken.getsockname()[1])
