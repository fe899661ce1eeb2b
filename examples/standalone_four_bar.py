"""A nonlinear model from a file, integrated with NumPy and SciPy alone: how to use exported models without phblocks.

    python examples/standalone_four_bar.py [four_bar.npz] [--out results] [--dt 0.02] [--t-end 2]

The file comes from ``system.export("four_bar.npz")`` of a system without inputs and lines of action, such as that of
examples/four_bar.py. The implicit midpoint rule; what each field is stands in docs/export.md.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve


def simulate(path: str | Path, dt: float, t_end: float) -> tuple[np.ndarray, ...]:
    """Integrate; return times, states, rotation states, points, stored energy and work of gravity at all times."""
    with np.load(path) as z:
        file = {key: z[key] for key in z.files}

    def sparse(key: str) -> sp.csr_array:
        entries = file[f"nl_{key}_data"], (file[f"nl_{key}_row"], file[f"nl_{key}_col"])
        return sp.csr_array(entries, shape=file[f"nl_{key}_shape"])

    E, J0, R, Kg, W, alpha, gamma, points = map(sparse, ("E", "J0", "R", "Kg", "W", "alpha", "gamma", "points"))
    n, T, K = E.shape[0], sparse("T").tocoo(), sparse("K").tocoo()  # row i + n j of T and K is entry (i, j) of J
    Tj, Ti = np.divmod(T.row, n)
    Kj, Ki = np.divmod(K.row, n)
    x, theta, r = file["x0"], file["nl_theta0"], file["nl_points0"]
    rows, work = [(x, theta, r)], [0.0]
    for _ in range(round(t_end / dt)):
        z = x.copy()
        for _ in range(50):  # Newton's method for the middle z of the step
            a = file["nl_alpha0"] + alpha @ (theta + dt / 2 * (W @ z))
            phi = np.concatenate([[1.0], np.cos(a), np.sin(a)])
            slope = sp.vstack([sp.csr_array((1, n)), *(sp.diags_array(d) @ alpha @ W for d in (-np.sin(a), np.cos(a)))])
            J = (
                J0
                + sp.csr_array((T.data * z[T.col], (Ti, Tj)), (n, n))
                + sp.csr_array((K.data * phi[K.col], (Ki, Kj)), (n, n))
            )
            residual = 2 / dt * (E @ (z - x)) - (J - R) @ z - Kg @ phi
            by_state = sp.csr_array((T.data * z[Tj], (Ti, T.col)), (n, n))
            by_angle = (sp.csr_array((K.data * z[Kj], (Ki, K.col)), Kg.shape) + Kg) @ slope * (dt / 2)
            change = spsolve(sp.csc_array(2 / dt * E - (J - R) - by_state - by_angle), residual)
            z = z - change
            if change @ (E @ change) <= 1e-26 * (z @ (E @ z)):
                break
        middle = file["nl_gamma0"] + gamma @ (theta + dt / 2 * (W @ z))
        v = (points @ z).reshape(-1, 2).T  # in the frames of the points
        c, s = np.cos(middle), np.sin(middle)
        turned = np.stack([c * v[0] - s * v[1], s * v[0] + c * v[1]], axis=1)
        x, theta, r = 2 * z - x, theta + dt * (W @ z), r + dt * turned.ravel()
        rows.append((x, theta, r))
        work.append(work[-1] + dt * (z @ (Kg @ phi)))
    X, angles, places = (np.array(column) for column in zip(*rows, strict=True))
    stored = 0.5 * np.einsum("ti,ti->t", X, (E @ X.T).T)
    return np.arange(len(X)) * dt, X, angles, places.reshape(len(X), -1, 2), stored, np.array(work)


def main(argv: Sequence[str] | None = None) -> tuple[np.ndarray, ...]:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("path", nargs="?", default="four_bar.npz", help="a .npz file with a nonlinear model")
    parser.add_argument("--out", type=Path, default=Path("results"), help="folder for the states over time")
    parser.add_argument("--dt", type=float, default=0.02, help="step, s")
    parser.add_argument("--t-end", type=float, default=2.0, help="duration, s")
    options = parser.parse_args(argv)
    t, x, theta, points, stored, work = simulate(options.path, options.dt, options.t_end)
    print(f"{x.shape[1]} states, {len(t) - 1} steps; mean of all points at the end {points[-1].mean(axis=0)} m")
    print(f"stored energy less the work of gravity changed by at most {np.abs(stored - work - stored[0]).max():.1e} J")
    options.out.mkdir(parents=True, exist_ok=True)
    np.savez(options.out / "motion.npz", t=t, x=x, theta=theta, points=points)
    return t, x, theta, points, stored, work


if __name__ == "__main__":
    main()
