"""Matrices that violate the structure are refused, with the states concerned."""

import dataclasses
import re

import numpy as np
import pytest
import scipy.sparse as sp

import phblocks as ph
from phblocks.assembly.structure import check_structure
from phblocks.errors import StructureError
from phblocks.triplets import Triplets


@pytest.fixture
def system(scene) -> ph.System:
    return scene.compile()


def entry(system: ph.System, i: int, j: int, value: float) -> sp.csr_array:
    return sp.csr_array(([value], ([i], [j])), shape=(system.n, system.n))


def changed(system: ph.System, **matrices) -> ph.System:
    names = {"R": "R0"}  # what is stored of R is its constant part
    return dataclasses.replace(system, **{names.get(k, k): sp.csr_array(v) for k, v in matrices.items()})


def damping(system: ph.System, *, rank: int) -> sp.csr_array:
    """Of low rank, dense enough to be no diagonal matrix, in the units of the states."""
    rows = np.random.default_rng(0).standard_normal((rank, 4)) * np.sqrt(system.E.diagonal()[:4])
    R = sp.lil_array((system.n, system.n))
    R[:4, :4] = rows.T @ rows
    return sp.csr_array(R)


def test_assembled_systems_pass(system):
    check_structure(system)
    check_structure(system.small_motions())


def test_damping_may_be_singular(system):
    check_structure(changed(system, R=damping(system, rank=2)))


@pytest.mark.parametrize("name", ["E", "R"])
def test_asymmetry(system, name):
    size = float(system.E.max())
    with pytest.raises(
        StructureError, match=rf"{name} of system '{system.name}': expected a symmetric matrix"
    ) as caught:
        check_structure(changed(system, **{name: getattr(system, name) + entry(system, 3, 5, size)}))
    assert system.state_names[3] in str(caught.value) and system.state_names[5] in str(caught.value)
    assert re.search(r"Check the matrices of '\w+' \(add at \w+\.py:\d+\)", caught.value.fix)


@pytest.mark.parametrize("name", ["E", "R"])
@pytest.mark.parametrize("value", [0.0, -1.0])
def test_a_diagonal_that_is_not_positive_where_a_state_takes_part(system, name, value):
    matrix = getattr(system, name).tolil()
    matrix[4, 4], matrix[4, 5], matrix[5, 4] = value, 1e-9, 1e-9
    with pytest.raises(StructureError, match=rf"{name} of system .*positive diagonal entries") as caught:
        check_structure(changed(system, **{name: matrix}))
    assert re.search(r" of '\w+' \(add at \w+\.py:\d+\)", caught.value.fix)
    assert system.state_names[4] in str(caught.value)


@pytest.mark.parametrize("name", ["E", "R", "J0"])
def test_entries_that_are_not_finite(system, name):
    with pytest.raises(StructureError, match=rf"{name[0]} of system"):
        check_structure(changed(system, **{name: getattr(system, name) + entry(system, 2, 2, np.nan)}))


def test_a_state_that_should_carry_energy_and_does_not(system):
    E = system.E.tolil()
    E[4, :] = E[:, 4] = 0.0
    with pytest.raises(StructureError, match=r"E of system .*positive definite"):
        check_structure(changed(system, E=E))


@pytest.mark.parametrize("name", ["E", "R"])
def test_negative_directions(system, name):
    matrix = (system.E + getattr(system, name)).tolil()
    matrix[0, 1] = matrix[1, 0] = 2.0 * np.sqrt(matrix[0, 0] * matrix[1, 1])  # the diagonal alone would pass
    with pytest.raises(StructureError, match=rf"{name} of system .*positive (semi)?definite.*negative direction"):
        check_structure(changed(system, **{name: matrix}))


def test_a_damping_that_drives(system):
    with pytest.raises(StructureError, match=r"R of system .*positive diagonal entries"):
        check_structure(changed(system, R=-damping(system, rank=2)))


def test_interconnections_that_are_not_skew(system):
    size = float(abs(system.J0).max())
    with pytest.raises(StructureError, match=r"J of system .*expected a skew matrix"):
        check_structure(changed(system, J0=system.J0 + entry(system, 0, 2, 1e-6 * size)))
    with pytest.raises(StructureError, match="skew"):
        check_structure(changed(system, J0=system.J0 + entry(system, 1, 1, size)))


def test_products_that_are_not_skew(system):
    T = system.T.copy()
    T.data[0] *= 1.5
    with pytest.raises(StructureError, match="skew"):
        check_structure(dataclasses.replace(system, T=T))


def test_joints_that_are_not_skew(scenes):
    system = scenes["four-bar"].compile()
    K = Triplets(system.K.indices, system.K.values * np.where(np.arange(system.K.values.size) == 0, 2.0, 1.0))
    with pytest.raises(StructureError, match="skew"):
        check_structure(dataclasses.replace(system, K=K))
