"""What the tests of the export share: a clamped beam, a system with every field in use, and how to compare."""

from collections.abc import Callable
from dataclasses import fields

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import splu

import phblocks as ph
from phblocks.export import Matrices, Tangent
from phblocks.system.matrices import matrices_at


def transfer(E, J, R, Q, G, s):
    """G^T Q (s E - (J - R) Q)^{-1} G."""
    return G.T @ (Q @ splu(sp.csc_array(s * E - (J - R) @ Q)).solve(G.toarray().astype(complex)))


def matrices_of(system: ph.System) -> Matrices:
    """What System.export hands over, at rest."""
    return matrices_at(system)


def random_sparse(rng: np.random.Generator, rows: int, columns: int) -> sp.csr_array:
    """Numbers of all magnitudes, some of them at the ends of the range."""
    dense = rng.normal(size=(rows, columns)) * 10.0 ** rng.integers(-300, 300, (rows, columns))
    dense[rng.random((rows, columns)) < 0.5] = 0.0
    dense[:1, :1] = 5e-324
    dense[-1:, -1:] = np.finfo(float).max
    return sp.csr_array(dense)


def random_matrices(n: int, m: int) -> Matrices:
    """Every field in use, names of every kind."""
    rng = np.random.default_rng(7)
    names = ['quote " and \\ and \\u00e4', "Träger.V1[0]", "θ̈ 梁 😀", "", " leading and trailing ", "two\nlines\t."]
    pick = lambda count: tuple(names[i % len(names)] + str(i // len(names) or "") for i in range(count))  # noqa: E731
    positions = rng.random(n)
    positions[::3] = np.nan
    shapes = dict(E=(n, n), J=(n, n), R=(n, n), Q=(n, n), G=(n, m), P=(n, m), S=(m, m), N=(m, m))
    k = n + 2
    lin_shapes = dict(A=(k, k), B=(k, m), C=(m, k), D=(m, m), E=(k, k))
    return Matrices(
        name='Brücke "№ 1"',
        about="somewhere:\nΩ = 3 rad/s",
        **{key: random_sparse(rng, *shape) for key, shape in shapes.items()},
        x0=rng.normal(size=n),
        f0=rng.normal(size=n),
        state_names=pick(n),
        state_units=("N·m",) * n,
        state_positions=positions,
        input_names=pick(m),
        input_units=("N",) * m,
        output_names=pick(m),
        output_units=("m/s",) * m,
        tangent=Tangent(
            **{key: random_sparse(rng, *shape) for key, shape in lin_shapes.items()},
            state_names=pick(k),
            state_units=("°",) * k,
        ),
    )


def assert_identical(got, expected) -> None:
    """Field by field, to the bit."""
    for field in fields(expected):
        a, b = getattr(got, field.name), getattr(expected, field.name)
        if sp.issparse(b):
            assert isinstance(a, sp.csr_array), field.name
            assert a.dtype == np.float64 and a.shape == b.shape, field.name
            for part in ("indptr", "indices", "data"):
                np.testing.assert_array_equal(getattr(a, part), getattr(b, part), err_msg=field.name)
        elif isinstance(b, np.ndarray):
            assert a.dtype == np.float64
            np.testing.assert_array_equal(a, b, err_msg=field.name)
        elif isinstance(b, Tangent):
            assert_identical(a, b)
        else:
            assert a == b and type(a) is type(b), field.name


@pytest.fixture(scope="session")
def system() -> ph.System:
    """A clamped beam that hangs in gravity, driven at its tip."""
    bar = ph.Section.rectangle(width=0.05, height=0.05, young=2.1e11, poisson=0.3, density=2710.0, shear_factor=1.0)
    d = ph.Diagram("clamped beam", gravity=(0.0, -9.81))
    beam = d.add(ph.Beam("Träger", bar, start=(0.0, 0.0), end=(0.8, 0.6), elements=6, degree=2))
    d.weld(beam.start, d.ground)
    d.expose(beam.end.translation, "tip")
    return d.compile()


@pytest.fixture(scope="session")
def beam(system) -> Matrices:
    return matrices_of(system)


@pytest.fixture(scope="session")
def full() -> Matrices:
    return random_matrices(9, 2)


@pytest.fixture(scope="session")
def closed() -> Matrices:
    """No inputs."""
    return random_matrices(5, 0)


@pytest.fixture
def identical() -> Callable[..., None]:
    return assert_identical


@pytest.fixture
def response() -> Callable[..., np.ndarray]:
    return transfer
