"""A whole step as compiled code; imported only where numba is installed (the extra ``fast``).

Plain loops over the arrays of :mod:`phblocks.solvers.collocation`, in its notation: the same sums, so the same results
to round-off. Numba compiles them once and keeps that on disk. Values at the stages lie side by side in *lanes* (1, 2 or
4 of them, the last one idle with three stages), so that a sum over stages is one vector operation. Complex factors are
kept as two real arrays for the same reason.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

Array = Any

#: Division as in NumPy, no exceptions: numbers that are not finite end the iteration.
compiled = njit(cache=True, error_model="numpy")
#: An entry on the diagonal that is not smaller than this times the largest below it stays the pivot: fewer exchanges
#: keep the factor narrow.
THRESHOLD = 0.1
#: How an iteration ended.
CONVERGED, DIVERGED, SINGULAR, LIMIT = range(4)


@compiled
def multiply(matrix: Array, first: int, last: int, z: Array, out: Array) -> None:
    """Multiply rows of a sparse matrix, from the first to before the last, by all lanes."""
    data, columns, starts = matrix
    if z.shape[1] == 1:
        for i in range(first, last):
            total = 0.0
            for p in range(starts[i], starts[i + 1]):
                total += data[p] * z[columns[p], 0]
            out[i - first, 0] = total
    elif z.shape[1] == 2:
        for i in range(first, last):
            a, b = 0.0, 0.0
            for p in range(starts[i], starts[i + 1]):
                value, j = data[p], columns[p]
                a += value * z[j, 0]
                b += value * z[j, 1]
            out[i - first, 0], out[i - first, 1] = a, b
    else:
        for i in range(first, last):
            a, b, c, d = 0.0, 0.0, 0.0, 0.0
            for p in range(starts[i], starts[i + 1]):
                value, j = data[p], columns[p]
                a += value * z[j, 0]
                b += value * z[j, 1]
                c += value * z[j, 2]
                d += value * z[j, 3]
            out[i - first, 0], out[i - first, 1], out[i - first, 2], out[i - first, 3] = a, b, c, d


@compiled
def find_features(angles: Array, turning: int, line: Array, z: Array, stages: int, phi: Array) -> None:
    """Evaluate the features at all stages: 1, cosines, sines, then both components of the directions of lines."""
    count = line[2].size
    for s in range(stages):
        phi[0, s] = 1.0
    for a in range(turning):
        for s in range(stages):
            phi[1 + a, s] = np.cos(angles[a, s])
            phi[1 + turning + a, s] = np.sin(angles[a, s])
    before = 1 + 2 * turning
    for d in range(count):
        for s in range(stages):
            x, y, length = find_line(d, line, z, s)
            cos, sin = np.cos(angles[turning + d, s]), np.sin(angles[turning + d, s])
            phi[before + d, s] = (cos * x + sin * y) / length
            phi[before + count + d, s] = (cos * y - sin * x) / length


@compiled
def find_line(d: int, line: Array, z: Array, s: int) -> tuple[float, float, float]:
    """Evaluate both components of the span of a direction, and its length."""
    span, stretch, free, taut = line
    count = free.size
    x, y, length = 0.0, 0.0, free[d]
    for p in range(span[2][d], span[2][d + 1]):
        x += span[0][p] * z[span[1][p], s]
    for p in range(span[2][count + d], span[2][count + d + 1]):
        y += span[0][p] * z[span[1][p], s]
    for p in range(stretch[2][d], stretch[2][d + 1]):
        length += stretch[0][p] * z[stretch[1][p], s]
    return x, y, length if taut[d] else np.hypot(x, y)


@compiled
def find_derivatives(angles: Array, turning: int, line: Array, z: Array, slope: Array, by_line: Array) -> None:
    """Evaluate the derivatives of the features in lane 0 by their angle, and by span and length of their line."""
    count = line[2].size
    for a in range(turning):
        slope[1 + a] = -np.sin(angles[a, 0])
        slope[1 + turning + a] = np.cos(angles[a, 0])
    first = 1 + 2 * turning
    second = first + count
    for d in range(count):
        x, y, length = find_line(d, line, z, 0)
        cos, sin = np.cos(angles[turning + d, 0]), np.sin(angles[turning + d, 0])
        along, across = (cos * x + sin * y) / length, (cos * y - sin * x) / length
        slope[first + d], slope[second + d] = across, -along
        loose = 0.0 if line[3][d] else 1.0
        by_line[0, first + d] = (cos - loose * along * x / length) / length
        by_line[0, second + d] = (-sin - loose * across * x / length) / length
        by_line[1, first + d] = (sin - loose * along * y / length) / length
        by_line[1, second + d] = (cos - loose * across * y / length) / length
        by_line[2, first + d] = -along / length
        by_line[2, second + d] = -across / length


@compiled
def find_residual(z: Array, dt: float, equation: Array, method: Array, step: Array, work: Array) -> None:
    """Evaluate the residual of all stages into the last of the work arrays."""
    parts, summed, pair, feature, sizes, line, _ = equation
    angles, turning = sizes
    A, inverse = method[0], method[1]
    alpha_known, kappa_given, momentum, known = step
    linear, alpha, kappa, phi, terms, residual = work
    n, lanes, stages = z.shape[0], z.shape[1], A.shape[0]
    pairs, products = feature.size, pair.shape[1]
    multiply(parts, 0, parts[2].size - 1, z, linear)
    for a in range(angles):
        for s in range(stages):
            total = alpha_known[a, s]
            for r in range(stages):
                total += linear[a, r] * dt * A[s, r]
            alpha[a, s] = total
    find_features(alpha, turning, line, z, stages, phi)
    for q in range(products):
        i, j = pair[0, q], pair[1, q]
        for s in range(lanes):
            terms[q, s] = z[i, s] * z[j, s]
    for q in range(pairs):
        f = feature[q]
        for s in range(stages):
            kappa[q, s] = linear[angles + q, s] + kappa_given[q, s]
            terms[products + q, s] = kappa[q, s] * phi[f, s]
    multiply(summed, 0, n, terms, residual)
    inertia = angles + pairs
    forced = inertia + n
    for i in range(n):
        for s in range(stages):
            total = -linear[forced + i, s] - known[i, s] - residual[i, s]
            for r in range(stages):
                total += (linear[inertia + i, r] - momentum[i, 0]) * inverse[s, r] / dt
            residual[i, s] = total


@compiled
def find_noise(z: Array, dt: float, equation: Array, method: Array, step: Array, work: Array) -> float:
    """Estimate the round-off in the residual at the last evaluation: all products without their signs."""
    parts, summed, pair, feature, sizes, _, _ = equation
    inverse, kappa, known = method[1], work[2], step[3]
    n, stages, products = z.shape[0], inverse.shape[0], pair.shape[1]
    data, columns, starts = parts
    data_s, columns_s, starts_s = summed
    inertia = sizes[0] + feature.size
    whole = 0.0
    momentum = np.empty(stages)
    for i in range(n):
        momentum[:] = 0.0
        for p in range(starts[inertia + i], starts[inertia + i + 1]):
            for s in range(stages):
                momentum[s] += abs(data[p] * z[columns[p], s])
        for s in range(stages):
            total = abs(known[i, s])
            for p in range(starts[inertia + n + i], starts[inertia + n + i + 1]):
                total += abs(data[p] * z[columns[p], s])
            for p in range(starts_s[i], starts_s[i + 1]):
                q = columns_s[p]
                term = z[pair[0, q], s] * z[pair[1, q], s] if q < products else kappa[q - products, s]
                total += abs(data_s[p] * term)
            for r in range(stages):
                total += momentum[r] * abs(inverse[s, r]) / dt
            whole += total * total
    return float(np.finfo(np.float64).eps * np.sqrt(whole))


@compiled
def find_matrices(z: Array, equation: Array, method: Array, work: Array, room: Array) -> None:
    """Evaluate what the stiffness consists of at the mean of the stages: what acts at once, and by turning."""
    _, _, _, feature, sizes, line, jacobian = equation
    by_mean, by_angle, rest = jacobian[:3]
    b = method[2]
    _, alpha, kappa, _, _, _ = work
    mean, mean_alpha, phi, slope, by_line, means, turns, direct, turned = room
    n, stages, features = z.shape[0], b.size, slope.size
    pairs = feature.size
    for i in range(n):
        total = 0.0
        for s in range(stages):
            total += b[s] * z[i, s]
        mean[i, 0] = means[i, 0] = total
    for a in range(sizes[0]):
        total = 0.0
        for s in range(stages):
            total += b[s] * alpha[a, s]
        mean_alpha[a, 0] = total
    find_features(mean_alpha, sizes[1], line, mean, 1, phi)
    find_derivatives(mean_alpha, sizes[1], line, mean, slope, by_line)
    for f in range(features):
        means[n + f, 0] = phi[f, 0]
    for q in range(pairs):
        total = 0.0
        for s in range(stages):
            total += b[s] * kappa[q, s]
        turns[q, 0] = total * slope[feature[q]]
        if line[2].size:
            for k in range(3):
                means[n + features + k * pairs + q, 0] = total * by_line[k, feature[q]]
    multiply(by_mean, 0, rest.size, means, direct)
    multiply(by_angle, 0, rest.size, turns, turned)


@compiled
def factorise_real(tau: float, jacobian: Array, direct: Array, turned: Array, factor: Array) -> bool:
    """Factorise ``mass / tau - direct - tau turned``."""
    _, _, rest, mass, spot = jacobian
    flat = factor[0].ravel()
    flat[:] = 0.0
    for p in range(mass.size):
        flat[spot[p]] = mass[p] / tau - rest[p] - direct[p, 0] - tau * turned[p, 0]
    return eliminate_real(factor)


@compiled
def eliminate_real(factor: Array) -> bool:
    """Factorise what is in the band with partial pivots; its columns are rows of ``band``. Pivots are inverted."""
    band, pivots, width = factor[0], factor[2], factor[3]
    flat, column = band.ravel(), np.empty(width + 1)
    (n, height), reach = band.shape, 0
    for j in range(n):
        at = j * height + 2 * width  # the diagonal; in the next column, the same row is one place nearer
        most, big, chosen = min(width, n - 1 - j), abs(flat[at]), 0
        for i in range(1, most + 1):
            if abs(flat[at + i]) > big:
                big, chosen = abs(flat[at + i]), i
        if not 0.0 < big < np.inf:
            return False
        if abs(flat[at]) >= THRESHOLD * big:
            chosen = 0
        pivots[j] = j + chosen
        reach = max(reach, min(j + width + chosen, n - 1))
        if chosen:
            here = at
            for _ in range(j, reach + 1):
                held = flat[here]
                flat[here] = flat[here + chosen]
                flat[here + chosen] = held
                here += height - 1
        flat[at] = inverse = 1.0 / flat[at]  # which nothing but the substitution looks at again
        for i in range(1, most + 1):
            column[i] = flat[at + i] = flat[at + i] * inverse
        here = at
        for _ in range(j + 1, reach + 1):
            here += height - 1
            value = flat[here]
            if value != 0.0:
                for i in range(1, most + 1):
                    flat[here + i] -= value * column[i]
    return True


@compiled
def factorise_complex(tau: complex, jacobian: Array, direct: Array, turned: Array, factor: Array) -> bool:
    """The same of a complex matrix, real and imaginary parts apart."""
    _, _, rest, mass, spot = jacobian
    re, im = factor[0].ravel(), factor[1].ravel()
    re[:] = 0.0
    im[:] = 0.0
    rate = 1.0 / tau
    for p in range(mass.size):
        re[spot[p]] = mass[p] * rate.real - rest[p] - direct[p, 0] - tau.real * turned[p, 0]
        im[spot[p]] = mass[p] * rate.imag - tau.imag * turned[p, 0]
    return eliminate_complex(factor)


@compiled
def eliminate_complex(factor: Array) -> bool:
    """Factorise what is in both bands."""
    band_re, band_im, pivots, width = factor
    re, im = band_re.ravel(), band_im.ravel()
    column_re, column_im = np.empty(width + 1), np.empty(width + 1)
    (n, height), reach = band_re.shape, 0
    for j in range(n):
        at = j * height + 2 * width
        most, big, chosen = min(width, n - 1 - j), abs(re[at]) + abs(im[at]), 0
        for i in range(1, most + 1):
            size = abs(re[at + i]) + abs(im[at + i])
            if size > big:
                big, chosen = size, i
        if not 0.0 < big < np.inf:
            return False
        if abs(re[at]) + abs(im[at]) >= THRESHOLD * big:
            chosen = 0
        pivots[j] = j + chosen
        reach = max(reach, min(j + width + chosen, n - 1))
        if chosen:
            here = at
            for _ in range(j, reach + 1):
                there = here + chosen
                held_re, held_im = re[here], im[here]
                re[here], im[here] = re[there], im[there]
                re[there], im[there] = held_re, held_im
                here += height - 1
        inverse = 1.0 / complex(re[at], im[at])
        re[at], im[at] = a, b = inverse.real, inverse.imag
        for i in range(1, most + 1):
            x, y = re[at + i], im[at + i]
            column_re[i] = re[at + i] = a * x - b * y
            column_im[i] = im[at + i] = a * y + b * x
        here = at
        for _ in range(j + 1, reach + 1):
            here += height - 1
            a, b = re[here], im[here]
            if a != 0.0 or b != 0.0:
                for i in range(1, most + 1):
                    re[here + i] -= a * column_re[i] - b * column_im[i]
                    im[here + i] -= a * column_im[i] + b * column_re[i]
    return True


@compiled
def substitute_real(factor: Array, b: Array) -> None:
    """Solve with a factor in place."""
    band, pivots, width = factor[0], factor[2], factor[3]
    n, d = b.size, 2 * width
    for j in range(n):
        p, most = pivots[j], min(width, n - 1 - j)
        value = b[p]
        if p != j:
            b[p] = b[j]
            b[j] = value
        column, target = band[j, d + 1 : d + most + 1], b[j + 1 : j + most + 1]
        for i in range(most):
            target[i] -= value * column[i]
    for j in range(n - 1, -1, -1):
        value = b[j] * band[j, d]
        b[j] = value
        most = min(d, j)
        column, target = band[j, d - most : d], b[j - most : j]
        for i in range(most):
            target[i] -= value * column[i]


@compiled
def substitute_complex(factor: Array, x: Array, y: Array) -> None:
    """Solve with a complex factor in place: x is the real part of the right-hand side, y the imaginary one."""
    re, im, pivots, width = factor
    n, d = x.size, 2 * width
    for j in range(n):
        p, most = pivots[j], min(width, n - 1 - j)
        a, b = x[p], y[p]
        if p != j:
            x[p], y[p] = x[j], y[j]
            x[j], y[j] = a, b
        column_re, column_im = re[j, d + 1 : d + most + 1], im[j, d + 1 : d + most + 1]
        target_re, target_im = x[j + 1 : j + most + 1], y[j + 1 : j + most + 1]
        for i in range(most):
            target_re[i] -= a * column_re[i] - b * column_im[i]
            target_im[i] -= a * column_im[i] + b * column_re[i]
    for j in range(n - 1, -1, -1):
        value = complex(x[j], y[j]) * complex(re[j, d], im[j, d])
        a, b = value.real, value.imag
        x[j], y[j] = a, b
        most = min(d, j)
        column_re, column_im = re[j, d - most : d], im[j, d - most : d]
        target_re, target_im = x[j - most : j], y[j - most : j]
        for i in range(most):
            target_re[i] -= a * column_re[i] - b * column_im[i]
            target_im[i] -= a * column_im[i] + b * column_re[i]


@compiled
def find_update(residual: Array, method: Array, real: Array, paired: Array, sides: Array, change: Array) -> None:
    """Find the update of all stages, mode by mode."""
    _, left, right, _, left_c, right_c = method[3]
    b, x, y = sides
    n, stages = b.size, left.size
    change[:] = 0.0
    if real[0].size:
        for i in range(n):
            total = 0.0
            for s in range(stages):
                total += left[s] * residual[i, s]
            b[i] = total
        substitute_real(real, b)
        for i in range(n):
            for s in range(stages):
                change[i, s] += right[s] * b[i]
    if paired[0].size:
        for i in range(n):
            value = 0.0j
            for s in range(stages):
                value += left_c[s] * residual[i, s]
            x[i], y[i] = value.real, value.imag
        substitute_complex(paired, x, y)
        for i in range(n):
            for s in range(stages):
                change[i, s] += right_c[s].real * x[i] - right_c[s].imag * y[i]


@compiled
def begin(x: Array, theta: Array, driven: Array, equation: Array, turn: Array, known: Array, step: Array) -> None:
    """Fix the data of a step: orientations without what the stages turn, and E x."""
    alpha_known, _, momentum, _ = step
    rows, reference = turn[:2]
    for t in range(theta.size):
        for s in range(known.shape[1]):
            known[t, s] = theta[t] + driven[t, s]
    multiply(rows, 0, reference.size, known, alpha_known)
    for a in range(reference.size):
        for s in range(known.shape[1]):
            alpha_known[a, s] += reference[a]
    inertia = equation[4][0] + equation[3].size
    data, columns, starts = equation[0]
    for i in range(x.size):
        total = 0.0
        for p in range(starts[inertia + i], starts[inertia + i + 1]):
            total += data[p] * x[columns[p]]
        momentum[i, 0] = total


@compiled
def measure(z: Array, dt: float, impulsive: Array) -> float:
    """Measure unknowns as ``StageEquation`` does."""
    total = 0.0
    for i in range(z.shape[0]):
        unit = dt * dt if impulsive[i] else 1.0
        for s in range(z.shape[1]):
            total += unit * z[i, s] * z[i, s]
    return float(np.sqrt(total))


@compiled
def solve(
    z: Array,
    guess: Array,
    least: float,
    kept: bool,
    dt: float,
    equation: Array,
    method: Array,
    step: Array,
    work: Array,
    room: Array,
    factors: Array,
    kinds: Array,
    options: Array,
) -> tuple[int, int, float]:
    """Iterate as ``ModifiedNewton`` does; return how it ended, the number of iterations, and what is left."""
    tolerance, slow, far, floor, limit = options
    carrying, impulsive = kinds
    real, paired, sides, change = factors
    _, _, _, modes = method
    jacobian, residual = equation[6], work[5]
    n, stages = z.shape[0], change.shape[1]
    for i in range(n):
        for s in range(stages):
            z[i, s] = guess[i, s]
    start = measure(guess, dt, impulsive)
    age, now, moved, ratio = 1 if kept else 0, 0.0, 0.0, np.inf
    for iteration in range(1, int(limit) + 1):
        find_residual(z, dt, equation, method, step, work)
        if age == 0:
            find_matrices(z, equation, method, work, room)
            if real[0].size and not factorise_real(modes[0] * dt, jacobian, room[7], room[8], real):
                return SINGULAR, iteration, np.inf
            if paired[0].size and not factorise_complex(modes[3] * dt, jacobian, room[7], room[8], paired):
                return SINGULAR, iteration, np.inf
        age += 1
        find_update(residual, method, real, paired, sides, change)
        last, last_moved, squares, moves, size = now, moved, 0.0, 0.0, 0.0
        for i in range(n):
            unit = dt * dt if impulsive[i] else 1.0
            for s in range(stages):
                z[i, s] -= change[i, s]
                square = change[i, s] * change[i, s]
                squares += unit * square
                size += unit * z[i, s] * z[i, s]
                if carrying[i]:
                    moves += square
        now, moved, size = np.sqrt(squares), np.sqrt(moves), max(least, np.sqrt(size))
        if last > 0.0:
            ratio = max(now / last, moved / last_moved if last_moved > 0.0 else 0.0)
        falling, finite = ratio < 1.0 or ratio == np.inf, np.isfinite(now)
        if kept and not (finite and falling and now <= far * start):
            for i in range(n):
                for s in range(stages):
                    z[i, s] = guess[i, s]
            age, now, moved, ratio, kept = 0, 0.0, 0.0, np.inf, False  # an old factor proves nothing
            continue
        if not finite:
            return DIVERGED, iteration, np.inf
        goal = tolerance * size
        if now == 0.0 or (ratio < 0.5 and now * ratio <= goal * (1.0 - ratio)):
            return CONVERGED, iteration, now * ratio / size if now > 0.0 and size > 0.0 else 0.0
        if ratio > 0.5 and now <= floor * size:
            squares = 0.0
            for i in range(n):
                for s in range(stages):
                    squares += residual[i, s] * residual[i, s]
            if np.sqrt(squares) <= 1e3 * find_noise(z, dt, equation, method, step, work):
                return CONVERGED, iteration, now / size if size > 0.0 else 0.0
        if kept and iteration == 1:
            age = 0
        elif age > 1 and not falling:
            for i in range(n):
                for s in range(stages):
                    z[i, s] += change[i, s]
            age = 0
        elif ratio > slow and age > 1 and now * ratio**3 > goal:
            age = 0
        kept = kept and iteration == 1
    return LIMIT, int(limit), np.inf


@compiled
def finish(
    x: Array,
    theta: Array,
    z: Array,
    dt: float,
    driven: Array,
    method: Array,
    turn: Array,
    algebraic: Array,
    out: Array,
) -> None:
    """Continue to the end of the step: states, orientations, and both at the stages."""
    end, theta_end, stages_z, stages_theta, spin = out
    A, _, b, _ = method
    weights, extrapolation, rates = turn[2:]
    n, stages = z.shape[0], b.size
    for i in range(n):
        total = x[i]
        for s in range(stages):
            stages_z[s, i] = z[i, s]
            total += weights[s] * (z[i, s] - x[i])
        end[i] = total
    for i in algebraic:
        total = 0.0
        for s in range(stages):
            total += extrapolation[s] * z[i, s]
        end[i] = total
    multiply(rates, 0, theta.size, z, spin)
    for t in range(theta.size):
        total = theta[t]
        for s in range(stages):
            total += dt * b[s] * (spin[t, s] + driven[t, s])
            at = theta[t]
            for r in range(stages):
                at += dt * A[s, r] * (spin[t, r] + driven[t, r])
            stages_theta[s, t] = at
        theta_end[t] = total


@compiled
def drive(u: Array, dt: float, inputs: Array, A: Array, given: Array, data: Array, free: Array, driven: Array) -> None:
    """Take in the inputs at the stages of a step."""
    kappa, by_kappa, force, rates = inputs
    stages, turning = u.shape[0], free.shape[0]
    for k in range(u.shape[1]):
        for s in range(stages):
            given[k, s] = u[s, k]
    multiply(by_kappa, 0, kappa.size, given, data[1])
    for q in range(kappa.size):
        for s in range(stages):
            data[1][q, s] += kappa[q]
    multiply(force, 0, data[3].shape[0], given, data[3])
    multiply(rates, 0, turning, given, free)
    for t in range(turning):
        for s in range(stages):
            total = 0.0
            for r in range(stages):
                total += free[t, r] * (dt * A[s, r])
            driven[t, s] = total


@compiled
def march(
    x: Array,
    theta: Array,
    dt: float,
    u: Array,
    guess: Array,
    before: Array,
    limits: Array,
    kept: bool,
    predict: bool,
    equation: Array,
    method: Array,
    turn: Array,
    inputs: Array,
    data: Array,
    buffers: Array,
    work: Array,
    room: Array,
    factors: Array,
    kinds: Array,
    options: Array,
    algebraic: Array,
    out: Array,
) -> tuple[int, int]:
    """Take steps of one length; return how many there were, and how the last iteration ended.

    The first one is tried from all guesses, shape (guesses, n, lanes), the last of which is the start of the step; the
    others from the extrapolation of the two before, where ``predict`` says so. ``before`` is the stage of the step
    before the first, and ``limits`` are its length (0 if there is none), the furthest extrapolation, and how large a
    state may be to go on.
    """
    known, free, driven, spin, given, z, start = buffers
    ends, thetas, stages_z, stages_theta, iterations, left = out
    dt_before, farthest, most = limits
    n, stages, how = x.size, u.shape[1], CONVERGED
    for k in range(u.shape[0]):
        here, turned = (ends[k - 1], thetas[k - 1]) if k else (x, theta)
        if u.shape[2]:
            drive(u[k], dt, inputs, method[0], given, data, free, driven)
        begin(here, turned, driven, equation, turn, known, data)
        least = np.sqrt(float(stages)) * measure(here.reshape((n, 1)), dt, kinds[1])
        if k and not least < most:
            return k, CONVERGED
        ratio = 1.0 if k > 1 else 2.0 * dt / (dt + dt_before)
        foreseen = predict and (k > 1 or (k == 1 and dt_before > 0.0 and ratio <= farthest))
        tries = guess.shape[0] if k == 0 else 2 if foreseen else 1
        for attempt in range(tries):
            for i in range(n):
                for s in range(stages):
                    start[i, s] = guess[attempt, i, s] if k == 0 else here[i]
            if foreseen and attempt == 0:
                for i in range(n):
                    earlier = stages_z[k - 2, 0, i] if k > 1 else before[i]
                    start[i, 0] = (1.0 + ratio) * stages_z[k - 1, 0, i] - ratio * earlier
            how, count, rest = solve(
                z, start, least, kept, dt, equation, method, data, work, room, factors, kinds, options
            )
            kept = how == CONVERGED
            iterations[k] += count
            left[k] = rest
            if kept:
                break
        if not kept:
            return k, how
        step = (ends[k], thetas[k], stages_z[k], stages_theta[k], spin)
        finish(here, turned, z, dt, free, method, turn, algebraic, step)
    return u.shape[0], CONVERGED


@compiled
def march_linear(
    x: Array, z: Array, ends: Array, free: Array, modes: Array, real: Array, paired: Array, room: Array, end: Array,
    most: float,
) -> int:  # fmt: skip
    """Take steps of a linear system; ``z`` are loads at the stages, replaced by the unknowns there.

    Returns how many steps there were: up to the first after which the square of the unknowns is above ``most``.
    """
    data, columns, starts = free
    _, left, right, _, left_c, right_c = modes
    weights, extrapolation, algebraic = end
    force, b, re, im = room
    n, stages = x.size, z.shape[1]
    some_real, some_paired = real[0].size > 0, paired[0].size > 0
    for k in range(z.shape[0]):
        here = ends[k - 1] if k else x
        for i in range(n):
            total = 0.0
            for p in range(starts[i], starts[i + 1]):
                total += data[p] * here[columns[p]]
            force[i] = total
        if some_real:
            for i in range(n):
                total = 0.0
                for s in range(stages):
                    total += left[s] * (force[i] + z[k, s, i])
                b[i] = total
            substitute_real(real, b)
        if some_paired:
            for i in range(n):
                value = 0.0j
                for s in range(stages):
                    value += left_c[s] * (force[i] + z[k, s, i])
                re[i], im[i] = value.real, value.imag
            substitute_complex(paired, re, im)
        squares = 0.0
        for i in range(n):
            total = here[i]
            for s in range(stages):
                change = 0.0
                if some_real:
                    change += right[s] * b[i]
                if some_paired:
                    change += right_c[s].real * re[i] - right_c[s].imag * im[i]
                z[k, s, i] = here[i] + change
                total += weights[s] * change
            ends[k, i] = total
            squares += total * total
        for i in algebraic:
            total = 0.0
            for s in range(stages):
                total += extrapolation[s] * z[k, s, i]
            ends[k, i] = total
        if not squares < most:
            return k + 1
    return int(z.shape[0])
