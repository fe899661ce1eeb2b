"""Places where anchors are joined, also by blocks that hold junctions together or across a guide only."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.errors import GapError


def rail(**places):
    """A mass at (1, 2) on a slider along (1, 0), whose first side is left open."""
    d = ph.Diagram("rail")
    mass, slider = d.add(ph.Mass("mass", 1.0, (1.0, 2.0))), d.add(ph.Slider("rail", (1.0, 0.0), **places))
    d.connect(slider.second, mass.centre.translation)
    return d, mass, slider


def test_a_rail_on_the_ground_is_where_the_mass_is():
    d, mass, slider = rail()
    d.connect(slider.first, d.ground.translation)
    system = d.compile()
    (guide,) = system.guides
    assert system.sites == () and guide.anchor is None
    assert guide.first.known and guide.first.places == () and guide.second.places == (("mass", mass.centre.place),)
    np.testing.assert_array_equal(guide.first.start, [1.0, 2.0])
    np.testing.assert_array_equal(guide.across, [[0.0, 1.0]])


def test_a_rail_that_is_told_where_it_is():
    d, _, slider = rail(start=(0.0, 2.5), end=(1.0, 2.0))
    d.connect(slider.first, d.ground.translation)
    (guide,) = d.compile().guides
    np.testing.assert_array_equal(guide.first.start, [0.0, 2.5])
    d, _, slider = rail(start=(0.0, 2.5), end=(1.0, 2.1))
    d.connect(slider.first, d.ground.translation)
    with pytest.raises(
        GapError, match=r"rail and mass\.centre \(connect at test_sites\.py:\d+\): expected an anchor at \[1\.0, 2\.1\]"
    ):
        d.compile()


def test_a_rail_that_is_carried():
    """What is moved from outside has a place too: the mass is lifted with the rail and coasts along it."""
    d, mass, slider = rail()
    d.connect(slider.first, d.add(ph.Velocity("lift", (0.3, 0.4))).port)
    system = d.compile(effects="all")
    solution = ph.simulate(system, t_end=1.0, dt=0.1, start=system.rigid_motion((2.0, 0.4)))
    np.testing.assert_allclose(solution.position(mass.centre)[-1], [3.0, 2.4], atol=1e-13)
    np.testing.assert_allclose(solution.closure("velocity")["rail"], 0.0, atol=1e-13)


def test_a_rail_between_places_that_nobody_knows():
    """A part without extension is nowhere in particular, so there is no gap to measure."""
    d, _, slider = rail()
    lever = d.add(ph.Transformer("lever", 2.0, ph.TRANSLATION, ph.TRANSLATION))
    other = d.add(ph.Mass("other", 1.0, (5.0, 5.0)))
    d.connect(slider.first, lever.second)
    d.connect(lever.first, other.centre.translation)
    system = d.compile()
    assert system.guides == () and ph.simulate(system, t_end=0.1, dt=0.1).closure() == {}


def test_a_weld_and_a_pin_with_multipliers_are_sites():
    d = ph.Diagram("chain")
    one = d.add(ph.RigidBody("one", 1.0, 0.1, (0.0, 0.0), {"tip": (1.0, 0.0)}))
    two = d.add(ph.RigidBody("two", 1.0, 0.1, (1.0, 0.0)))
    three = d.add(ph.Mass("three", 1.0, (1.0, 0.0)))
    d.weld(one["tip"], two.centre, multiplier=True)
    d.pin(d.ground, one.centre, multiplier=True)
    d.expose(three.centre.translation, "pull")
    assert [site.name for site in d.compile().sites] == ["one.tip = two.centre", "ground.anchor = one.centre"]


def test_feet_that_are_apart_have_places_of_their_own(bar):
    """One source moves both feet of a portal; strain and velocity agree on where they are, and no joint opens."""
    d = ph.Diagram("portal")
    left = d.add(ph.Beam("left", bar, (0.0, 0.0), (0.0, 1.0), elements=2))
    girder = d.add(ph.Beam("girder", bar, (0.0, 1.0), (1.0, 1.0), elements=2))
    right = d.add(ph.Beam("right", bar, (1.0, 0.0), (1.0, 1.0), elements=2))
    d.weld(left.end, girder.start)
    d.weld(girder.end, right.end)
    quake = d.add(ph.Velocity("quake", lambda t: (0.01 * np.sin(20.0 * t), 0.0)))
    d.connect(quake.port, left.start.translation, right.start.translation, apart=True)
    for foot in (left.start, right.start):
        d.connect(foot.rotation, d.ground.rotation)
    system = d.compile()
    assert [site.start.tolist() for site in system.sites if site.known] == [[0.0, 0.0], [1.0, 0.0]]
    solution = ph.simulate(system, 0.2, 0.005)
    assert max(gap.max() for gap in solution.closure(source="strain").values()) < 1e-4
    apart = solution.position(right.start, source="strain") - solution.position(left.start, source="strain")
    np.testing.assert_allclose(apart, [[1.0, 0.0]] * solution.t.size, atol=1e-12)
