"""Server time of a cycle over UDP: ``python tests/benchmarks/bench_server.py [CYCLES]``.

22 trivial clients in one process, the server in another; protocol 19, lock-step, one ``(dash)(turn_neck)(done)`` datagram of each a cycle.
Beside it what 55 bare sends of the same size and 22 receives cost in the same process, which no server can save.
"""

import itertools
import multiprocessing
import os
import select
import socket
import statistics
import sys
import time

from cprm_gym.server import Server, Settings, Transport, run_synchronously

BEGIN = 200
"""Cycles that are not counted."""


def serve(pipe, cycles, words):
    """Play so many cycles; seconds of CPU of each hundred, bytes and datagrams of a cycle, and the bare cost."""
    server = Server(Settings.from_words(["server::synch_mode=true", "server::coach_w_referee=true", *words]))
    with Transport(server, ports=(0, 0, 0)) as transport:
        pipe.send(transport.ports)
        times, sent = [], [0, 0]
        take = server.take_outbox

        def counted():
            out = take()
            sent[0] += len(out)
            sent[1] += sum(len(datagram.data) for datagram in out)
            return out

        server.take_outbox = counted

        def each():
            players = len(list(server.stadium.players()))
            if players == 22 and server.stadium.time == 0:
                server.stadium.sim.trainer.start()
                server.stadium.world_changed()
            time_ = server.stadium.time
            if time_ >= BEGIN and time_ % 100 == 0:
                times.append((time.process_time(), *sent))
            return time_ < BEGIN + cycles

        run_synchronously(transport, fast=True, each=each)
        spent = [b[0] - a[0] for a, b in itertools.pairwise(times)]
        datagrams = (times[-1][1] - times[0][1]) / (len(spent) * 100)
        size = (times[-1][2] - times[0][2]) / (len(spent) * 100)
    pipe.send((spent, datagrams, size, bare(55, 22, int(size / datagrams))))


def bare(sends, receives, size, rounds=300):
    """Seconds of CPU of so many sends and receives on connected sockets."""
    sinks = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(22)]
    sources = []
    for sink in sinks:
        sink.bind(("127.0.0.1", 0))
        source = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        source.bind(("127.0.0.1", 0))
        source.connect(sink.getsockname())
        sink.connect(source.getsockname())
        sources.append(source)
    data, reply = b"x" * size, b"(dash 60)(turn_neck 10)(done)\0"
    spent = []
    for _ in range(rounds):
        for k in range(receives):
            sinks[k % 22].send(reply)
        begin = time.process_time()
        for k in range(sends):
            sources[k % 22].send(data)
        for k in range(receives):
            sources[k % 22].recv(8192)
        spent.append(time.process_time() - begin)
        for sink in sinks:
            sink.setblocking(False)
            while True:
                try:
                    sink.recv(8192)
                except BlockingIOError:
                    break
            sink.setblocking(True)
    for sock in (*sinks, *sources):
        sock.close()
    return statistics.median(spent)


def play(ports):
    """22 clients that dash and turn their necks until the server falls silent."""
    poll, sockets = select.epoll(), {}
    for n in range(22):
        sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        name, goalie = ("Left" if n < 11 else "Right"), " (goalie)" if n % 11 == 0 else ""
        sock.sendto(f"(init {name} (version 19){goalie})\0".encode(), ("127.0.0.1", ports[0]))
        _, peer = sock.recvfrom(8192)
        sock.connect(peer)
        sock.setblocking(False)
        sockets[sock.fileno()] = sock
        poll.register(sock.fileno(), select.EPOLLIN)
    silent = 0
    while silent < 3:
        ready = poll.poll(1)
        silent = 0 if ready else silent + 1
        for number, _ in ready:
            try:
                while True:
                    if sockets[number].recv(8192).startswith(b"(think"):
                        sockets[number].send(b"(dash 60)(turn_neck 10)(done)\0")
            except BlockingIOError:
                pass
            except ConnectionRefusedError:
                return


def main():
    cycles = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    for name, words in (("no logs", ()), ("fullstate for all", ("server::fullstate_l=true", "server::fullstate_r=true"))):
        here, there = multiprocessing.Pipe()
        process = multiprocessing.get_context("spawn").Process(target=serve, args=(there, cycles, words))
        process.start()
        play(here.recv())
        spent, datagrams, size, cost = here.recv()
        process.join()
        print(
            f"{name}: {statistics.median(spent) * 1e4:.0f} us of CPU a cycle ({datagrams:.1f} datagrams, {size:.0f} bytes), "
            f"bare sends and receives {cost * 1e6:.0f} us; load {os.getloadavg()[0]:.1f}"
        )


if __name__ == "__main__":
    main()
