"""A block of one's own: what the contract asks for is all that is needed."""

import numpy as np
import pytest

import phblocks as ph
from phblocks.blocks.block import Block, PortChoice
from phblocks.blocks.form import FIXED, NO_ENERGY, AngleRows, Form, MaterialPoints, Piece, PortForm, StateRun
from phblocks.blocks.ground import Ground
from phblocks.ports import TRANSLATION, Anchor, Port
from phblocks.space import PLANAR
from phblocks.triplets import Triplets


class Ball(Block):
    """A point mass with one port, in the fixed frame, and damping by the air."""

    def __init__(self, name: str, mass: float, place, drag: float = 0.0) -> None:
        super().__init__(name)
        self.mass, self.drag = mass, drag
        self.anchor = Anchor(self, "centre", np.array(place, dtype=float))

    @property
    def anchors(self):
        return {"centre": self.anchor}

    @property
    def ports(self):
        return {"centre.translation": self.anchor.translation}

    @property
    def space(self):
        return PLANAR

    def choices(self):
        return [PortChoice(self.anchor.translation, may_give=True, may_take=False)], []

    def form(self, gives):
        both = Triplets.of([0, 1], [0, 1], values=1.0)
        kind = "kinetic" if self.mass > 0.0 else NO_ENERGY
        return Form(
            size=2,
            runs=tuple(StateRun(field, "m/s", kind, np.zeros(1)) for field in ("V1", "V2")),
            E=both.scaled(self.mass),
            J0=Triplets.empty(),
            R=both.scaled(self.drag),
            T=Triplets.empty(3),
            ports={"centre.translation": PortForm(True, (Piece(both, FIXED),))},
            orientations={"centre": AngleRows(Triplets.empty(), np.zeros(1))},
            points=MaterialPoints(
                np.array([self.mass]), both, AngleRows(Triplets.empty(), np.zeros(1)), self.anchor.position[None]
            ),
        )

    def read(self, solution: ph.Solution) -> np.ndarray:
        return solution.recording.points[:, solution.system.part(self.name).points][:, 0]


def test_a_ball_falls():
    d = ph.Diagram(gravity=(0.0, -10.0))
    ball = d.add(Ball("ball", 2.0, (1.0, 3.0)))
    system = d.compile(effects="all")
    assert system.linear and system.state_names == ("ball.V1[0]", "ball.V2[0]")
    solution = ph.simulate(system, t_end=1.0, dt=0.125)
    np.testing.assert_allclose(ball.read(solution), np.stack([1.0 + 0 * solution.t, 3.0 - 5.0 * solution.t**2], axis=1))
    np.testing.assert_allclose(solution.energy.gravity, -100.0 * solution.t**2, atol=1e-12)
    np.testing.assert_allclose(solution.energy.total, 0.0, atol=1e-12)


def test_a_ball_in_air_reaches_its_limit():
    """m v' = m g - c v: v = -(m g / c) (1 - exp(-c t / m)); what the air takes is booked."""
    d = ph.Diagram(gravity=(0.0, -10.0))
    d.add(Ball("ball", 2.0, (0.0, 0.0), drag=4.0))
    solution = ph.simulate(d.compile(), t_end=2.0, dt=0.01)
    exact = -5.0 * (1.0 - np.exp(-2.0 * solution.t))
    np.testing.assert_allclose(solution.state("ball.V2[0]"), exact, atol=1e-4)
    assert solution.max_power_balance_error < 1e-13
    assert solution.energy.dissipated[-1] == pytest.approx(-solution.energy.total[-1], rel=1e-12)
    assert solution.power.blocks["ball"]["dissipated"][-1] == solution.energy.dissipated[-1] > 50.0


def test_a_ball_without_mass_follows_its_load_at_once():
    """A state without energy: v = F / c in every step, and what is supplied is dissipated."""
    d = ph.Diagram()
    ball = d.add(Ball("dust", 0.0, (0.0, 0.0), drag=4.0))
    d.expose(ball.anchor.translation, "wind")
    system = d.compile()
    assert not system.carries_energy.any() and not system.E.toarray().any()
    solution = ph.simulate(system, t_end=1.0, dt=0.1, inputs={"wind": lambda t: (8.0 * t, 2.0)})
    np.testing.assert_allclose(solution.state("dust.V1[0]"), 2.0 * solution.t, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(solution.state("dust.V2[0]"), 0.5, rtol=1e-12)
    np.testing.assert_allclose(solution.energy.dissipated, solution.energy.supplied, rtol=1e-12)
    np.testing.assert_allclose(ball.read(solution)[-1], [1.0, 0.5], rtol=1e-12)


def test_a_ball_on_a_beam(bar):
    """It gives its velocity, so the end of the beam takes it; the joint turns with the beam."""
    d = ph.Diagram(gravity=(0.0, -10.0))
    beam = d.add(ph.Beam("arm", bar, (0.0, 0.0), (1.0, 0.0), 3, degree=2))
    ball = d.add(Ball("ball", 50.0, (1.0, 0.0)))
    d.pin(beam.start, d.ground)
    d.pin(beam.end, ball.anchor)
    assert beam.end_names(d.check().gives("arm")) == "pinned-pinned"
    solution = ph.simulate(d.compile(), t_end=0.5, dt=0.0025)
    end = solution.position(beam.end, source="strain")
    np.testing.assert_allclose(ball.read(solution), end, atol=1e-4)
    assert end[-1, 1] < -0.7
    assert np.abs(solution.energy.total - solution.energy.total[0]).max() < 1e-10
    assert solution.power.worst[1] < 1e-11
    # speed of a rigid bar with a mass at its end, from its energy
    drop, inertia = -end[-1, 1], 50.0 + bar.mass / 3.0
    speed = np.linalg.norm(solution.velocity(beam.end)[-1])
    assert speed == pytest.approx(np.sqrt(2.0 * 10.0 * drop * (50.0 + bar.mass / 2.0) / inertia), rel=2e-3)


def test_the_contract_cannot_be_left_unfulfilled():
    class Nothing(Block):
        pass

    with pytest.raises(TypeError, match="abstract"):
        Nothing("nothing")


def test_defaults_of_a_block():
    ball = Ball("ball", 1.0, (0.0, 0.0))
    assert repr(ball) == "<Ball 'ball'>" and ball.shared is False and ball.exposures() == ()


def test_the_ground_fits_any_space_and_gives_velocity_only():
    ground = Ground()
    choices, ties = ground.choices()
    assert ground.space is None and ground.shared and not ties
    assert [(c.may_give, c.may_take) for c in choices] == [(True, False)] * 2
    form = ground.form({"anchor.translation": True, "anchor.rotation": True})
    assert form.size == 0 and form.points is None and all(p.pieces == () for p in form.ports.values())


def test_a_port_needs_no_anchor():
    ball = Ball("ball", 1.0, (0.0, 0.0))
    port = Port(ball, "shaft", TRANSLATION)
    assert port.anchor is None and port.path == "ball.shaft"
