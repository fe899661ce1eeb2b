"""The reference scene."""

from collections.abc import Callable

import pytest

import phblocks as ph


@pytest.fixture(scope="session")
def four_bar() -> Callable[..., ph.System]:
    """The four-bar mechanism; the paper's discretisation is the default."""

    def build(elements: tuple[int, int, int] = (10, 6, 6), degree: int = 1, young: float = 2.1e11) -> ph.System:
        bar = ph.Section.rectangle(0.05, 0.05, young=young, poisson=0.3, density=2710.0, shear_factor=1.0)
        d = ph.Diagram("four-bar", gravity=(0.0, -9.81))
        crank = d.add(ph.Beam("crank", bar, (0.0, 0.5), (2.0, 1.5), elements[0], degree))
        coupler = d.add(ph.Beam("coupler", bar, (2.0, 1.5), (3.5, 1.5), elements[1], degree))
        rocker = d.add(ph.Beam("rocker", bar, (3.5, 1.5), (2.5, 0.5), elements[2], degree))
        d.pin(crank.start, d.ground)
        d.pin(crank.end, coupler.start)
        d.pin(coupler.end, rocker.start)
        d.pin(rocker.end, d.ground)
        return d.compile()

    return build
