"""Elimination without subtractions: every entry comes out with a small relative error, however small it is."""

from __future__ import annotations

from ....compilation import kernel_group

kernel = kernel_group()


@kernel
def eliminate(dense, known, leave, m):
    """Solve x_i = sum_j a_ij x_j + b_i where the chance of staying is what is left of a row, in place.

    Parameters
    ----------
    dense : (M, M)
        a_ij of the first m states; the diagonal is not used.
    known : (M, K)
        b, becomes x.
    leave : (M,)
        Chance of leaving the m states; a row's pivot is it and the other a_ij, so none is found by subtraction.

    References
    ----------
    W. K. Grassmann, M. I. Taksar, D. P. Heyman (1985), Operations Research 33:1107-1116;
    C. A. O'Cinneide (1993), Numerische Mathematik 65:109-120 (entrywise accuracy).
    """
    for k in range(m - 1, 0, -1):
        pivot = leave[k]
        for j in range(k):
            pivot += dense[k, j]
        dense[k, k] = pivot
        for i in range(k):
            a = dense[i, k]
            if a != 0.0:
                f = a / pivot
                for j in range(k):
                    dense[i, j] += f * dense[k, j]
                leave[i] += f * leave[k]
                for c in range(known.shape[1]):
                    known[i, c] += f * known[k, c]
    for c in range(known.shape[1]):
        known[0, c] /= leave[0]
    for k in range(1, m):
        for j in range(k):
            a = dense[k, j]
            if a != 0.0:
                for c in range(known.shape[1]):
                    known[k, c] += a * known[j, c]
        for c in range(known.shape[1]):
            known[k, c] /= dense[k, k]
