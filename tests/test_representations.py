"""What a prompt shows of an object is a line, whatever the size of what is in it."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.modes import Modes


@pytest.fixture(scope="module")
def shown(four_bar) -> dict[str, object]:
    diagram = four_bar((20, 12, 12))
    system = diagram.compile()
    n, start = system.n, system.start
    solution = ph.simulate(system, 0.02, 0.0002)
    reference = ph.studies.Reference(np.zeros((500, 2)), 1e-3, "by hand")
    return {
        f"<Diagram 'four-bar': 4 blocks, {len(diagram.network.junctions())} junctions>": diagram,
        f"<System 'four-bar': {n} states of 3 blocks, 0 inputs>": system,
        f"<State: {n} energy states, {start.theta.size} rotations, {len(start.points)} points>": start,
        "<Modes: 3, ": system.modes(3),
        f"<Linearization: {n} states, ": system.linearize(),
        f"<Matrices of 'four-bar': {n} states, 0 inputs>": system.matrices(),
        "<Solution of 'four-bar': 101 times to 0.02 s, success>": solution,
        "<Statistics: 100 steps, ": solution.statistics,
        "<EnergySeries: kinetic, strain, gravity, supplied, dissipated, numerical_loss, projected, ": solution.energy,
        "<Reference of shape (500, 2), uncertain by 0.001: by hand>": reference,
    }


def test_in_a_line(shown):
    for text, thing in shown.items():
        assert repr(thing).startswith(text)
        assert "\n" not in repr(thing) and len(repr(thing)) < 150


def test_modes_say_where_they_are():
    empty = np.empty(0)
    modes = Modes(np.array([3.0, 40.5]), np.zeros(2), np.zeros((7, 2), dtype=complex), empty)
    assert repr(modes) == "<Modes: 2, 3 to 40.5 rad/s, 0 diverging>"
    assert repr(Modes(empty, empty, np.empty((7, 0), dtype=complex), np.ones(1))) == ("<Modes: 0, 1 diverging>")
