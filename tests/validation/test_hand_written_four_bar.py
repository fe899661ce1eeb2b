"""The assembled four-bar mechanism equals one written by hand from the paper.

Everything on the hand-written side is numpy and the paper: hat functions and constants, the matrices M, D, S, T of
eq. (5) and of section 3.2, the nonlinear terms of eq. (2) by Simpson's rule, and the interconnection at the end of
section 4 with the rotations between the frames of the bars inserted. Only the names of states connect the two.
"""

from dataclasses import dataclass

import numpy as np
import pytest

import phblocks as ph

SIDE, YOUNG, POISSON, DENSITY, G = 0.05, 2.1e11, 0.3, 2710.0, 9.81
AREA = SIDE**2
MASS, ROTARY = DENSITY * AREA, DENSITY * SIDE**4 / 12
COMPLIANCE = 1 / (YOUNG * AREA), 1 / (YOUNG / (2 * (1 + POISSON)) * AREA), 1 / (YOUNG * SIDE**4 / 12)
BARS = {  # start, end, elements
    "crank": ((0.0, 0.5), (2.0, 1.5), 10),
    "coupler": ((2.0, 1.5), (3.5, 1.5), 6),
    "rocker": ((3.5, 1.5), (2.5, 0.5), 6),
}
COMPONENTS = ("V1", "V2", "W3", "N1", "N2", "M3")

MID = np.array([0.0, 0.5, 1.0])  # Simpson's rule, exact for the products of three linear functions
SIMPSON = np.array([1.0, 4.0, 1.0]) / 6
GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)  # the quadrature of the positions, and so of the weight


def hats(points):
    """The two hat functions of an element at points of [0, 1], shape (points, 2)."""
    return np.stack([1 - points, points], axis=1)


@dataclass
class Bar:
    """One bar with constants or hats for each field: pinned-pinned (section 3.2) or free-free (eq. (5))."""

    n: int
    length: float
    angle: float
    pinned: bool

    def __post_init__(self):
        self.h = self.length / self.n
        hat, constant = self.n + 1, self.n
        v, f = (constant, hat) if self.pinned else (hat, constant)
        self.sizes = dict(zip(COMPONENTS, (v, v, hat, f, f, constant), strict=True))
        ends = np.cumsum(list(self.sizes.values()))
        self.of = {c: slice(e - s, e) for (c, s), e in zip(self.sizes.items(), ends, strict=True)}
        self.size = int(ends[-1])

    def values(self, component, element, points):
        """The functions of a component that live on an element, and their values at points of it."""
        if self.sizes[component] == self.n:
            return [element], np.ones((len(points), 1))
        return [element, element + 1], hats(points)

    def matrices(self):
        """M, D and the discrete cross product S of the paper."""
        n, h = self.n, self.h
        M, D = np.zeros((n + 1, n + 1)), np.zeros((n, n + 1))
        S = np.zeros((n + 1, self.sizes["N2"]))
        for e in range(n):
            M[e : e + 2, e : e + 2] += h / 6 * np.array([[2.0, 1.0], [1.0, 2.0]])
            D[e, e : e + 2] = -1.0, 1.0
            if not self.pinned:
                S[e : e + 2, e] = h / 2
        return M, D, M if self.pinned else S

    def E(self):
        M, _, _ = self.matrices()
        E = np.zeros((self.size, self.size))
        for c, factor in zip(COMPONENTS, (MASS, MASS, ROTARY, *COMPLIANCE), strict=True):
            E[self.of[c], self.of[c]] = factor * (M if self.sizes[c] == self.n + 1 else self.h * np.eye(self.n))
        return E

    def J0(self):
        """Eq. (5), or the matrix of section 3.2."""
        _, D, S = self.matrices()
        J, of = np.zeros((self.size, self.size)), self.of
        for v, f in (("V1", "N1"), ("V2", "N2")):
            J[of[v], of[f]] = D if self.pinned else -D.T
            J[of[f], of[v]] = -D.T if self.pinned else D
        J[of["W3"], of["N2"]], J[of["N2"], of["W3"]] = S, -S.T
        J[of["W3"], of["M3"]], J[of["M3"], of["W3"]] = -D.T, D
        return J

    def J_nonlinear(self, x):
        """The terms of eq. (2) that depend on the state, projected: momentum, strain and curvature in J."""
        J, weights = np.zeros((self.size, self.size)), self.h * SIMPSON
        for e in range(self.n):
            value = {}
            for c in COMPONENTS:
                places, functions = self.values(c, e, MID)
                value[c] = functions @ x[self.of[c]][places]
            momentum = [MASS * value["V1"], MASS * value["V2"]]
            strain = [COMPLIANCE[0] * value["N1"], COMPLIANCE[1] * value["N2"]]
            bend = COMPLIANCE[2] * value["M3"]
            terms = [  # row, column, coefficient
                ("V1", "W3", momentum[1]),  # S Pi_V
                ("V2", "W3", -momentum[0]),
                ("W3", "V1", -momentum[1]),  # Pi_V^T S
                ("W3", "V2", momentum[0]),
                ("V1", "N2", -bend),  # S^T K
                ("V2", "N1", bend),
                ("N1", "V2", -bend),
                ("N2", "V1", bend),
                ("W3", "N1", -strain[1]),  # Gamma^T S
                ("W3", "N2", strain[0]),
                ("N1", "W3", strain[1]),  # S Gamma
                ("N2", "W3", -strain[0]),
            ]
            for row, column, coefficient in terms:
                i, a = self.values(row, e, MID)
                j, b = self.values(column, e, MID)
                block = np.einsum("q,qi,qj->ij", weights * coefficient, a, b)
                J[np.ix_(self.of[row].start + np.array(i), self.of[column].start + np.array(j))] += block
        return J

    def port(self, at_end):
        """B of an end, shape (size, 2): T^T selects velocities, T_n^T forces with the sign of the normal."""
        B = np.zeros((self.size, 2))
        fields = ("N1", "N2") if self.pinned else ("V1", "V2")
        for i, c in enumerate(fields):
            B[self.of[c].stop - 1 if at_end else self.of[c].start, i] = 1.0 if at_end or not self.pinned else -1.0
        return B

    def weight(self, turned):
        """Discrete (psi_V, Lambda^T n_ext) with n_ext = -g rhoA e_2; ``turned``: theta - theta(0) at the nodes."""
        force = np.zeros(self.size)
        for e in range(self.n):
            theta = self.angle + hats(GAUSS) @ turned[e : e + 2]
            for c, component in (("V1", np.sin(theta)), ("V2", np.cos(theta))):
                i, a = self.values(c, e, GAUSS)
                force[self.of[c].start + np.array(i)] += -G * MASS * self.h / 2 * component @ a
        return force


def rotation(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


class HandWritten:
    """The mechanism: bars 1 and 3 pinned-pinned, bar 2 free-free."""

    def __init__(self):
        self.bars = {}
        for name, (start, end, n) in BARS.items():
            d = np.subtract(end, start)
            self.bars[name] = Bar(n, float(np.hypot(*d)), float(np.arctan2(d[1], d[0])), name != "coupler")
        ends = np.cumsum([bar.size for bar in self.bars.values()])
        self.of = {name: slice(e - bar.size, e) for (name, bar), e in zip(self.bars.items(), ends, strict=True)}
        self.size = int(ends[-1])
        self.names = [f"{b}.{c}[{i}]" for b, bar in self.bars.items() for c in COMPONENTS for i in range(bar.sizes[c])]

    def E(self):
        E = np.zeros((self.size, self.size))
        for name, bar in self.bars.items():
            E[self.of[name], self.of[name]] = bar.E()
        return E

    def J(self, x, turned):
        J = np.zeros((self.size, self.size))
        for name, bar in self.bars.items():
            J[self.of[name], self.of[name]] = bar.J0() + bar.J_nonlinear(x[self.of[name]])
        # u_V = +y_V, u_N = -y_N: the blocks +B_V B_N^T and -B_N B_V^T, with Lambda_PP^T Lambda_FF between the frames
        for pinned, pinned_end, free_end in (("crank", True, False), ("rocker", False, True)):
            a, b = self.bars[pinned], self.bars["coupler"]
            turn = rotation(a.angle + turned[pinned][-1 if pinned_end else 0]).T @ rotation(
                b.angle + turned["coupler"][-1 if free_end else 0]
            )
            coupling = a.port(pinned_end) @ turn @ b.port(free_end).T
            J[self.of[pinned], self.of["coupler"]] += coupling
            J[self.of["coupler"], self.of[pinned]] -= coupling.T
        return J

    def weight(self, turned):
        return np.concatenate([bar.weight(turned[name]) for name, bar in self.bars.items()])


@pytest.fixture(scope="module")
def hand():
    return HandWritten()


@pytest.fixture(scope="module")
def system(four_bar):
    return four_bar()


@pytest.fixture(scope="module")
def order(hand, system):
    """The state of the assembled system behind each hand-written one."""
    assert sorted(hand.names) == sorted(system.state_names)
    return np.array([system.state_names.index(name) for name in hand.names])


@pytest.fixture(params=range(3))
def sample(request, hand, system, order):
    """Random state and orientation: x and theta of the system, and the same as the hand-written mechanism has them."""
    rng = np.random.default_rng(request.param)
    size = {"V": 3.0, "W": 5.0, "N": 1e7, "M": 1e4}  # strains and curvatures of some percent
    mine = np.array([size[name.split(".")[1][0]] for name in hand.names]) * rng.standard_normal(hand.size)
    x = np.empty_like(mine)
    x[order] = mine
    theta = rng.uniform(-3.0, 3.0, system.start.theta.size)
    # theta' = rates x says which rotation state is the time integral of which angular velocity
    turned = {}
    for name, bar in hand.bars.items():
        states = [system.state_names.index(f"{name}.W3[{i}]") for i in range(bar.n + 1)]
        rows = [int(np.flatnonzero(system.rates[:, [s]].toarray())[0]) for s in states]
        turned[name] = theta[rows]
    return x, theta, mine, turned


def assert_blocks_equal(hand, ours, theirs):
    """Every block (component of a bar times component of a bar) to 1e-12 of its largest entry; zero blocks exactly."""
    places = [
        slice(hand.of[b].start + s.start, hand.of[b].start + s.stop) for b in BARS for s in hand.bars[b].of.values()
    ]
    for rows in places:
        for columns in places:
            expected, got = theirs[rows, columns], ours[rows, columns]
            assert np.abs(got - expected).max() <= 1e-12 * np.abs(expected).max(), (rows, columns)


def test_the_compiler_finds_the_papers_causality(system):
    """Section 4: bars 1 and 3 pinned-pinned, bar 2 free-free; numbers of unknowns of eq. (5)."""
    assert not system.report.switches
    for name, expected in (("crank", False), ("coupler", True), ("rocker", False)):
        gives = system.report.gives(name)
        assert gives["start.translation"] is expected and gives["end.translation"] is expected
        assert gives["start.rotation"] and gives["end.rotation"]
    assert system.n == 64 + 39 + 38


def test_E(hand, system, order):
    ours = system.E.toarray()[np.ix_(order, order)]
    assert_blocks_equal(hand, ours, hand.E())


def test_J_at_rest(hand, system, order):
    turned = {name: np.zeros(bar.n + 1) for name, bar in hand.bars.items()}
    ours = system.J().toarray()[np.ix_(order, order)]
    assert_blocks_equal(hand, ours, hand.J(np.zeros(hand.size), turned))


def test_J_of_state_and_orientation(hand, system, order, sample):
    x, theta, mine, turned = sample
    ours = system.J(x, theta).toarray()[np.ix_(order, order)]
    assert_blocks_equal(hand, ours, hand.J(mine, turned))


def test_weight(hand, system, order, sample):
    _, theta, _, turned = sample
    expected = hand.weight(turned)
    assert np.abs(system.gravity_force(theta)[order] - expected).max() <= 1e-12 * np.abs(expected).max()


def test_steps(hand, system, order):
    """Five midpoint steps of the paper's size, solved by a plain fixed-point iteration: 1e-12 in the energy norm.

    Measured: 1.5e-14.
    """
    dt, E, x = 0.02, hand.E(), np.zeros(hand.size)
    spins = {
        name: slice(hand.of[name].start + bar.of["W3"].start, hand.of[name].start + bar.of["W3"].stop)
        for name, bar in hand.bars.items()
    }
    turned = {name: np.zeros(bar.n + 1) for name, bar in hand.bars.items()}
    solution = ph.simulate(system, 5 * dt, dt)
    scale = np.sqrt(np.diag(E))
    for step in range(1, 6):
        z = x.copy()
        for _ in range(100):
            middle = {name: turned[name] + dt / 2 * z[spins[name]] for name in turned}
            new = np.linalg.solve(2 / dt * E - hand.J(z, middle), 2 / dt * E @ x + hand.weight(middle))
            change, z = np.linalg.norm(scale * (new - z)), new
            if change <= 1e-14 * np.linalg.norm(scale * z):
                break
        x = 2 * z - x
        turned = {name: turned[name] + dt * z[spins[name]] for name in turned}
        difference = np.linalg.norm(scale * (solution.x[step, order] - x))
        assert difference <= 1e-12 * np.linalg.norm(scale * x), step
