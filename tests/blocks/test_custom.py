"""Blocks with an energy of the user's: what they assemble to, their linear models, and what is refused."""

import math

import numpy as np
import pytest
import sympy

import phblocks as ph
from phblocks.errors import ArgumentTypeError, ConstraintError, DataError, StructureError

LINE = ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))
SKEW = [[0.0, 1.0], [-1.0, 0.0]]
FUNCTIONS = {
    "hamiltonian": lambda x: x[1] ** 2 / 2 + x[0] ** 2 / 2 + x[0] ** 4 / 4,
    "gradient": lambda x: [x[0] + x[0] ** 3, x[1]],
    "hessian": lambda x: [[1.0 + 3.0 * x[0] ** 2, 0.0], [0.0, 1.0]],
}


def duffing(**options) -> ph.CustomBlock:
    given = {"J": SKEW, "G": [[0.0], [1.0]], "ports": {"mass": ph.SystemPort(LINE, (0,), "velocity")}}
    return ph.CustomBlock("duffing", 2, **(FUNCTIONS | given | {"start": [1.5, 0.0]} | options))


def alone(block) -> ph.System:
    d = ph.Diagram("alone")
    d.add(block)
    d.expose(block["mass"], "force")
    return d.compile()


def test_what_it_assembles_to():
    system = alone(duffing(R=np.diag([0.0, 0.3])))
    assert (system.quadratic, system.linear, system.is_dae, system.constraint_names) == (False, False, False, ())
    assert system.state_names == tuple(f"duffing.{x}{i}[0]" for x in "xz" for i in range(2))
    np.testing.assert_array_equal(system.J().toarray()[2:, 2:], SKEW)
    x, u = np.array([1.2, -0.4]), np.array([0.7])
    z = np.array(FUNCTIONS["gradient"](x))
    at = system.settled(np.concatenate([x, [9.0, 9.0]]))
    np.testing.assert_array_equal(at, [*x, *z])
    # x' stands in the rows of z, and 0 = z - grad H(x) in those of x
    rate = (np.array(SKEW) - np.diag([0.0, 0.3])) @ z + [0.0, 0.7]
    np.testing.assert_allclose(system.force(at, u=u), [0.0, 0.0, *rate], atol=1e-15)
    np.testing.assert_array_equal(system.rate_matrix.toarray(), np.kron([[0.0, 0.0], [1.0, 0.0]], np.eye(2)))
    assert system.energy(at) == FUNCTIONS["hamiltonian"](x)


def test_quadratic_systems_say_so():
    d = ph.Diagram("mass")
    d.add(ph.Mass("m", 1.0, (0.0, 0.0)))
    system = d.compile()
    assert system.quadratic
    assert system.settled(system.start.x) is system.start.x


@pytest.mark.parametrize("q", [0.0, 1.5])
def test_linearization_and_modes(q):
    system = alone(duffing(start=[q, 0.0]))
    linear = system.linearize()
    E, A, B, C = (m.toarray() for m in (linear.E, linear.A, linear.B, linear.C))
    stiffness, s = 1.0 + 3.0 * q**2, 0.3 + 0.7j
    np.testing.assert_allclose(C @ np.linalg.solve(s * E - A, B), [[s / (s**2 + stiffness)]], rtol=1e-12)
    modes = system.modes(1)
    np.testing.assert_allclose(modes.frequencies, [np.sqrt(stiffness)], rtol=1e-12)
    np.testing.assert_allclose(modes.growth, 0.0, atol=1e-12)
    shape = modes.shapes[:, 0]
    np.testing.assert_allclose(shape[2:], np.diag([stiffness, 1.0]) @ shape[:2], atol=1e-12)


def test_modes_where_the_energy_has_a_saddle():
    q, p = sympy.symbols("q p")
    block = ph.CustomBlock.from_sympy("well", p**2 / 2 - q**2 / 2 + q**4 / 4, (q, p), J=SKEW)
    d = ph.Diagram("well")
    d.add(block)
    system = d.compile()
    assert system.modes(1).frequencies.size == 0  # at q = 0 it leaves without swinging
    x = system.settled(np.array([1.0, 0.0, 0.0, 0.0]))
    state = ph.State(x, system.start.theta, system.start.points)
    np.testing.assert_allclose(system.modes(1, state).frequencies, [np.sqrt(2.0)], rtol=1e-12)


def test_sympy_gives_the_same_block():
    q, p = sympy.symbols("q p")
    block = ph.CustomBlock.from_sympy("duffing", p**2 / 2 + q**2 / 2 + q**4 / 4, (q, p), J=SKEW, start=[1.5, 0.0])
    hand, rng = duffing(), np.random.default_rng(1)
    for x in rng.standard_normal((5, 2)):
        assert block.hamiltonian(x) == pytest.approx(hand.hamiltonian(x), rel=1e-14)
        np.testing.assert_allclose(block.gradient(x), hand.gradient(x), rtol=1e-14)
        np.testing.assert_allclose(block.hessian(x), hand.hessian(x), rtol=1e-14)
    with pytest.raises(DataError, match="one in k too"):
        ph.CustomBlock.from_sympy("a", sympy.Symbol("k") * q**2, [q])
    with pytest.raises(ArgumentTypeError, match="sympy expression"):
        ph.CustomBlock.from_sympy("a", "q**2", [q])
    with pytest.raises(ArgumentTypeError, match="sympy symbols"):
        ph.CustomBlock.from_sympy("a", q**2, ["q"])


def test_a_stiffening_spring_between_two_masses():
    d = ph.Diagram("masses")
    x = sympy.Symbol("x")
    spring = d.add(
        ph.CustomBlock.from_sympy(
            "spring",
            sympy.cosh(2 * x),
            [x],
            G=[[1.0, -1.0]],
            ports={name: ph.SystemPort(LINE, (i,), "force") for i, name in enumerate(("one", "two"))},
            start=[0.8],
            energy="strain",
        )
    )
    wall = d.add(ph.Reference("wall", LINE))
    for name, mass in (("one", 1.0), ("two", 3.0)):
        capacitor = d.add(ph.Capacitor(name, mass, domain=LINE, energy="kinetic"))
        d.connect(spring[name], capacitor.p)
        d.connect(capacitor.n, wall.port)
    system = d.compile()
    solution = ph.simulate(system, 20.0, 0.05)
    energy = solution.energy
    assert np.ptp(energy.total) < 1e-13 * energy.total[0]
    np.testing.assert_allclose(energy.strain, np.cosh(2.0 * solution.x[:, 0]), rtol=1e-14)
    momentum = solution.x @ [
        {"one": 1.0, "two": 3.0}.get(name.removesuffix(".velocity[0]"), 0.0) for name in system.state_names
    ]
    assert np.abs(momentum).max() < 1e-13
    assert np.ptp(energy.kinetic) > 0.5


def test_a_pendulum_that_turns_a_shaft():
    d = ph.Diagram("pendulum")
    a, p = sympy.symbols("a p")
    block = d.add(
        ph.CustomBlock.from_sympy(
            "pendulum",
            p**2 / 2 - 9.81 * sympy.cos(a),
            (a, p),
            J=SKEW,
            G=[[0.0], [1.0]],
            ports={"shaft": ph.SystemPort(ph.ROTATION, (0,), "angular velocity")},
            start=[2.0, 0.0],
        )
    )
    damper = d.add(ph.TorsionDamper("damper", 0.05))
    d.connect(block["shaft"], damper.first)
    d.connect(damper.second, d.ground.rotation)
    system = d.compile()
    solution = ph.simulate(system, 10.0, 0.02)
    assert solution.max_power_balance_error < 1e-13
    assert solution.energy.dissipated[-1] > 0.1
    np.testing.assert_allclose(2.0 + solution.at(10.0).theta[0], solution.x[-1, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"gradient": lambda x: [x[0] + x[0] ** 2, x[1]]}, StructureError, "gradient: expected the derivative"),
        ({"hessian": lambda x: [[1.0, 0.0], [0.0, 1.0]]}, StructureError, "hessian: expected the derivative"),
        ({"gradient": lambda x: [x[0]]}, DataError, "gradient: expected shape"),
        ({"hessian": lambda x: x}, DataError, "hessian: expected shape"),
        ({"hamiltonian": lambda x: np.nan}, DataError, "not finite at the start"),
        ({"hamiltonian": lambda x: "energy"}, ArgumentTypeError, "hamiltonian"),
        ({"hamiltonian": 3.0}, ArgumentTypeError, "a function of x"),
        ({"J": np.eye(2)}, StructureError, "skew"),
        ({"R": -np.eye(2)}, StructureError, "semidefinite"),
        ({"J": np.eye(3)}, DataError, "shape"),
        ({"G": None}, DataError, "ports"),
        ({"G": [0.0, 1.0]}, DataError, "G: expected finite numbers of shape"),
        ({"G": "G"}, ArgumentTypeError, "G"),
        ({"start": [1.0]}, DataError, "start"),
        ({"units": ("m",)}, DataError, "units"),
        ({"size": 0}, DataError, "size"),
        ({"size": 2.0}, ArgumentTypeError, "size"),
    ],
)
def test_what_is_refused(options, error, words):
    given = FUNCTIONS | {"size": 2, "J": SKEW, "G": [[0.0], [1.0]], "start": [1.5, 0.0]}
    given |= {"ports": {"mass": ph.SystemPort(LINE, (0,), "velocity")}} | options
    with pytest.raises(error, match=words):
        ph.CustomBlock("duffing", **given)


def test_what_its_systems_refuse():
    system = alone(duffing())
    with pytest.raises(StructureError, match="linearize"):
        system.small_motions()
    with pytest.raises(StructureError, match=r"Q of system 'alone'.*another one in 'duffing'"):
        _ = system.Q


@pytest.fixture
def held() -> ph.System:
    """A mass of the user's, with the energy p^2 / 2 + p^4 / 4, geared by a multiplier to another mass."""
    d = ph.Diagram("held")
    p = sympy.Symbol("p")
    port = {"mass": ph.SystemPort(LINE, (0,), "velocity")}
    mass = d.add(ph.CustomBlock.from_sympy("custom", p**2 / 2 + p**4 / 4, [p], G=[[1.0]], ports=port))
    other = d.add(ph.Capacitor("other", 2.0, domain=LINE, energy="kinetic"))
    gear = d.add(ph.Transformer("gear", 3.0, LINE, LINE, multiplier=True))
    d.connect(mass["mass"], gear.first)
    d.connect(gear.second, other.p)
    d.connect(other.n, d.add(ph.Reference("wall", LINE)).port)
    d.expose(mass["mass"], "force")
    return d.compile()


def test_held_by_a_multiplier(held):
    assert held.is_dae
    assert len(held.constraint_names) == 1
    solution = ph.simulate(held, 2.0, 0.01, inputs={"force": np.cos})
    assert solution.status.name == "success"
    assert solution.max_power_balance_error < 1e-13
    velocity = {name: solution.x[1:, held.state_names.index(name)] for name in ("custom.z0[0]", "other.velocity[0]")}
    np.testing.assert_allclose(velocity["other.velocity[0]"], 3.0 * velocity["custom.z0[0]"], atol=1e-3)


def at(system, **values) -> ph.State:
    x = system.start.x.copy()
    for name, value in values.items():
        x[system.state_names.index(name)] = value
    return ph.State(x, system.start.theta, system.start.points)


def test_a_start_that_violates_the_multiplier_is_projected_as_by_an_impulse(held):
    """The gear turns 3 v1 = v2: the impulse is p on the first and -p/3 on the second, and H is least along it."""
    start = at(held, **{"custom.x0[0]": 1.0, "other.velocity[0]": 0.5})
    solution = ph.simulate(held, 1.0, 0.01, start=start, inputs={"force": 0.0})
    p, v = (solution.state(name)[0] for name in ("custom.x0[0]", "other.velocity[0]"))
    impulse = p - 1.0
    assert 2.0 * (v - 0.5) == pytest.approx(-impulse / 3.0, abs=1e-14)
    assert 3.0 * (p + p**3) == pytest.approx(v, abs=1e-13)

    def energy(j):
        a, b = 1.0 + j, 0.5 - j / 6.0
        return a**2 / 2 + a**4 / 4 + b**2

    assert energy(impulse) < min(energy(impulse - 1e-3), energy(impulse + 1e-3))
    change = solution.statistics.start_energy_change
    assert change == pytest.approx(energy(impulse) - energy(0.0), abs=1e-14)
    assert change < 0.0
    assert solution.max_power_balance_error < 1e-14


def test_a_quadratic_energy_of_the_users_is_projected_like_a_mass():
    p = sympy.Symbol("p")
    port = {"mass": ph.SystemPort(LINE, (0,), "velocity")}
    custom = ph.CustomBlock.from_sympy("mine", p**2 / 8, [p], G=[[1.0]], ports=port, start=[4.0])
    matrices = ph.SystemBlock("mine", E=[[4.0]], J=[[0.0]], G=[[1.0]], ports=port, start=[1.0])
    runs = []
    for block in (custom, matrices):
        d = ph.Diagram("geared")
        d.add(block)
        other, wall = (
            d.add(ph.Capacitor("other", 2.0, domain=LINE, energy="kinetic")),
            d.add(ph.Reference("wall", LINE)),
        )
        gear = d.add(ph.Transformer("gear", 3.0, LINE, LINE, multiplier=True))
        d.connect(block["mass"], gear.first)
        d.connect(gear.second, other.p)
        d.connect(other.n, wall.port)
        runs.append(ph.simulate(d.compile(), 0.1, 0.1))
    one, two = (run.statistics.start_energy_change for run in runs)
    assert one == pytest.approx(two, rel=1e-13)
    assert runs[0].state("other.velocity[0]")[0] == pytest.approx(runs[1].state("other.velocity[0]")[0], rel=1e-13)


def test_a_start_that_no_impulse_makes_consistent_is_refused():
    """A momentum whose velocity stays below one, driven at two."""
    d = ph.Diagram("slow")
    p = sympy.Symbol("p")
    block = ph.CustomBlock.from_sympy(
        "light", sympy.sqrt(1 + p**2), [p], G=[[1.0]], ports={"mass": ph.SystemPort(LINE, (0,), "velocity")}
    )
    d.add(block)
    gear = d.add(ph.Transformer("gear", 1.0, LINE, LINE, multiplier=True))
    d.connect(block["mass"], gear.first)
    d.expose(gear.second, "speed", imposes="velocity")
    system = d.compile()
    assert ph.simulate(system, 0.1, 0.1, inputs={"speed": 0.5}).state("light.x0[0]")[0] == pytest.approx(
        0.5 / 0.75**0.5
    )
    with pytest.raises(ConstraintError, match="no impulses found"):
        ph.simulate(system, 0.1, 0.1, inputs={"speed": 2.0})


def vessel(**options) -> ph.CustomBlock:
    """A gas over oil: 1e5 Pa at 2e-6 m^3 of 3e-6 m^3, with math's logarithm, which ends where the gas does."""
    n, whole = 0.1, 3e-6  # J, m^3
    given = {
        "hamiltonian": lambda x: -n * math.log(whole - x[0]),
        "gradient": lambda x: [n / (whole - x[0])],
        "hessian": lambda x: [[n / (whole - x[0]) ** 2]],
        "start": [2e-6],
    }
    return ph.CustomBlock("vessel", 1, **(given | options))


def test_small_numbers_and_edges_are_no_mistakes():
    assert vessel().gradient(np.array([2e-6]))[0] == pytest.approx(1e5)
    vessel(start=[2.99999e-6])  # the step around it leaves the vessel
    with pytest.raises(StructureError, match="gradient: expected the derivative of the hamiltonian"):
        vessel(gradient=lambda x: [0.1001 / (3e-6 - x[0])])
    with pytest.raises(StructureError, match="hessian: expected the derivative of the gradient"):
        vessel(hessian=lambda x: [[0.1001 / (3e-6 - x[0]) ** 2]])


STIFF = {
    "no curvature at the start": lambda x, p: x**4 / 4,
    "stiff, no curvature": lambda x, p: 1e7 * x**4 / 4 + p**2 / 2,
    "stiff": lambda x, p: x**2 / 2 + 1e9 * x**4 / 4 + p**2 / 2,
    "odd": lambda x, p: x**3 / 3 + p**2 / 2,
    "flat": lambda x, p: x**6 + p**2 / 2,
}


def by_hand(energy, gradient=lambda z: z, hessian=lambda z: z) -> ph.CustomBlock:
    """The energy as three functions that say nothing about where they come from."""
    x, p = sympy.symbols("x p")
    source = ph.CustomBlock.from_sympy("source", energy(x, p), [x, p], J=SKEW)
    return ph.CustomBlock(
        "hand",
        2,
        lambda z: source.hamiltonian(z),
        lambda z: gradient(np.array(source.gradient(z))),
        lambda z: hessian(np.array(source.hessian(z))),
        J=SKEW,
    )


@pytest.mark.parametrize("name", STIFF)
def test_energies_that_are_flat_or_stiff_at_the_start(name):
    """Differences there are what they leave out; so is a right derivative, and a wrong one is still seen."""
    by_hand(STIFF[name])
    for wrong in (2.0, -1.0, 0.0, 1.01):
        with pytest.raises(StructureError, match="gradient: expected the derivative of the hamiltonian"):
            both = lambda z, wrong=wrong: wrong * z  # noqa: E731
            by_hand(STIFF[name], gradient=both, hessian=both)
        with pytest.raises(StructureError, match="hessian: expected the derivative of the gradient"):
            by_hand(STIFF[name], hessian=lambda z, wrong=wrong: wrong * z)


def test_a_missing_term_beside_a_stiff_one_is_seen():
    for missing in (np.diag([1.0, 0.0]), np.diag([0.0, 1.0])):
        with pytest.raises(StructureError, match="hessian"):
            by_hand(STIFF["stiff"], hessian=lambda z, missing=missing: z - missing)


def test_an_energy_of_one_flat_variable_runs():
    """With momentum it swings: energy to round-off, and the amplitude by hand."""
    x, p = sympy.symbols("x p")
    assert ph.CustomBlock.from_sympy("s", x**4 / 4, [x]).hamiltonian(np.array([2.0])) == 4.0
    d = ph.Diagram("stiff")
    d.add(ph.CustomBlock.from_sympy("s", STIFF["stiff, no curvature"](x, p), [x, p], J=SKEW, start=[0.0, 1.0]))
    solution = ph.simulate(d.compile(), 0.2, 1e-3)
    assert np.ptp(solution.energy.total) < 1e-12
    # 1e7 x^4 / 4 = 1 / 2
    assert np.abs(solution.x[:, 0]).max() == pytest.approx((2.0 / 1e7) ** 0.25, rel=1e-3)


def test_a_matrix_that_is_flat_at_the_start():
    flat = {"J": SKEW, "derivatives": {"R": lambda z: np.stack([np.diag([0.0, 4e7 * z[0] ** 3]), np.zeros((2, 2))], 2)}}
    energy = {"hamiltonian": lambda z: z @ z / 2, "gradient": lambda z: z, "hessian": lambda z: np.eye(2)}
    ph.CustomBlock("r", 2, **energy, **flat, R=lambda z: np.diag([0.0, 1e7 * z[0] ** 4]))
    with pytest.raises(StructureError, match="derivative of R"):
        ph.CustomBlock("r", 2, **energy, **flat, R=lambda z: np.diag([0.0, 2e7 * z[0] ** 4]))


def test_a_wrong_port_is_told_before_a_wrong_derivative():
    with pytest.raises(DataError, match="ports"):
        duffing(hessian=lambda x: np.eye(2), ports={"mass": ph.SystemPort(LINE, (1,), "velocity")})


def test_a_mistake_in_a_small_unit_beside_a_large_one_is_seen():
    """Volumes of 1e-6 m^3 beside momenta of 1e3 N s."""
    weight = np.array([1e12, 1e-6])
    options = {"hamiltonian": lambda x: (weight * x * x).sum() / 2, "start": [1e-6, 1e3], "J": SKEW}
    options |= {"gradient": lambda x: weight * x, "hessian": lambda x: np.diag(weight)}
    ph.CustomBlock("both", 2, **options)
    for wrong in ([1.001, 1.0], [1.0, 1.001]):
        with pytest.raises(StructureError, match="gradient"):
            ph.CustomBlock("both", 2, **(options | {"gradient": lambda x, wrong=wrong: wrong * weight * x}))
        with pytest.raises(StructureError, match="hessian"):
            ph.CustomBlock("both", 2, **(options | {"hessian": lambda x, wrong=wrong: np.diag(wrong * weight)}))


@pytest.mark.parametrize("spring", [False, True])
def test_a_pin_with_a_multiplier_beside_a_custom_block(spring):
    """A bar pinned 0.5 m from its centre, moving at 1 m/s: it keeps (I + 0.25 m) w = 0.5 m v, whatever hangs on it."""
    d = ph.Diagram("swing", gravity=(0.0, -9.81))
    body = d.add(ph.RigidBody("bar", 2.0, 0.1, (0.5, 0.0), {"pin": (0.0, 0.0), "tip": (1.0, 0.0)}))
    d.pin(body["pin"], d.ground, multiplier=True)
    if spring:
        a = sympy.symbols("a b")
        energy = 30 * (a[0] ** 2 + a[1] ** 2) + 500 * (a[0] ** 2 + a[1] ** 2) ** 2
        port = {"end": ph.SystemPort(ph.TRANSLATION, (0, 1), "force")}
        block = d.add(ph.CustomBlock.from_sympy("tie", energy, a, G=np.eye(2), ports=port, start=[0.1, 0.0]))
        d.connect(body["tip"].translation, block["end"])
    system = d.compile()
    start = system.rigid_motion(velocity=(0.0, 1.0), blocks=["bar"])
    solution = ph.simulate(system, 1.0, 0.01, start=start)
    spin = 0.5 * 2.0 / (0.1 + 0.25 * 2.0)
    assert solution.statistics.start_energy_change == pytest.approx((0.1 + 0.5) * spin**2 / 2 - 1.0, rel=1e-12)
    assert solution.max_power_balance_error < 1e-12 * np.abs(solution.energy.total).max()
    if spring:  # it goes with the velocity of the tip, and pulls back
        np.testing.assert_array_equal(solution.x[0][system.state_names.index("tie.x0[0]")], 0.1)
