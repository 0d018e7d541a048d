"""A match in real time: ``python tests/benchmarks/bench_server_realtime.py [SECONDS]``.

22 trivial clients, both coaches and the trainer with open eyes, and monitors of versions 3, 4 and 5 in one process, the server in another:
cycles that began more than 10 ms late, the worst, the server's share of a core, its memory after a tenth of the match and at its end.
"""

import multiprocessing
import os
import resource
import select
import socket
import sys
import time

from cprm_gym.server import Server, Settings, Transport, run_in_real_time


def serve(pipe, seconds):
    """Play so many seconds; what it took."""
    server = Server(Settings.from_words(["server::coach_w_referee=true", "server::half_time=-1"]))
    with Transport(server, ports=(0, 0, 0)) as transport:
        pipe.send(transport.ports)
        begin, marks = time.monotonic(), []

        def each():
            now = time.monotonic() - begin
            if len(list(server.stadium.players())) == 22 and not marks:
                server.stadium.sim.trainer.start()
                server.stadium.world_changed()
                marks.append((now, time.process_time(), memory()))
            if len(marks) == 1 and now - marks[0][0] > seconds / 10:
                marks.append((now, time.process_time(), memory()))
            return not marks or now - marks[0][0] < seconds

        late = run_in_real_time(transport, each)
        spent, passed = time.process_time() - marks[0][1], time.monotonic() - begin - marks[0][0]
    pipe.send((late.cycles, late.late, late.worst, spent / passed, marks[1][2], memory(), transport.dropped))


def memory():
    """MiB of the process now."""
    with open("/proc/self/statm") as stream:
        return int(stream.read().split()[1]) * resource.getpagesize() / 2**20


def play(ports):
    """Everybody, until the server falls silent."""
    poll, sockets, players = select.epoll(), {}, set()

    def join(port, first, answers):
        sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        sock.settimeout(10.0)
        sock.sendto(first.encode() + b"\0", ("127.0.0.1", port))
        _, peer = sock.recvfrom(8192)
        sock.connect(peer)
        for text in answers:
            sock.send(text.encode() + b"\0")
        sock.setblocking(False)
        sockets[sock.fileno()] = sock
        poll.register(sock.fileno(), select.EPOLLIN)
        return sock.fileno()

    join(ports[1], "(init (version 19))", ["(eye on)", "(ear on)"])
    for version in (3, 4, 5):
        join(ports[0], f"(dispinit version {version})", [])
    for n in range(22):
        name, goalie = ("Left" if n < 11 else "Right"), " (goalie)" if n % 11 == 0 else ""
        players.add(join(ports[0], f"(init {name} (version 19){goalie})", [f"(move {-5 - n % 11} {3 * (n % 11) - 15})"]))
    for name in ("Left", "Right"):
        join(ports[2], f"(init {name} (version 19))", ["(eye on)"])
    silent = 0
    while silent < 3:
        ready = poll.poll(1)
        silent = 0 if ready else silent + 1
        for number, _ in ready:
            try:
                while True:
                    if sockets[number].recv(8192).startswith(b"(sense_body") and number in players:
                        sockets[number].send(b"(dash 60)(turn_neck 10)\0")
            except BlockingIOError:
                pass
            except ConnectionRefusedError:
                return


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 600.0
    here, there = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(target=serve, args=(there, seconds))
    process.start()
    there.close()  # so that a server that fails is noticed
    play(here.recv())  # the ports: everything is compiled
    cycles, late, worst, share, early, end, dropped = here.recv()
    process.join()
    print(
        f"{cycles} cycles, {late} ({100 * late / cycles:.1f} %) more than 10 ms late, the worst {worst * 1000:.0f} ms; "
        f"{100 * share:.1f} % of a core; memory {early:.1f} MiB after a tenth, {end:.1f} at the end; {dropped} datagrams dropped; "
        f"load {os.getloadavg()[0]:.1f}"
    )


if __name__ == "__main__":
    main()
