"""How worlds begin anew, compiled: the record of a beginning, with the streams of the world that goes on."""

from __future__ import annotations

from . import kernel


@kernel
def restart(worlds, rows, start, chosen):
    """Put the chosen worlds into a state; their random streams go on, that of resets with its next call.

    worlds : (W,) WORLD; rows : the same as bytes, which are copied much faster than fields, (W, n); start : (n,) bytes of the state;
    chosen : (n,) int64
    """
    for n in chosen:
        w = worlds[n]
        steps, draws = w.steps, w.draws
        physics, sensors, referee, resets = w.key[0], w.key[1], w.key[2], w.key[3]
        rows[n, :] = start
        w.steps, w.draws = steps, draws + 1
        w.key[0], w.key[1], w.key[2], w.key[3] = physics, sensors, referee, resets
