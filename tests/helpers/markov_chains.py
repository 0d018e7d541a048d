"""Chains for tests: random ones with rational chances, solved by exact elimination."""

from fractions import Fraction

import numpy as np

from cprm_gym.architecture.analysis.markov.chain import MarkovChain


def random_rational_chain(seed, n=9):
    """(rows of fractions, outcomes): sparse, with self-loops, sometimes with states that lead to no outcome."""
    rng = np.random.default_rng(seed)
    ends = {"goal": [n - 1], "lost": [n - 2, n - 3]}
    rows = []
    for i in range(n):
        if i >= n - 3:
            rows.append({i: Fraction(1)})
            continue
        targets = rng.choice(n, size=int(rng.integers(1, 4)), replace=False)
        weights = rng.integers(1, 6, len(targets))
        if rng.random() < 0.2:
            targets = np.array([i, (i + 1) % (n - 3)])
            weights = np.array([3, 1])
        total = int(weights.sum())
        row = {}
        for t, w in zip(targets, weights):
            row[int(t)] = row.get(int(t), Fraction(0)) + Fraction(int(w), total)
        rows.append(row)
    return rows, ends


def as_chain(rows, ends, initial=0):
    return MarkovChain.from_rows([{j: float(p) for j, p in row.items()} for row in rows], ends, initial)


def exact_absorption(rows, ends):
    """(outcome -> fractions, never, time) by Gauss elimination over fractions; time counts until nothing but `never` is left."""
    n = len(rows)
    final = {s: name for name, states in ends.items() for s in states}
    reaches = set(final)
    while True:
        more = {i for i in range(n) if i not in reaches and any(j in reaches for j, p in rows[i].items() if p)}
        if not more:
            break
        reaches |= more
    open_ = [i for i in range(n) if i in reaches and i not in final]
    place = {i: a for a, i in enumerate(open_)}
    names = list(ends)
    right = []
    matrix = []
    for i in open_:
        line = [Fraction(0)] * len(open_)
        line[place[i]] += 1
        b = [Fraction(0)] * (len(names) + 2)
        b[-1] = Fraction(1)
        for j, p in rows[i].items():
            if j in place:
                line[place[j]] -= p
            elif j in final:
                b[names.index(final[j])] += p
            else:
                b[len(names)] += p
        matrix.append(line)
        right.append(b)
    m = len(open_)
    for k in range(m):
        pivot = next(r for r in range(k, m) if matrix[r][k] != 0)
        matrix[k], matrix[pivot] = matrix[pivot], matrix[k]
        right[k], right[pivot] = right[pivot], right[k]
        for r in range(m):
            if r != k and matrix[r][k] != 0:
                f = matrix[r][k] / matrix[k][k]
                matrix[r] = [a - f * b for a, b in zip(matrix[r], matrix[k])]
                right[r] = [a - f * b for a, b in zip(right[r], right[k])]
    out = [[Fraction(0)] * n for _ in range(len(names) + 2)]
    for i in range(n):
        if i in place:
            for c in range(len(names) + 2):
                out[c][i] = right[place[i]][c] / matrix[place[i]][place[i]]
        elif i in final:
            out[names.index(final[i])][i] = Fraction(1)
        else:
            out[len(names)][i] = Fraction(1)
    return dict(zip(names, out)), out[len(names)], out[-1]
