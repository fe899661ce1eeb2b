"""Systems in sympy: the numeric and the symbolic twin agree, and hand-derived expressions come out."""

import numpy as np
import pytest
import sympy

import phblocks as ph
from phblocks.errors import ArgumentTypeError, DataError, StructureError
from phblocks.system.laurent import terms_of


def oscillator(mass=3.0, compliance=1 / 48, damping=0.5) -> ph.Diagram:
    """A mass on a spring and a damper along a line, pulled by a force."""
    line = ph.Domain("line", ph.Quantity("velocity", "m/s"), ph.Quantity("force", "N"))
    d = ph.Diagram("oscillator")
    wall = d.add(ph.Reference("wall", line))
    m = d.add(ph.Capacitor("m", mass, domain=line, energy="kinetic"))
    k = d.add(ph.Inductor("k", compliance, domain=line))
    c = d.add(ph.Resistor("c", damping, domain=line))
    d.connect(m.p, k.p, c.p)
    for part in (m, k, c):
        d.connect(part.n, wall.port)
    d.expose(m.p, "pull", imposes="force")
    return d


def pendulum() -> ph.Diagram:
    """A rigid body that hangs by a spring, which turns, with a torsion spring: lines, gravity, levers."""
    d = ph.Diagram("pendulum", gravity=(0.0, -9.81))
    body = d.add(ph.RigidBody("body", ph.Parameter("m", 2.0), ph.Parameter("I", 0.3), (0.0, -1.0), {"a": (0.25, -0.5)}))
    spring = d.add(ph.Spring("spring", ph.Parameter("k", 400.0), (0.0, 0.0), (0.25, -0.5), ph.Parameter("l", 0.5)))
    d.pin(spring.start, d.ground)
    d.connect(spring.end.translation, body["a"].translation)
    twist = d.add(ph.TorsionSpring("twist", ph.Parameter("kt", 7.0)))
    d.connect(twist.first, d.ground.rotation)
    d.connect(twist.second, body.centre.rotation)
    d.expose(body["a"].translation, "push")
    return d


def assert_twins(system: ph.System, values=None, seed=0) -> None:
    """All matrices, energy and the residual of the equations at a random state, by lambdify."""
    s = system.symbolic()
    numeric = system if values is None else system.remake(values)
    rng = np.random.default_rng(seed)
    x = numeric.start.x + 0.3 * rng.normal(size=system.n)
    theta = 0.5 * rng.normal(size=system.start.theta.size)
    u, rates = rng.normal(size=system.n_inputs), rng.normal(size=len(s.rates))
    names = {t.name for t in s.theta}
    kept = [theta[i] for i, n in enumerate(_legal(system.theta_names, s)) if n in names]
    numbers = {p: (values or {}).get(p.name, v) for p, v in s.parameters.items()}
    arguments = [*s.x, *s.theta, *s.u, *s.rates, *s.parameters]
    given = [*x, *kept, *u, *rates, *numbers.values()]

    def evaluated(expression):
        return np.array(sympy.lambdify(arguments, expression, "numpy")(*given), dtype=float)

    n = system.n
    for found, expected in (
        (s.E, numeric.rate_matrix.toarray()),
        (s.J, numeric.J(x, theta).toarray()),
        (s.R, numeric.R_at(x).toarray()),
        (s.G, numeric.G(theta, x).toarray()),
        (s.f, numeric.gravity_force(theta)[:, None]),
    ):
        if 0 not in found.shape:
            np.testing.assert_allclose(
                evaluated(found), expected, rtol=1e-11, atol=1e-11 * np.abs(expected).max(initial=1e-300)
            )
    assert evaluated(s.hamiltonian) == pytest.approx(numeric.energy(x), rel=1e-11)
    residual = evaluated(sympy.Matrix([e.lhs - e.rhs for e in s.equations])).ravel()
    expected = numeric.rate_matrix @ rates[:n] - numeric.force(x, theta, u)
    np.testing.assert_allclose(residual[:n], expected, rtol=1e-9, atol=1e-10 * np.abs(expected).max())
    if system.n_inputs:
        np.testing.assert_allclose(evaluated(s.outputs).ravel(), numeric.G(theta, x).T @ x, rtol=1e-10, atol=1e-12)


def _legal(names, s):
    from phblocks.system.symbolic import _free

    return _free(names, {p.name: p for p in s.parameters})


@pytest.mark.parametrize("name", ["arm", "shaken", "frame"])
def test_scenes_in_symbols(scenes, name, bar):
    system = scenes[name].compile()
    if system.n > 60:
        with pytest.raises(DataError, match="at most 60 states"):
            system.symbolic()
    else:
        assert_twins(system)


@pytest.mark.parametrize("values", [None, {"m": 3.3, "I": 0.11, "k": 91.0, "l": 0.62, "kt": 2.0}])
def test_parameters_are_kept(values):
    assert_twins(pendulum().compile(), values)


def test_the_oscillator_by_hand():
    """H = 1/2 m v^2 + 1/2 N^2/k and m v' = -N - F_c + u."""
    system = oscillator(ph.Parameter("m", 3.0), ph.Parameter("a", 0.02), ph.Parameter("r", 0.5)).compile()
    s = system.symbolic()
    m, a, r = (next(p for p in s.parameters if p.name == name) for name in "mar")
    named = {symbol.name: symbol for symbol in s.x}
    v, N = named["m_velocity_0"], named["k_force_0"]
    assert sympy.simplify(s.hamiltonian - (m * v**2 + a * N**2) / 2) == 0
    assert s.R.free_symbols == {r} and s.J.free_symbols == set()
    assert s.parameters == {m: 3.0, a: 0.02, r: 0.5}
    latex = s.latex()
    assert r"\dot{" in latex and latex.startswith("\\begin{aligned}\nH &= ") and r"\frac{" in latex
    assert latex.count("&=") == 1 + len(s.equations)
    assert_twins(system, {"m": 1.5})


def test_numbers_are_fractions_where_they_are():
    s = oscillator().compile().symbolic()
    assert s.parameters == {} and s.E.atoms(sympy.Float) == set()
    assert sympy.Rational(1, 48) in s.E.atoms(sympy.Rational)


def test_an_energy_of_the_users():
    q, p = sympy.symbols("q p")
    d = ph.Diagram("custom")
    d.add(ph.CustomBlock.from_sympy("c", p**2 / 2 - sympy.cos(q), (q, p), J=[[0, 1], [-1, 0]], start=(1.0, 0.5)))
    system = d.compile()
    s = system.symbolic()
    assert s.hamiltonian == s.x[1] ** 2 / 2 - sympy.cos(s.x[0])
    assert_twins(system)


@pytest.mark.parametrize(
    "block",
    [
        ph.CustomBlock("c", 1, lambda x: x[0] ** 2, lambda x: 2 * x, lambda x: [[2.0]]),
        ph.CustomBlock.from_sympy(
            "c", sympy.Symbol("q") ** 2, [sympy.Symbol("q")], R=sympy.Matrix([[sympy.Symbol("q") ** 2]])
        ),
    ],
    ids=["energy", "matrix"],
)
def test_functions_are_refused(block):
    d = ph.Diagram("custom")
    d.add(block)
    with pytest.raises(StructureError, match="functions of the user's"):
        d.compile().symbolic()


def test_a_parameter_that_is_no_power_is_refused():
    """The angle of a body enters by arms that are turned: sines and cosines."""
    d = ph.Diagram("turned", gravity=(0.0, -9.81))
    body = d.add(ph.RigidBody("b", 1.0, 0.1, (0, 0), {"a": (0.3, 0.2)}, angle=ph.Parameter("phi", 0.4)))
    d.expose(body["a"].translation, "push")
    with pytest.raises(StructureError, match="phi: expected matrices in sums of products of powers"):
        d.compile().symbolic()


def test_one_name_one_value():
    d = ph.Diagram("two")
    for i in (1, 2):
        d.add(ph.Mass(f"m{i}", ph.Parameter("m", float(i)), (0, 0)))
    with pytest.raises(DataError, match="expected one value"):
        d.compile().symbolic()


def test_parameter_is_a_number(tmp_path):
    import copy
    import pickle

    p = ph.Parameter("m", 2.0)
    assert p == 2.0 and isinstance(p, float) and repr(p) == "Parameter('m', 2.0)"
    for other in (pickle.loads(pickle.dumps(p)), copy.deepcopy(p)):
        assert (other, other.symbol) == (2.0, "m")
    d = pendulum()
    back = ph.load(d.save(tmp_path / "p.json"))
    assert {q.name for q in back.compile().symbolic().parameters} == {"m", "I", "k", "l", "kt"}
    for arguments in (("m", 0.0), ("m", float("nan")), ("a b", 1.0)):
        with pytest.raises(DataError):
            ph.Parameter(*arguments)
    for arguments in ((3, 1.0), ("m", "1")):
        with pytest.raises(ArgumentTypeError):
            ph.Parameter(*arguments)


def test_terms_by_hand():
    """a b + 2/a, 3 b^2, 5: seen from values alone."""

    def numbers(changed):
        a, b = changed.get("a", 2.0), changed.get("b", 7.0)
        return np.array([a * b + 2 / a, 3 * b**2, 5.0])

    found = terms_of(numbers, {"a": 2.0, "b": 7.0}, "here")
    assert found.keys() == {0, 1}
    assert found[0].keys() == {(1, 1), (-1, 0)}
    assert found[0][1, 1] == pytest.approx(1.0) and found[0][-1, 0] == pytest.approx(2.0)
    assert found[1] == {(0, 2): pytest.approx(3.0)}
    with pytest.raises(StructureError, match=r"here: a: .*another kind"):
        terms_of(lambda c: np.array([np.sin(c.get("a", 2.0))]), {"a": 2.0}, "here")
