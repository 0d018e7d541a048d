"""Object places in the cycle: what an object place holds, and which object is selected."""

from __future__ import annotations

import numpy as np

from .....compilation import kernel_group
from ....expressions.kernels import run

inner = kernel_group(_nrt=False, no_cpython_wrapper=True)  # called by other kernels only


@inner
def hold(p, s, w, o, token):
    """Put object `token` (-1: none) into object place `o`, and refresh what is known of it."""
    s.held[w, o] = token
    s.row[w, p.objects[o].place] = 1.0 if token >= 0 else 0.0
    for i in range(p.objects[o].attr, p.objects[o].attr_end):
        s.row[w, p.attributes[i].slot] = s.data[w, p.attributes[i].column + token] if token >= 0 else np.nan


@inner
def select(p, s, x, w, z):
    """The candidate that selection `z` chooses: the one of its rank among those with a score; -1 for none."""
    chooser = p.selections[z]
    row = s.row[w]
    count = 0
    for j in range(chooser.count):
        x.score[j] = np.nan
        if s.data[w, chooser.present + j] == 0.0:
            continue
        for i in range(chooser.cand, chooser.cand_end):
            row[p.attributes[i].slot] = s.data[w, p.attributes[i].column + j]
        holds = 1.0
        if chooser.where >= 0:
            holds = run(p.code, p.constants, chooser.where, chooser.where_end, row, x.stack)
        if holds != holds or holds == 0.0:
            continue
        value = run(p.code, p.constants, chooser.best, chooser.best_end, row, x.stack)
        if value == value:
            x.score[j] = chooser.sign * value
            count += 1
    chosen = -1
    if count >= chooser.rank:
        for _ in range(chooser.rank):
            if chosen >= 0:
                x.score[chosen] = np.nan
            chosen = -1
            for j in range(chooser.count):
                if x.score[j] == x.score[j] and (chosen < 0 or x.score[j] > x.score[chosen]):
                    chosen = j
    return chosen
