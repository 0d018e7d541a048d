"""Malformed, truncated, oversized, spoofed and flooding datagrams: nothing breaks, leaks or waits."""

import gc
import resource
import socket
import sys
import time

import numpy as np
import pytest

from cprm_gym.server import Port, Server, Settings, Transport

WORDS = [
    b"(dash 50)", b"(turn 10)", b"(kick 100 0)", b"(move 1 1)", b"(say hi)", b'(say "hi there")', b"(catch 0)",
    b"(tackle 10 on)", b"(done)", b"(ear (off opp))", b"(change_view narrow low)", b"(pointto 10 10)",
    b"(attentionto our 3)", b"(clang (ver 7 8))", b"(compression 3)", b"(score)", b"(sense_body)",
    b"(init Left (version 19))", b"(init X)", b"(reconnect Left 1)", b"(dispinit version 4)", b"(dispstart)",
    b"(dispfoul 1 1 1)", b"(dispplayer 1 1 5 5 5)", b"(change_mode play_on)", b"(move (player Left 1) 1 1 0 0 0)",
    b"(start)", b"(recover)", b"(look)", b"(team_names)", b"(change_player_type 2 5)", b"(say (freeform \"x\"))",
    b"(eye on)", b'(team_graphic (0 0 "8 8 1 1" "a c #FFF" "aaaaaaaa"))', b"(check_ball)", b"\0", b" ", b"((((",
    b"))))", b"1e999", b"-0", b"\xff\xfe",
]  # fmt: skip


NEWCOMERS = (
    (Port.PLAYER, b"(init Left (version 19))"),
    (Port.PLAYER, b"(init Right (version 5))"),
    (Port.TRAINER, b"(init (version 19))"),
    (Port.COACH, b"(init Left (version 19))"),
    (Port.PLAYER, b"(dispinit version 5)"),
    (Port.PLAYER, b"(dispinit version -1)"),
)


def hostile(random):
    """A datagram of pieces of words, sometimes cut, sometimes with bytes changed, sometimes far too long."""
    pieces = [WORDS[k] for k in random.integers(0, len(WORDS), int(random.integers(1, 5)))]
    data = bytearray(b"".join(pieces))
    for _ in range(int(random.integers(0, 4))):
        if data:
            data[int(random.integers(len(data)))] = int(random.integers(256))
    kind = random.random()
    if kind < 0.2:
        del data[int(random.integers(len(data) + 1)) :]
    elif kind < 0.21:
        data *= 600
    return bytes(data) + (b"\0" if kind < 0.9 else b"")


def memory():
    with open("/proc/self/statm") as stream:
        return int(stream.read().split()[1]) * resource.getpagesize() / 2**20


def attack(count, seed=0):
    """The core under that many datagrams, from strangers and from clients of every kind; growth of memory in MiB in the second half."""
    server = Server(Settings.from_words(["server::coach_w_referee=true", "server::send_comms=true"]))
    roles = []

    def join():
        roles[:] = [role for role in roles if role.connected][-12:]
        for port, first in NEWCOMERS:
            made = server.receive(port, f"{port}{len(roles)}{time.monotonic()}", first)
            if made is not None:
                roles.append(made)

    random = np.random.default_rng(seed)
    half = 0.0
    for n in range(count):
        if n % 1000 == 0:
            join()
            for monitor in server.stadium.monitors[:-2]:
                server.lose(monitor)
        data = hostile(random)
        if random.random() < 0.3:
            server.receive(Port(int(random.integers(3))), int(random.integers(1 << 30)), data)
        elif roles:
            role = roles[int(random.integers(len(roles)))]
            if role.connected:
                server.receive_many([(role, data)])
        if n % 50 == 49:
            server.step()
            server.look_again()
            server.look_late()
            server.think()
            server.over = ""
        server.take_outbox()
        if n == count // 2:
            gc.collect()
            half = memory()
    world = server.stadium.world
    assert all(np.isfinite(world[name]).all() for name in ("pos", "vel", "body", "neck", "stamina"))
    assert len(server._clients) <= 600
    gc.collect()
    return memory() - half


def test_three_thousand_hostile_datagrams():
    attack(3000)


@pytest.mark.slow
def test_a_million_hostile_datagrams():
    """`pytest -m slow tests/server/test_floods.py`, some minutes of CPU."""
    assert attack(1_000_000) < 20


@pytest.mark.skipif(sys.platform != "linux", reason="sends to a socket that is never read")
def test_a_client_that_never_reads_delays_nobody():
    server = Server(Settings.from_words(["server::synch_mode=false"]))
    with Transport(server, ports=(0, 0, 0)) as transport:
        deaf, good = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        with deaf, good:
            deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
            for sock in (deaf, good):
                sock.sendto(b"(init Left (version 19))\0", ("127.0.0.1", transport.ports[0]))
                transport.receive(1.0)
            good.setblocking(False)
            began, heard = time.monotonic(), 0
            for _ in range(300):
                server.step()
                transport.send()
                while True:
                    try:
                        heard += good.recv(8192).startswith(b"(sense_body")
                    except BlockingIOError:
                        break
            assert heard == 300
            assert time.monotonic() - began < 10


def test_a_flood_is_read_in_turns_and_spoofed_datagrams_not_at_all():
    server = Server()
    with Transport(server, ports=(0, 0, 0)) as transport:
        flood, good, spoof = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3))
        with flood, good, spoof:
            peers = []
            for sock in (flood, good):
                sock.settimeout(5)
                sock.sendto(b"(init Left (version 19))\0", ("127.0.0.1", transport.ports[0]))
                transport.receive(1.0)
                peers.append(sock.recvfrom(8192)[1])
            for _ in range(500):
                flood.sendto(b"(score)\0", peers[0])
            good.sendto(b"(turn_neck 20)\0", peers[1])
            spoof.sendto(b"(turn_neck 80)\0", peers[1])  # the socket is connected to its client
            assert transport.receive(1.0) < 200
            world = server.stadium.world
            assert world["neck_staged"][1] == pytest.approx(np.radians(20))
