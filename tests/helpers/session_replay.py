"""A recorded UDP session of the real server, played against the core of ours.

The log is walked through in its order. A datagram to the server is given to the core; at a recorded answer, ``(think)`` or sense_body the
core goes on, cycle by cycle, until the same client has got as many messages of that head. So every command falls into the window of the
recording. Afterwards messages are compared by client, window and head. Texts that reach one client from several others within a window
(in the recordings by chance, in ours by number) are compared without regard to their order, frames of monitors by their clock.
"""

import base64
import collections
import functools
import gzip
import itertools
import json
import random
import re
import zlib

from cprm_gym.server import Port, Server, Settings

ANSWERS = ("think", "init", "ok", "error", "warning", "score", "reconnect")
UNORDERED = ("hear", "clang", "msg")
HEAD = re.compile(r'\(?\{?"?([a-z_]+)')
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[-+]?\d+)?")
PORTS = {6000: Port.PLAYER, 6001: Port.TRAINER, 6002: Port.COACH}
BINARY = "<binary>"
PHASES = 3
STEPS = re.compile(r'"time":0,"stime":(\d+)')


def head(text):
    match = HEAD.match(text)
    return match[1] if match else "?"


def windows(messages):
    out = [[]]
    for message in messages:
        out[-1].append(message)
        if message.startswith("(think"):
            out.append([])
    return out


def mixed_up(rows, lots):
    """The rows with those that wait for the server together in a random order of their clients."""
    out = []
    for _, together in itertools.groupby(enumerate(batches(rows)), lambda entry: entry[1]):
        batch = [rows[n] for n, _ in together]
        place = {client: lots.random() for client in dict.fromkeys(row["client"] for row in batch)}
        out += sorted(batch, key=lambda row: place[row["client"]]) if batch[0].get("to") == "server" else batch
    return out


def batches(rows):
    """A number for every row, the same for those that the server finds together: sent one after the other, nothing after a (done)."""
    number, done = 0, set()
    for before, row in itertools.pairwise([{}, *rows]):
        sent = row.get("to") == "server" and "port" not in row
        if not (sent and before.get("to") == "server" and "port" not in before) or row["client"] in done:
            number, done = number + 1, set()
        if "(done)" in row.get("text", ""):
            done.add(row["client"])
        yield number


class Recorded:
    """Messages of one client: those recorded, those of the core."""

    def __init__(self):
        self.client, self.wanted, self.got = None, [], []
        self.wants, self.has = collections.Counter(), collections.Counter()


class Agreement:
    """How many messages of one head there are, are equal, and are equal but for numbers; `unequal`: pairs of those that are not equal."""

    def __init__(self):
        self.total = self.equal = self.alike = 0
        self.first, self.unequal = None, []

    def add(self, wanted, got):
        self.total += 1
        self.equal += wanted == got
        if wanted != got:
            self.unequal.append((wanted, got))
        alike = wanted is not None and got is not None and NUMBER.sub("#", wanted) == NUMBER.sub("#", got)
        self.alike += alike
        if not alike and self.first is None:
            self.first = wanted, got

    def share(self):
        return round(100 * self.equal / self.total, 2), round(100 * self.alike / self.total, 2)


class SessionReplay:
    """`path`: a session; `watch`, if given, is called with this replay after every step; `seed`: of the core.

    `phase`: steps that were made before anybody came, of which the recordings do not tell; see messages come in a pattern of three steps.
    `mixed`: datagrams that wait together are read in a random order of their clients, as the real server does; else in that of the file.
    """

    def __init__(self, path, watch=None, seed=0, phase=0, mixed=False):
        with gzip.open(path, "rt") as stream:
            self.header = json.loads(stream.readline())
            self.rows = [json.loads(line) for line in stream]
        if mixed:
            self.rows = mixed_up(self.rows, random.Random(seed))
        self.server = Server(Settings.from_words([f"{k}={v}" for k, v in self.header["parameters_not_default"].items()]), seed)
        self.port = {client["name"]: PORTS[client["port"]] for client in self.header["clients"]}
        self.of = collections.defaultdict(Recorded)
        self.toss_as_recorded()
        self.in_vain, self.timeouts, self.open, self.watch = [], 0, False, watch
        for _ in range(phase):
            self.server.step()
            self.server.look_again()
            self.server.look_late()
            self.take()

    def toss_as_recorded(self):
        """The goal of a shoot-out and who begins it are drawn by lot: as in the recording."""
        for name, pattern, left in (("forced_pen_side", "penalty_onfield", 1), ("forced_pen_taker", "penalty_setup", -1)):
            said = next((match for row in self.rows if (match := re.search(rf"referee {pattern}_([lr])", row.get("text", "")))), None)
            if said:  # who begins is the other one before the first kick is set up
                self.server.stadium.world[name] = left if said[1] == "l" else -left

    def take(self):
        """Sort what the core sent."""
        for source, address, data in self.server.take_outbox():
            compressed = data[:1] == b"\x78"
            data = zlib.decompressobj().decompress(data) if compressed else data
            text = BINARY if data[:1] == b"\0" else data.rstrip(b"\0").decode("latin-1")
            mine = self.of[address]
            mine.got.append(text)
            mine.has[head(text)] += 1
            if not isinstance(source, Port):
                mine.client = source

    def go_on(self):
        """Close the window that is open, because all are done or their time is up, and run to the next one."""
        server = self.server
        if self.open:
            complete = server.is_complete
            self.timeouts += not complete
            server.close_window(complete)
            server.look_late()
        server.step()
        self.take()
        if self.watch is not None:
            self.watch(self)
        if not server.over:
            server.look_again()
            server.think()
        self.take()
        self.open = True

    def run(self):
        self.go_on()
        for number, row in enumerate(self.rows):
            mine = self.of[row["client"]]
            if "event" in row:
                if mine.client is not None:
                    self.server.lose(mine.client)
            elif row["to"] == "server":
                self.give(number, row, mine)
            else:
                self.expect(row, mine)
        return self

    def give(self, number, row, mine):
        """A datagram to the server; a window that was over before it came is closed first."""
        server = self.server
        if self.open and server.awaited() and server.is_complete and self.think_is_next(number):
            self.go_on()
        data = row["text"].encode("latin-1") + (b"\0" if row.get("nul") else b"") if "text" in row else base64.b64decode(row["b64"])
        if row.get("port") == "init" or mine.client is None:
            server.receive(self.port[row["client"]], row["client"], data)
        else:
            server.receive_from(mine.client, data)
        self.take()

    def think_is_next(self, number):
        for row in self.rows[number + 1 :]:
            if row["to"] == "client":
                kind = head(row.get("text", row.get("inflated")) or "")
                if kind in ANSWERS:
                    mine = self.of[row["client"]]
                    return kind == "think" and mine.has["think"] <= mine.wants["think"]
        return False

    def expect(self, row, mine):
        """A datagram to a client."""
        text = row.get("text", row.get("inflated"))
        if text is None:
            mine.wanted.append(BINARY)
            return
        mine.wanted.append(text)
        kind = head(text)
        mine.wants[kind] += 1
        patience = 3 if kind in ANSWERS else 1 if kind == "sense_body" else 0
        while mine.has[kind] < mine.wants[kind] and patience and not self.server.over:
            self.go_on()
            patience -= 1
        if kind in ANSWERS and mine.has[kind] < mine.wants[kind]:
            self.in_vain.append((row["n"], row["client"], text[:100]))
            mine.has[kind] = mine.wants[kind]

    def seen_in_time(self):
        """Share of the windows with see messages in which as many came as recorded, at the same times."""
        agree = []
        for mine in self.of.values():
            wanted, got = (
                [[m.split(" ", 2)[1] for m in w if m.startswith("(see ")] for w in windows(of)] for of in (mine.wanted, mine.got)
            )
            agree += [times == (got[n] if n < len(got) else []) for n, times in enumerate(wanted) if times]
        return sum(agree) / max(len(agree), 1)

    def agreements(self):
        """`Agreement` by head."""
        found = collections.defaultdict(Agreement)
        for mine in self.of.values():
            if any(message.startswith(("(show", '{"show')) for message in mine.wanted):
                _compare_frames(found, mine)
                mine_wanted, mine_got = (
                    [m for m in messages if not m.startswith(("(show", '{"show'))] for messages in (mine.wanted, mine.got)
                )
            else:
                mine_wanted, mine_got = mine.wanted, mine.got
            both = windows(mine_wanted), windows(mine_got)
            for n in range(len(both[0])):
                _compare_window(found, both[0][n], both[1][n] if n < len(both[1]) else [])
        return dict(found)


@functools.cache
def phase_of(path):
    """The phase in which most see messages come in the window and at the time in which they were recorded.

    Where a monitor is told how many steps there were before the kick-off, as many are made.
    """
    replays = [SessionReplay(path, phase=phase).run() for phase in range(PHASES)]
    phase = max(range(PHASES), key=lambda phase: replays[phase].seen_in_time())
    for mine in replays[phase].of.values():
        told = [[int(match[1]) for match in map(STEPS.search, of) if match] for of in (mine.wanted, mine.got)]
        if all(told):
            return phase + max(max(told[0]) - max(told[1]), 0)
    return phase


def _compare_window(found, wanted, got):
    sides = []
    for messages in (wanted, got):
        by_head = collections.defaultdict(list)
        for message in messages:
            by_head[head(message)].append(message)
        sides.append(by_head)
    for kind in set(sides[0]) | set(sides[1]):
        a, b = (sorted(side[kind]) if kind in UNORDERED else side[kind] for side in sides)
        for n in range(max(len(a), len(b))):
            found[kind].add(a[n] if n < len(a) else None, b[n] if n < len(b) else None)


def _compare_frames(found, mine):
    """Frames of a monitor by clock, of one clock from the last one backwards: how many wait for the first player is chance."""
    sides = []
    for messages in (mine.wanted, mine.got):
        by_time = collections.defaultdict(list)
        for message in messages:
            if message.startswith(("(show", '{"show')):
                by_time[int(re.search(r'(?:\(show |"time":)(\d+)', message)[1])].append(message)
        sides.append(by_time)
    last = max(sides[0], default=0)
    for time, wanted in sides[0].items():
        got = sides[1].get(time, [])
        if time in (0, last):
            wanted = wanted[-len(got) :] if got else wanted
        for n in range(1, len(wanted) + 1):
            found["show"].add(wanted[-n], got[-n] if n <= len(got) else None)
