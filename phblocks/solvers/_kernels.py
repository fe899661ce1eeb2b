"""Inner loops of the iteration as compiled code; imported only where numba is installed.

Plain loops over the arrays of :mod:`phblocks.solvers.collocation`, in its notation; the same sums, so the same results
to round-off. Compiled once and kept on disk by numba.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

Array = Any

#: Room for stages: a sum over all of them is one vector operation, whatever their number up to this.
LANES = 4
#: Room for stages: a sum over all of them is one vector operation, whatever their number up to this.
LANES = 4
#: How an iteration ended: at its goal, too slow for its factor, with an update larger than the last one (which is
#: undone), perhaps at the floor of round-off, at its limit, or at numbers that are not finite.
CONVERGED, SLOW, GREW, FLOOR, LIMIT, DIVERGED = range(6)


@njit(cache=True)
def multiply(data: Array, columns: Array, starts: Array, z: Array, out: Array) -> None:
    """Multiply rows of a sparse matrix by all stages."""
    for i in range(starts.size - 1):
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        for p in range(starts[i], starts[i + 1]):
            value, j = data[p], columns[p]
            a += value * z[j, 0]
            b += value * z[j, 1]
            c += value * z[j, 2]
            d += value * z[j, 3]
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = a, b, c, d


@njit(cache=True)
def find_features(angles: Array, turning: int, line: Array, z: Array, stages: int, phi: Array) -> None:
    """Evaluate the features at all stages: 1, cosines, sines, then both components of the directions of lines."""
    span, stretch, free, taut = line
    count = free.size
    phi[0] = 1.0
    for a in range(turning):
        for s in range(stages):
            phi[1 + a, s] = np.cos(angles[a, s])
            phi[1 + turning + a, s] = np.sin(angles[a, s])
    before = 1 + 2 * turning
    for d in range(count):
        for s in range(stages):
            x, y, length = 0.0, 0.0, free[d]
            for p in range(span[2][d], span[2][d + 1]):
                x += span[0][p] * z[span[1][p], s]
            for p in range(span[2][count + d], span[2][count + d + 1]):
                y += span[0][p] * z[span[1][p], s]
            for p in range(stretch[2][d], stretch[2][d + 1]):
                length += stretch[0][p] * z[stretch[1][p], s]
            if not taut[d]:
                length = np.hypot(x, y)
            cos, sin = np.cos(angles[turning + d, s]), np.sin(angles[turning + d, s])
            phi[before + d, s] = (cos * x + sin * y) / length
            phi[before + count + d, s] = (cos * y - sin * x) / length


@njit(cache=True)
def find_residual(z: Array, stages: int, matrices: Array, step: Array, sizes: Array, line: Array, work: Array) -> None:
    """Evaluate the residual of all stages into the last of the work arrays."""
    parts, summed, pair, feature = matrices
    alpha_known, kappa_given, momentum, known, rate_weights, turn_weights = step
    angles_count, pairs_count, turning = sizes
    linear, alpha, phi, terms, residual = work
    n = z.shape[0]
    multiply(parts[0], parts[1], parts[2], z, linear)
    for a in range(angles_count):
        for s in range(stages):
            total = alpha_known[a, s]
            for r in range(stages):
                total += linear[a, r] * turn_weights[r, s]
            alpha[a, s] = total
    find_features(alpha, turning, line, z, stages, phi)
    products = pair.shape[1]
    for q in range(products):
        i, j = pair[0, q], pair[1, q]
        for s in range(LANES):
            terms[q, s] = z[i, s] * z[j, s]
    for q in range(pairs_count):
        f = feature[q]
        for s in range(stages):
            terms[products + q, s] = (linear[angles_count + q, s] + kappa_given[q, s]) * phi[f, s]
    multiply(summed[0], summed[1], summed[2], terms, residual)
    inertia = angles_count + pairs_count
    for i in range(n):
        for s in range(stages):
            total = -linear[inertia + n + i, s] - known[i, s] - residual[i, s]
            for r in range(stages):
                total += (linear[inertia + i, r] - momentum[i]) * rate_weights[r, s]
            residual[i, s] = total


@njit(cache=True)
def substitute(band: Array, width: int, pivots: Array, b: Array) -> None:
    """Solve with the factor of LAPACK's ``gbtrf`` in place; ``band`` has the columns of LAPACK's array as rows."""
    n, diagonal = b.size, 2 * width
    for j in range(n):
        p = pivots[j]
        value = b[p]
        if p != j:
            b[p] = b[j]
            b[j] = value
        for i in range(1, min(width, n - 1 - j) + 1):
            b[j + i] -= value * band[j, diagonal + i]
    for j in range(n - 1, -1, -1):
        value = b[j] / band[j, diagonal]
        b[j] = value
        for i in range(max(0, j - diagonal), j):
            b[i] -= value * band[j, diagonal + i - j]


@njit(cache=True)
def correct(z: Array, stages: int, residual: Array, real: Array, paired: Array, change: Array) -> None:
    """Find the update of all stages, mode by mode, and apply it."""
    n = z.shape[0]
    change[:] = 0.0
    band, width, pivots, left, right, b = real
    if b.size:
        for i in range(n):
            total = 0.0
            for s in range(stages):
                total += left[s] * residual[i, s]
            b[i] = total
        substitute(band, width, pivots, b)
        for i in range(n):
            for s in range(stages):
                change[i, s] += right[s] * b[i]
    band_c, width, pivots_c, left_c, right_c, c = paired
    if c.size:
        for i in range(n):
            value = 0.0j
            for s in range(stages):
                value += left_c[s] * residual[i, s]
            c[i] = value
        substitute(band_c, width, pivots_c, c)
        for i in range(n):
            for s in range(stages):
                change[i, s] += (right_c[s] * c[i]).real
    for i in range(n):
        for s in range(stages):
            z[i, s] -= change[i, s]


@njit(cache=True)
def iterate(
    z: Array,
    stages: int,
    equation: Array,
    real: Array,
    paired: Array,
    change: Array,
    carrying: Array,
    progress: Array,
    options: Array,
) -> tuple[int, int]:
    """Iterate with one factor as ``ModifiedNewton`` does; return how it ended, and the number of iterations.

    ``progress`` is changed in place: change, that of unknowns with a rate, ratio, size, least size, age of the factor.
    """
    matrices, step, sizes, line, work = equation
    tolerance, slow, limit = options
    residual = work[4]
    n, iterations = z.shape[0], 0
    while iterations < limit:
        iterations += 1
        find_residual(z, stages, matrices, step, sizes, line, work)
        correct(z, stages, residual, real, paired, change)
        last, last_moved = progress[0], progress[1]
        whole, moved, size = 0.0, 0.0, 0.0
        for i in range(n):
            for s in range(stages):
                square = change[i, s] * change[i, s]
                whole += square
                if carrying[i]:
                    moved += square
                    size += z[i, s] * z[i, s]
        progress[0], progress[1] = np.sqrt(whole), np.sqrt(moved)
        progress[3] = max(progress[4], np.sqrt(size))
        if last > 0.0:
            progress[2] = max(progress[0] / last, progress[1] / last_moved if last_moved > 0.0 else 0.0)
        progress[5] += 1.0
        if not np.isfinite(progress[0]):
            return DIVERGED, iterations
        now, ratio, goal = progress[0], progress[2], tolerance * progress[3]
        if now == 0.0 or (ratio < 0.5 and now * ratio <= goal * (1.0 - ratio)):
            return CONVERGED, iterations
        if ratio > 0.5 and now <= 1e-8 * progress[3]:
            return FLOOR, iterations
        if progress[5] > 1.0 and 1.0 <= ratio < np.inf:
            z[:, :stages] += change
            return GREW, iterations
        if progress[5] > 1.0 and ratio > slow and now * ratio**3 > goal:
            return SLOW, iterations
    return LIMIT, iterations
