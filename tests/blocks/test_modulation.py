"""Matrices that depend on the state: motions with known solutions, exact balances, and what is refused."""

import itertools
import re

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from scipy.special import ellipj

import phblocks as ph
from phblocks.blocks.modulation import StateMatrix, typical
from phblocks.errors import ArgumentTypeError, DataError, StructureError

LINE = ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))
INERTIA = np.array([1.0, 2.0, 3.0])  # kg m^2
SPIN = (1.0, 0.0, 2.0)  # angular momentum at the start, N m s


def cross(x):
    """l x w = cross(l) w."""
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])


CROSS_SLOPE = np.stack([cross(e) for e in np.eye(3)], axis=-1)


def rigid_body(**options) -> ph.CustomBlock:
    """Euler's equations l' = l x w with w = l / I."""
    given = {"J": cross, "start": SPIN, "energy": "kinetic"} | options
    return ph.CustomBlock(
        "body",
        3,
        lambda x: (x * x / INERTIA).sum() / 2,
        lambda x: x / INERTIA,
        lambda x: np.diag(1.0 / INERTIA),
        **given,
    )


def alone(block, **exposed) -> ph.System:
    d = ph.Diagram("alone")
    d.add(block)
    for port, name in exposed.items():
        d.expose(block[port], name)
    return d.compile()


def euler(t):
    """The exact solution from a start without spin about the middle axis: Landau and Lifshitz, Mechanics, § 37."""
    (i1, i2, i3), l = INERTIA, np.array(SPIN)
    twice, square = (l * l / INERTIA).sum(), l @ l
    rate = np.sqrt((i3 - i2) * (square - twice * i1) / (i1 * i2 * i3))
    m = (i2 - i1) * (twice * i3 - square) / ((i3 - i2) * (square - twice * i1))
    sn, cn, dn, _ = ellipj(rate * t, m)
    w = (
        np.sqrt((twice * i3 - square) / (i1 * (i3 - i1))) * cn,
        np.sqrt((twice * i3 - square) / (i2 * (i3 - i2))) * sn,
        np.sqrt((square - twice * i1) / (i3 * (i3 - i1))) * dn,
    )
    return np.stack(w, axis=-1) * INERTIA


def order(steps, errors) -> float:
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def test_a_rigid_body_turns_as_euler_says():
    system, steps, errors = alone(rigid_body()), [0.1, 0.05, 0.025], []
    for dt in steps:
        solution = ph.simulate(system, 10.0, dt)
        l = solution.x[:, :3]
        assert np.ptp(solution.energy.total) < 1e-13
        assert np.ptp((l * l).sum(axis=1)) < 1e-12  # a Casimir: l^T J(l) = 0
        errors.append(np.abs(l - euler(solution.t)).max())
    assert errors[-1] < 1e-3
    assert order(steps, errors) == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("derivatives", [None, {"J": lambda x: CROSS_SLOPE}])
def test_with_the_derivative_and_by_differences_it_is_the_same_motion(derivatives):
    plain, exact = (ph.simulate(alone(rigid_body(derivatives=d)), 5.0, 0.05) for d in (None, derivatives))
    np.testing.assert_allclose(plain.x, exact.x, atol=1e-13)
    assert np.mean(exact.statistics.newton_iterations) < 4


def test_sympy_matrices_are_the_functions():
    x = sympy.symbols("x:3")
    H = sum(a**2 / (2 * sympy.Float(i)) for a, i in zip(x, INERTIA, strict=True))
    J = sympy.Matrix([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])
    R, G = sympy.diag(x[0] ** 2, 0, 0.5), sympy.Matrix([1, 2, 0])
    port = {"ports": {"a": ph.SystemPort(LINE, (0,), "velocity")}, "start": SPIN}
    made = ph.CustomBlock.from_sympy("body", H, x, J=J, R=R, G=G, **port)
    hand = rigid_body(R=lambda l: np.diag([l[0] ** 2, 0.0, 0.5]), G=[[1.0], [2.0], [0.0]], **port)
    for at in np.random.default_rng(0).standard_normal((4, 3)):
        for letter in "JRGPSN":
            one, two = made.matrices[letter], hand.matrices[letter]
            assert one.constant == two.constant
            np.testing.assert_allclose(one(at), two(at), rtol=1e-15)
            np.testing.assert_allclose(one.slope(at), two.slope(at), atol=1e-8)
    runs = [ph.simulate(alone(b, a="force"), 2.0, 0.05, inputs={"force": np.cos}) for b in (made, hand)]
    np.testing.assert_allclose(runs[0].x, runs[1].x, atol=1e-13)
    with pytest.raises(DataError, match="J: expected an expression in the variables alone, got one in k too"):
        ph.CustomBlock.from_sympy("body", H, x, J=sympy.Symbol("k") * J)


def test_drag_that_grows_with_speed():
    """p' = -|v| v with unit mass: v = v0 / (1 + v0 t)."""
    drag = ph.CustomBlock(
        "drag",
        1,
        lambda x: x @ x / 2,
        lambda x: x,
        lambda x: np.eye(1),
        R=lambda x: [[abs(x[0])]],
        derivatives={"R": lambda x: [[[np.sign(x[0])]]]},
        start=[3.0],
    )
    system, steps, errors = alone(drag), [0.1, 0.05, 0.025], []
    for dt in steps:
        solution = ph.simulate(system, 4.0, dt)
        errors.append(np.abs(solution.x[:, 0] - 3.0 / (1.0 + 3.0 * solution.t)).max())
        energy = solution.energy
        assert solution.max_power_balance_error < 1e-14 * energy.total[0]
        # the ledger counts with R at the midpoint of each step
        middle = (solution.x[1:, 0] + solution.x[:-1, 0]) / 2.0
        np.testing.assert_allclose(energy.dissipated[1:], np.cumsum(dt * np.abs(middle) ** 3), rtol=1e-12)
    assert errors[-1] < 1e-3
    assert order(steps, errors) == pytest.approx(2.0, abs=0.1)
    assert system.R.toarray()[1, 1] == 3.0
    assert system.R_at(np.array([-2.0, -2.0])).toarray()[1, 1] == 2.0


def test_predators_and_prey():
    """x' = x (a - b y), y' = y (d x - c): J = [[0, -xy], [xy, 0]] with H = d x - c ln x + b y - a ln y."""
    a, b, c, d = 1.1, 0.4, 0.4, 0.1
    x, y = sympy.symbols("x y", positive=True)
    block = ph.CustomBlock.from_sympy(
        "lake",
        d * x - c * sympy.log(x) + b * y - a * sympy.log(y),
        (x, y),
        J=sympy.Matrix([[0, -x * y], [x * y, 0]]),
        start=[10.0, 10.0],
    )
    solution = ph.simulate(alone(block), 40.0, 0.05)
    assert solution.status.ok
    assert np.ptp(solution.energy.total) < 1e-12 * np.abs(solution.energy.total[0])
    reference = solve_ivp(
        lambda t, s: [s[0] * (a - b * s[1]), s[1] * (d * s[0] - c)], (0, 10), [10, 10], rtol=1e-10, atol=1e-12
    )
    short = ph.simulate(alone(block), 10.0, 0.005)
    np.testing.assert_allclose(short.x[-1, :2], reference.y[:, -1], rtol=1e-3)


def speaker(voltage=0.0, position=0.002) -> ph.System:
    """A coil in a field that weakens with the stroke, G(x), on a source with resistance and inductance."""
    q, p = sympy.symbols("q p")
    block = ph.CustomBlock.from_sympy(
        "cone",
        50 * p**2 + 400 * q**2 + 2.5e7 * q**4,
        (q, p),
        J=[[0, 1], [-1, 0]],
        R=sympy.diag(0, 1 + 50 * (100 * p) ** 2),
        G=sympy.Matrix([0, 6 / (1 + (q / 0.003) ** 2)]),
        ports={"coil": ph.SystemPort(ph.ELECTRICAL, (0,), "voltage")},
        start=[position, 0.0],
    )
    d = ph.Diagram("speaker")
    d.add(block)
    inductor, resistor = d.add(ph.Inductor("L", 1e-3)), d.add(ph.Resistor("r", 4.0))
    d.connect(d.add(ph.Voltage("source", voltage)).port, inductor.p)
    d.connect(inductor.n, resistor.p)
    d.connect(resistor.n, block["coil"])
    return d.compile()


def speaker_rates(state, voltage):
    """By hand: position, momentum, current."""
    q, p, i = state
    v, factor = 100 * p, 6 / (1 + (q / 0.003) ** 2)
    force = -800 * q - 1e8 * q**3 - (1 + 50 * v * v) * v + factor * i
    return np.array([v, force, (voltage - 4 * i - factor * v) / 1e-3])


def tone(t):
    return 20.0 * np.sin(400.0 * t)


SPEAKER = ("cone.x0[0]", "cone.x1[0]", "L.current[0]")


def test_a_force_factor_that_depends_on_the_stroke():
    system = speaker(tone)
    assert "cone.taken0[0]" in system.state_names and not system.constraint_names
    reference = solve_ivp(
        lambda t, s: speaker_rates(s, tone(t)), (0, 0.03), [0.002, 0, 0], method="Radau", rtol=1e-9, atol=1e-12
    )
    steps, errors = [2e-4, 1e-4, 5e-5], []
    for dt in steps:
        solution = ph.simulate(system, 0.03, dt)
        end = np.array([solution.state(name)[-1] for name in SPEAKER])
        errors.append(np.abs((end - reference.y[:, -1]) / np.abs(reference.y).max(axis=1)).max())
        energy = solution.energy
        assert solution.max_power_balance_error < 1e-12 * energy.total.max()
        assert energy.dissipated[-1] > energy.total.max()
        change = energy.total[-1] - energy.total[0]
        assert change == pytest.approx(energy.supplied[-1] - energy.dissipated[-1], abs=1e-12 * energy.supplied[-1])
    assert errors[-1] < 2e-3
    assert order(steps, errors) == pytest.approx(2.0, abs=0.2)


def through(constant: bool) -> dict:
    """J, R, G, P, S, N of two states and two inputs, constant or with parts that depend on x."""
    rng = np.random.default_rng(3)
    root, skew, G = rng.standard_normal((4, 4)), np.array([[0.0, 1.0], [-1.0, 0.0]]), rng.standard_normal((2, 2))

    def loss(x):
        return root @ np.diag([1.0, 0.5, 0.2, 0.1] if constant else [1.0, 0.5 + x[0] ** 2, 0.2, 0.1]) @ root.T

    if constant:
        W = loss(None)
        return {"J": skew, "R": W[:2, :2], "G": G, "P": W[:2, 2:], "S": W[2:, 2:], "N": 0.7 * skew}
    return {
        "J": lambda x: (1.0 + x[1]) * skew,
        "R": lambda x: loss(x)[:2, :2],
        "G": lambda x: np.cos(x[0]) * G,
        "P": lambda x: loss(x)[:2, 2:],
        "S": lambda x: loss(x)[2:, 2:],
        "N": lambda x: x[0] * skew,
    }


TWO = {"ports": {"a": ph.SystemPort(LINE, (0,), "velocity"), "b": ph.SystemPort(ph.ELECTRICAL, (1,), "current")}}
FORCES = {"force": lambda t: np.sin(3.0 * t), "volt": lambda t: 0.5 - t}


def quadratic(matrix) -> tuple:
    return lambda x: x @ matrix @ x / 2, lambda x: matrix @ x, lambda x: matrix


def opened(block) -> ph.System:
    d = ph.Diagram("through")
    d.add(block)
    d.expose(block["a"], "force")
    d.expose(block["b"], "volt", imposes="voltage")
    return d.compile()


def test_feedthrough_is_that_of_a_system_block():
    Q = np.array([[2.0, 0.3], [0.3, 1.0]])
    custom = opened(ph.CustomBlock("block", 2, *quadratic(Q), **through(constant=True), start=[1.0, 0.0], **TWO))
    plain = opened(ph.SystemBlock("block", E=np.eye(2), Q=Q, **through(constant=True), start=[1.0, 0.0], **TWO))
    one, two = (ph.simulate(s, 2.0, 0.02, inputs=FORCES) for s in (custom, plain))
    np.testing.assert_allclose(one.x[:, :2], two.x[:, :2], atol=1e-13)
    np.testing.assert_allclose(one.energy.dissipated, two.energy.dissipated, atol=1e-13)
    np.testing.assert_allclose(one.x[1:, 4:], two.x[1:, 2:], atol=1e-13)  # given and taken


def test_everything_may_depend_on_the_state():
    def H(x):
        return x @ x / 2 + x[0] ** 4

    given = (H, lambda x: x + np.array([4 * x[0] ** 3, 0.0]), lambda x: np.diag([1.0 + 12.0 * x[0] ** 2, 1.0]))
    block = ph.CustomBlock("block", 2, *given, **through(constant=False), start=[0.8, -0.2], **TWO)
    solution = ph.simulate(opened(block), 4.0, 0.02, inputs=FORCES)
    energy = solution.energy
    assert solution.max_power_balance_error < 1e-12 * energy.total.max()
    assert energy.dissipated[-1] > 0.1
    parts = {letter: value for letter, value in through(constant=False).items()}

    def rates(t, x):
        m = {letter: value(x) for letter, value in parts.items()}
        u = np.array([FORCES["force"](t), FORCES["volt"](t)])
        return (m["J"] - m["R"]) @ given[1](x) + (m["G"] - m["P"]) @ u

    reference = solve_ivp(rates, (0.0, 4.0), [0.8, -0.2], rtol=1e-10, atol=1e-12).y[:, -1]
    coarse = ph.simulate(opened(block), 4.0, 0.04, inputs=FORCES).x[-1, :2] - reference
    fine = solution.x[-1, :2] - reference
    assert np.abs(fine).max() < 1e-3
    assert np.abs(coarse).max() / np.abs(fine).max() == pytest.approx(4.0, abs=0.4)

    def over(before, after, t):
        """Given and taken over a step, by hand."""
        m = {letter: value((before + after) / 2.0) for letter, value in parts.items()}
        z, u = block_discrete_gradient(H, given[1], before, after, block), [FORCES["force"](t), FORCES["volt"](t)]
        return np.concatenate([(m["G"] + m["P"]).T @ z + (m["S"] + m["N"]) @ u, u])

    a, b, c = solution.x[-3:, :2]  # what is reported is the mean of two steps
    np.testing.assert_allclose(solution.x[-2, 4:], (over(a, b, 3.97) + over(b, c, 3.99)) / 2.0, atol=1e-12)


def block_discrete_gradient(H, gradient, before, after, block):
    """Gonzalez by hand, in the units of the block."""
    d, g = after - before, gradient((before + after) / 2.0)
    weight = np.abs(np.diag(block.hessian(block.start)))
    return g + (H(after) - H(before) - g @ d) / (d @ (weight * d)) * weight * d


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"J": lambda x: cross(x) + 1e-6 * np.eye(3)}, StructureError, r"'body' J\(x\): expected a skew matrix"),
        ({"J": lambda x: cross(x) + np.eye(3) * (x[0] > 1.0)}, StructureError, r"J\(x\).*at x = \[1\.0"),
        ({"R": lambda x: -np.eye(3)}, StructureError, r"R\(x\): expected a positive semidefinite"),
        ({"R": lambda x: np.triu(np.ones((3, 3)))}, StructureError, r"R\(x\): expected a symmetric"),
        ({"J": lambda x: np.zeros((2, 2))}, DataError, r"J: expected finite numbers of shape \(3, 3\)"),
        ({"J": lambda x: 0.0}, DataError, "J: expected finite numbers of shape"),
        (
            {"J": lambda x: np.zeros((3, 3) if x[0] == 1.0 else (2, 2))},
            DataError,
            r"J: expected real .* shape \(2, 2\)",
        ),
        ({"J": lambda x: np.full((3, 3), np.nan)}, DataError, "J: expected finite numbers"),
        ({"J": lambda x: "skew"}, ArgumentTypeError, "J: expected numbers"),
        ({"J": lambda x: x[7] * np.eye(3)}, ArgumentTypeError, "J: expected a function of x"),
        ({"J": lambda x, y: np.eye(3)}, ArgumentTypeError, "J: expected a function of x"),
        ({"derivatives": {"J": lambda x: 2.0 * CROSS_SLOPE}}, StructureError, "derivative of J: expected the der"),
        ({"derivatives": {"J": lambda x: CROSS_SLOPE[0]}}, DataError, r"derivative of .* J: .* \(3, 3, 3\)"),
        ({"derivatives": {"R": lambda x: CROSS_SLOPE}}, ArgumentTypeError, "derivatives: expected functions, of matr"),
        ({"derivatives": {"Q": lambda x: CROSS_SLOPE}}, DataError, "derivatives: expected letters"),
        ({"N": [[1.0]], "G": np.ones((3, 1))}, StructureError, r"-N\]\]\(x\): expected a skew matrix"),
        ({"S": [[-1.0]], "G": np.ones((3, 1))}, StructureError, r"\[P\^T, S\]\]\(x\): expected a positive semi"),
        ({"P": np.ones((3, 1)), "G": np.ones((3, 1))}, StructureError, "semidefinite"),
        ({"P": np.ones((3, 2)), "G": np.ones((3, 1))}, DataError, r"P: expected finite numbers of shape \(3, 1\)"),
    ],
)
def test_what_is_refused(options, error, words):
    with pytest.raises(error, match=words):
        rigid_body(ports={"a": ph.SystemPort(LINE, (0,), "velocity")}, **options)


@pytest.mark.parametrize("save_every", [1, 7])
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            {"R": lambda x: np.eye(3) * (0.0 if x[0] > 0.0 else -0.1)},
            r"'body' R\(x\): expected a positive semidefinite matrix, got a defect of 0.1 at",
        ),
        (
            {"J": lambda x: cross(x) + (1e-9 * np.eye(3) if x[0] < 0.0 else 0.0)},
            r"'body' J\(x\): expected a skew matrix, got a defect of 2e-09 at x = \[-",
        ),
        (
            {"J": lambda x: cross(x) * (1.0 if x[0] > 0.0 else np.nan), "derivatives": {"J": lambda x: CROSS_SLOPE}},
            r"'body' J\(x\) is not finite at x = \[-",
        ),
        ({"J": lambda x: cross(x) + 0.0 * np.sqrt(x[0])}, r"'body' .* is not finite at x = \["),
    ],
    ids=["drives", "bent", "NaN", "root"],
)
def test_matrices_that_go_wrong_far_from_the_start_end_the_run_with_a_status(options, words, save_every):
    """The results up to the last good step are those of a body that stays well."""
    solution = ph.simulate(alone(rigid_body(**options)), 10.0, 0.005, save_every=save_every)
    status, kept = solution.status, solution.t.size
    assert not status.ok and re.search(words, status.text) and "results up to there are kept" in status.text
    assert status.name == ("step failed" if "not finite" in words else "structure lost")
    assert solution.t[-1] == pytest.approx(status.time, abs=1e-12) and f"t = {status.time:.9g} s" in status.text
    assert solution.statistics.steps >= (kept - 1 if save_every == 1 else (kept - 2) * save_every)
    well = ph.simulate(alone(rigid_body()), float(solution.t[-1]), 0.005, save_every=save_every)
    np.testing.assert_allclose(solution.x[-1], well.x[-1], atol=1e-4 if "not finite" in words else 1e-12)
    assert abs(well.x[-1, 0]) < 0.02  # where the momentum about the first axis changes sign, in the middle of the step
    assert solution.max_power_balance_error < 1e-13


def test_what_is_not_finite_is_not_skew_either():
    modulation = rigid_body(J=lambda x: cross(x) if x[0] > 0.0 else np.full((3, 3), np.nan)).form({}).modulation
    with pytest.raises(StructureError, match=r"J\(x\): expected finite numbers, got \[\[nan.* at x = \[-1.0"):
        modulation.verified(np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]))


def test_a_function_that_changes_its_shape_is_refused_at_once():
    grows = rigid_body(J=lambda x: cross(x) if x[0] > 0.0 else np.zeros((4, 4)))
    with pytest.raises(DataError, match=r"J: expected real numbers of shape \(3, 3\), got shape \(4, 4\)"):
        ph.simulate(alone(grows), 10.0, 0.05)


def test_differences_have_steps_of_the_size_of_the_states():
    def function(x):  # pascals and cubic metres: sizes 1e6 and 1e-6
        return np.array([[np.sin(x[0] / 1e6) * np.cos(x[1] / 1e-6)]])

    size = np.array([1e6, 1e-6])
    matrix = StateMatrix("J", function, (1, 1), size, None)
    for x in (np.array([0.3e6, 0.0]), np.array([2e6, 3e-6]), np.zeros(2)):
        a, b = x / size
        expected = np.array([np.cos(a) * np.cos(b) / 1e6, -np.sin(a) * np.sin(b) / 1e-6])
        np.testing.assert_allclose(matrix.slope(x)[0, 0] * size, expected * size, atol=1e-9)
    np.testing.assert_array_equal(typical(np.zeros(2), size), size)
    np.testing.assert_allclose(typical(np.array([1e4, 0.0]), size), [1e4, 1e-8])
    np.testing.assert_allclose(typical(np.array([1e9, 0.0]), size), [1e9, 1e-6])


def leaking_tip(pieces: int) -> ph.System:
    """A cantilever, of one piece or of two that share states, with a leaking spring across and along its tip."""
    section = ph.Section(axial=3e4, shear=1e4, bending=50.0, mass=1.2, rotary=3e-3)
    edges = [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0)][:: 3 - pieces]
    d = ph.Diagram("tip")
    beams = [
        d.add(ph.Beam(f"beam{i}", section, *ends, elements=4 // pieces, degree=2, causality=causality))
        for i, (ends, causality) in enumerate(
            zip(itertools.pairwise(edges), ("clamped-free", "free-free"), strict=False)
        )
    ]
    for left, right in itertools.pairwise(beams):
        d.weld(left.end, right.start)
    d.weld(beams[0].start, d.ground)
    spring = ph.CustomBlock(
        "spring",
        2,
        *quadratic(400.0 * np.eye(2)),
        R=lambda x: 1e-3 * (1.0 + 1e4 * (x @ x)) * np.eye(2),
        G=np.eye(2),
        ports={"tip": ph.SystemPort(ph.TRANSLATION, (0, 1), "force")},
        start=[0.0, 0.05],
    )
    d.add(spring)
    d.connect(beams[-1].end.translation, spring["tip"])
    return d.compile()


def test_beside_blocks_that_share_states():
    whole, cut = (ph.simulate(leaking_tip(pieces), 0.5, 0.005) for pieces in (1, 2))
    assert whole.system.sharing.trivial and not cut.system.sharing.trivial
    for solution in (whole, cut):
        at = [solution.system.state_names.index(f"spring.x{i}[0]") for i in range(2)]
        middle = ((solution.x[1:] + solution.x[:-1]) / 2.0)[:, at]
        square = (middle**2).sum(axis=1)
        lost = 0.005 * 1e-3 * (1.0 + 1e4 * square) * 400.0**2 * square
        np.testing.assert_allclose(solution.energy.dissipated[1:], np.cumsum(lost), rtol=1e-10)
        assert solution.max_power_balance_error < 1e-12 * solution.energy.total[0]
        assert np.ptp(solution.state("spring.x1[0]")) > 0.05
    # the switch of the clamped beam stands elsewhere: another discretisation; measured 1.8e-4
    np.testing.assert_allclose(cut.energy.dissipated, whole.energy.dissipated, rtol=1e-3)
