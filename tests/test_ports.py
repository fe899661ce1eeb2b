"""Domains, ports and anchors."""

import pytest

import phblocks as ph
from phblocks.blocks.ground import Ground
from phblocks.errors import UnknownNameError
from phblocks.ports import ROTATION, TRANSLATION, Domain, Quantity
from phblocks.space import PLANAR, SPATIAL


@pytest.mark.parametrize(
    ("domain", "common", "summed"),
    [(TRANSLATION, ("velocity", "m/s"), ("force", "N")), (ROTATION, ("angular velocity", "rad/s"), ("moment", "N m"))],
)
def test_mechanical_domains(domain, common, summed):
    assert (domain.common.name, domain.common.unit) == common
    assert (domain.summed.name, domain.summed.unit) == summed


def test_components_of_a_domain():
    assert TRANSLATION.components(PLANAR) == (0, 1) and TRANSLATION.components(SPATIAL) == (0, 1, 2)
    assert ROTATION.components(PLANAR) == (2,) and ROTATION.components(SPATIAL) == (0, 1, 2)
    electric = Domain("electric", Quantity("voltage", "V"), Quantity("current", "A"))
    assert electric.components(PLANAR) == electric.components(SPATIAL) == (0,)


def test_an_anchor_has_a_port_for_forces_and_one_for_moments(bar):
    beam = ph.Beam("crank", bar, (0.0, 0.0), (1.0, 0.0), elements=2)
    assert beam.end.translation.path == "crank.end.translation"
    assert beam.end.rotation.path == "crank.end.rotation"
    assert (beam.end.translation.domain, beam.end.rotation.domain) == (TRANSLATION, ROTATION)
    assert beam.end.ports == (beam.end.translation, beam.end.rotation)
    assert all(port.block is beam and port.anchor is beam.end for port in beam.end.ports)
    assert beam.end.path == "crank.end"
    assert repr(beam.end) == "<anchor crank.end>"
    assert repr(beam.end.rotation) == "<crank.end.rotation: moment/angular velocity>"


def test_ports_are_told_apart_by_identity(bar):
    first, second = (ph.Beam("a", bar, (0.0, 0.0), (1.0, 0.0), elements=2) for _ in range(2))
    assert first.end.translation != second.end.translation
    assert len({first.end.translation, second.end.translation}) == 2


def test_ports_by_name(bar):
    beam = ph.Beam("crank", bar, (0.0, 0.0), (1.0, 0.0), elements=2)
    assert beam.ports["start.rotation"] is beam.start.rotation
    assert list(beam.ports) == ["start.translation", "start.rotation", "end.translation", "end.rotation"]
    assert list(Ground().ports) == ["anchor.translation", "anchor.rotation"]


def test_an_unknown_port_is_answered_with_the_known_ones(bar):
    ports = ph.Beam("crank", bar, (0.0, 0.0), (1.0, 0.0), elements=2).ports
    with pytest.raises(UnknownNameError, match=r"block 'crank'.*start\.translation.*got 'middle\.rotation'"):
        ports["middle.rotation"]
    assert ports.get("middle.rotation") is None and "middle.rotation" not in ports
