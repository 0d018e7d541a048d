"""A recorded session and replays of it with several seeds, message by message: what is chance in our server, and is it so in the real one?

If the real server is one more draw of what ours draws, then its recording agrees with our replays as well as they agree with each other.
"""

import collections
import re

import numpy as np
from session_replay import NUMBER, UNORDERED, SessionReplay, head, phase_of, windows

FRAME = re.compile(r'(?:\(show |"time":)(\d+)')


def _by_place(messages):
    """Messages by where they are looked for: window, head, number in it; frames by their clock, from the last one backwards."""
    frames, rest, placed = collections.defaultdict(list), [], {}
    for message in messages:
        if message.startswith(("(show", '{"show')):
            frames[int(FRAME.search(message)[1])].append(message)
        else:
            rest.append(message)
    for time, of in frames.items():
        placed |= {("show", time, n): message for n, message in enumerate(reversed(of)) if time or n == 0}
    for number, window in enumerate(windows(rest)):
        heads = collections.defaultdict(list)
        for message in window:
            heads[head(message)].append(message)
        for kind, of in heads.items():
            placed |= {(kind, number, n): message for n, message in enumerate(sorted(of) if kind in UNORDERED else of)}
    return placed


class Draws:
    """`path`: a session; `seeds`: how many replays; `mixed`: as for `SessionReplay`."""

    def __init__(self, path, seeds, mixed=False):
        phase = phase_of(path)
        self.replays = [SessionReplay(path, seed=seed, phase=phase, mixed=mixed).run() for seed in range(seeds)]
        self.texts = collections.defaultdict(list)
        """By head: for every place (recorded, ours with each seed), None where there is no message."""
        for who, mine in self.replays[0].of.items():
            sides = [_by_place(mine.wanted), *(_by_place(replay.of[who].got) for replay in self.replays)]
            for place in dict.fromkeys(place for side in sides for place in side):
                self.texts[place[0]].append(((who, *place[1:]), [side.get(place) for side in sides]))

    def agreement(self, kind, numbers=True):
        """(n + 1, n + 1) per cent of messages that are equal in two of the recording (first) and ours; `numbers` False: but for them."""
        ids = []
        for _, texts in self.texts[kind]:
            seen = {}
            keys = [text if numbers or text is None else NUMBER.sub("#", text) for text in texts]
            ids.append([seen.setdefault(key if key is not None else (n,), n) for n, key in enumerate(keys)])
        ids = np.array(ids)
        return np.array([[100.0 * np.mean(ids[:, a] == ids[:, b]) for b in range(ids.shape[1])] for a in range(ids.shape[1])])

    def compared(self, kind, numbers=True):
        """Mean agreement of the recording with our replays, and of each of them with the others (n,)."""
        found = self.agreement(kind, numbers)
        n = len(found) - 1
        return float(found[0, 1:].mean()), (found[1:, 1:].sum(axis=1) - 100.0) / (n - 1)

    def never_as_recorded(self, kind):
        """Places at which all our replays have one text and the recording another."""
        return [(place, texts[0], texts[1]) for place, texts in self.texts[kind] if len(set(texts[1:])) == 1 and texts[0] != texts[1]]
