"""The comparison of matrices with ports can fail: every entry that joins blocks is seen by it."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

import phblocks as ph
from phblocks.triplets import Triplets
from tests.properties.exchange import assert_ports_exchange_what_matrices_say as assert_agree


def hung():
    """A beam welded to a body, hung on a spring and damped, pushed; a second beam shares the spin of the body."""
    section = ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)
    d = ph.Diagram("hung", gravity=(0.0, -9.81))
    hub = d.add(ph.RigidBody("hub", 2.0, 0.1, (0.0, 0.0), {"rim": (0.2, 0.0), "back": (-0.2, 0.1)}))
    arm = d.add(ph.Beam("arm", section, (0.2, 0.0), (1.2, 0.3), elements=2, degree=2))
    spring = d.add(ph.Spring("spring", 80.0, (-0.2, 1.0), (-0.2, 0.1)))
    damper = d.add(ph.Damper("damper", 3.0, (1.5, 0.0), (1.2, 0.3)))
    d.weld(hub["rim"], arm.start)
    d.pin(spring.start, d.ground)
    d.pin(spring.end, hub["back"])
    d.pin(damper.end, arm.end)
    d.pin(damper.start, d.ground)
    d.expose(arm.end.translation, "push")
    return d


@pytest.fixture
def diagram(scenes, name):
    return hung() if name == "hung" else scenes[name]


ALL = ("hung", "four-bar", "frame", "arm", "shaken", "free")


@pytest.mark.parametrize("name", ALL)
def test_scenes_agree(diagram, name):
    assert_agree(diagram.compile(), diagram.network, seed=1, count=5)


def perturbed(entries, number):
    values = entries.values.copy()
    values[number] *= 1.0 + 1e-6
    return Triplets(entries.indices, values)


@pytest.mark.parametrize("name", ["hung", "four-bar"])
def test_each_entry_of_a_joint_is_seen(diagram, name):
    """By a millionth, one after the other: K, the books, and the inputs; each skew pair, so that J stays skew."""
    system = diagram.compile()
    seen = 0
    for number in range(system.K.values.size):
        i, j, f = (int(axis[number]) for axis in system.K.indices)
        twin = np.flatnonzero((system.K.indices[0] == j) & (system.K.indices[1] == i) & (system.K.indices[2] == f))
        bad = replace(system, K=perturbed(system.K, [number, *twin]))
        assert abs(bad.J() + bad.J().T).max() <= 1e-12 * abs(bad.J()).max()
        with pytest.raises(AssertionError):
            assert_agree(bad, diagram.network, seed=number, count=5)
        seen += 1
    books = system.connections
    for number in range(books.entries.values.size):
        bad = replace(system, connections=replace(books, entries=perturbed(books.entries, number)))
        with pytest.raises(AssertionError):
            assert_agree(bad, diagram.network, seed=number, count=5)
        seen += 1
    assert seen > 20


@pytest.mark.parametrize("name", ALL)
def test_an_entry_between_blocks_that_has_no_joint_is_seen(diagram, name):
    """In J0, between states of the first and of the last block."""
    system = diagram.compile()
    size = 1e-6 * max(abs(system.J0).max(), 1.0)
    pair = sp.coo_array(([size, -size], ([0, system.n - 1], [system.n - 1, 0])), shape=system.J0.shape)
    with pytest.raises(AssertionError):
        assert_agree(replace(system, J0=sp.csr_array(system.J0 + pair)), diagram.network, seed=0, count=5)


@pytest.mark.parametrize("name", ["hung", "frame", "arm", "shaken", "free"])
def test_a_wrong_input_is_seen(diagram, name):
    system = diagram.compile()
    constant = bool(system.G0.nnz)
    bad = replace(system, **({"G0": 1.000001 * system.G0} if constant else {"K_u": perturbed(system.K_u, [0])}))
    with pytest.raises(AssertionError):
        assert_agree(bad, diagram.network, seed=0, count=5)
