"""A block from matrices: a port-Hamiltonian system that the user brings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks.block import PortChoice, Tie
from phblocks.blocks.branch import Lumped, lumped_form, state
from phblocks.blocks.checks import require_matrix, require_semidefinite
from phblocks.blocks.form import NO_ENERGY, Form
from phblocks.errors import ArgumentTypeError, DataError, StructureError
from phblocks.ports import Domain, Port
from phblocks.space import PLANAR, Space
from phblocks.triplets import Floats, real_array

#: Relative size of a defect of symmetry or skewness that counts as round-off.
TOLERANCE = 1e-12


@dataclass(frozen=True)
class SystemPort:
    """A port of a :class:`SystemBlock`.

    Parameters
    ----------
    domain : Domain
        The pair of quantities.
    columns : sequence of int
        Which of the inputs and outputs it has: one, or two (x, y of the fixed frame) for a port of translation.
    gives : str
        Name of the quantity that is the output y, such as "velocity"; the other one is the input u. Their product
        is the power into the block.
    """

    domain: Domain
    columns: Sequence[int]
    gives: str


class Typed(Lumped):
    """A part with columns of inputs, each in one port of any type.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._where = f"{type(self).__name__} {name!r}"

    def _make_ports(self, ports: Mapping[str, SystemPort] | None, m: int) -> None:
        if ports is not None and not isinstance(ports, Mapping):
            raise ArgumentTypeError(
                f"{self._where} ports",
                expected="a mapping from names to ph.SystemPort(...)",
                got=repr(ports),
                fix='Write for instance {"shaft": ph.SystemPort(ph.ROTATION, [0], "moment")}.',
            )
        self.typing = dict(ports or {})
        used: list[int] = []
        for name, port in self.typing.items():
            where = f"{self._where} port {name!r}"
            if not isinstance(port, SystemPort) or not isinstance(port.domain, Domain):
                raise ArgumentTypeError(where, expected="a ph.SystemPort", got=repr(port), fix="Make one.")
            words = (port.domain.common.name, port.domain.summed.name)
            if port.gives not in words:
                raise DataError(
                    f"{where} gives", expected=f"{words[0]!r} or {words[1]!r}", got=repr(port.gives), fix="Choose one."
                )
            count = len(port.domain.components(PLANAR))
            if len(port.columns) != count:
                raise DataError(
                    f"{where} columns",
                    expected=f"{count} for {port.domain.name}",
                    got=repr(port.columns),
                    fix="Correct.",
                )
            used += list(port.columns)
            self._add_port(name, port.domain)
        if sorted(used) != list(range(m)):
            raise DataError(
                f"{self._where} ports",
                expected=f"each of the {m} inputs in one port",
                got=f"columns {used}",
                fix="Name every column of G once.",
            )

    @property
    def space(self) -> Space | None:
        """The plane if there is a mechanical port."""
        return PLANAR if any(p.domain.turns_with for p in self._ports) else None

    def __getitem__(self, name: str) -> Port:
        """Return the port of that name."""
        return self.ports[name]

    def _gives(self, name: str) -> bool:
        port = self.typing[name]
        return port.gives == port.domain.common.name

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that the matrices leave no choice.

        Returns
        -------
        choices : sequence of PortChoice
            One for each port.
        ties : sequence of Tie
            None.
        """
        return [PortChoice(p, may_give=self._gives(p.name), may_take=not self._gives(p.name)) for p in self._ports], []


class SystemBlock(Typed):
    """A port-Hamiltonian system in matrices, of any port typing.

    ``E x' = (J - R) Q x + (G - P) u`` and ``y = (G + P)^T Q x + (S + N) u`` with ``H = 1/2 x^T Q^T E x``. The states
    in the assembled system are the user's x: the first equation is multiplied by Q^T, which is exact for an
    invertible Q and makes E, J, R, G of the assembled system ``Q^T E``, ``Q^T J Q``, ``Q^T R Q`` and ``Q^T G``.
    Feedthrough (P, S, N) is written with two states without energy for each input: what is taken and what is given.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    E, J, R, Q : array_like
        Shape (n, n). E and Q are the identity and J and R zero by default, but J or another of n rows must be given.
    G, P : array_like, optional
        Shape (n, m); zero by default.
    S, N : array_like, optional
        Shape (m, m), symmetric and skew; zero by default.
    ports : mapping of str to SystemPort, optional
        By name; together they have each of the m inputs once.
    start : array_like, optional
        x at the start, shape (n,); zero by default.
    energy : str, optional
        Kind of energy of the states.
    units : sequence of str, optional
        SI units of the states, for tables; unknown ("") by default.

    Raises
    ------
    DataError
        If a shape does not fit, Q is singular, or the ports do not have each input once.
    StructureError
        If ``Q^T E`` or ``[[R, P], [P^T, S]]`` is not symmetric and positive semidefinite, or J or N not skew.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(
        self,
        name: str,
        E: ArrayLike | None = None,
        J: ArrayLike | None = None,
        R: ArrayLike | None = None,
        Q: ArrayLike | None = None,
        G: ArrayLike | None = None,
        P: ArrayLike | None = None,
        S: ArrayLike | None = None,
        N: ArrayLike | None = None,
        ports: Mapping[str, SystemPort] | None = None,
        start: ArrayLike | None = None,
        energy: str = "stored",
        units: Sequence[str] | None = None,
    ) -> None:
        super().__init__(name)
        n = self._size({"E": E, "J": J, "R": R, "Q": Q, "G": G, "P": P}, axis=0)
        m = self._size({"S": S, "N": N}, axis=0) if G is None and P is None else self._size({"G": G, "P": P}, axis=1)
        if n is None:
            raise DataError(self._where, expected="matrices", got="none", fix="Give at least J.")
        m = m or 0
        self.E, self.Q = self._matrix("E", E, (n, n), np.eye(n)), self._matrix("Q", Q, (n, n), np.eye(n))
        self.J, self.R = self._matrix("J", J, (n, n)), self._matrix("R", R, (n, n))
        self.G, self.P = self._matrix("G", G, (n, m)), self._matrix("P", P, (n, m))
        self.S, self.N = self._matrix("S", S, (m, m)), self._matrix("N", N, (m, m))
        self._verify()
        x = np.zeros(n) if start is None else real_array(start)
        if x is None or x.shape != (n,) or not np.isfinite(x).all():
            raise DataError(f"{self._where} start", expected=f"{n} finite numbers", got=repr(start), fix="Correct it.")
        self.start, self.energy = x, energy
        self.units = ("",) * n if units is None else tuple(units)
        if len(self.units) != n:
            raise DataError(
                f"{self._where} units", expected=f"{n} texts", got=str(len(self.units)), fix="Name one for each state."
            )
        self._make_ports(ports, m)

    def _size(self, given: Mapping[str, ArrayLike | None], axis: int) -> int | None:
        for letter, value in given.items():
            if value is not None:
                array = real_array(value)
                if array is None:
                    raise ArgumentTypeError(
                        f"{self._where} {letter}", expected="a matrix", got=repr(value), fix="Give numbers."
                    )
                if array.ndim != 2:
                    raise DataError(
                        f"{self._where} {letter}", expected="a matrix", got=f"shape {array.shape}", fix="Correct it."
                    )
                return int(array.shape[axis])
        return None

    def _matrix(
        self, letter: str, value: ArrayLike | None, shape: tuple[int, int], otherwise: Floats | None = None
    ) -> Floats:
        if value is None:
            return np.zeros(shape) if otherwise is None else otherwise
        return require_matrix(f"{self._where} {letter}", value, shape)

    def _verify(self) -> None:
        if self.Q.size and np.linalg.cond(self.Q) > 1e13:
            raise DataError(
                f"{self._where} Q",
                expected="an invertible matrix",
                got="a singular one",
                fix="Leave out states that act on nothing; give multipliers a row of zeros in E, not in Q.",
            )
        require_semidefinite(f"{self._where} Q^T E", self.Q.T @ self.E)
        for letter, matrix in (("J", self.J), ("N", self.N)):
            defect = np.abs(matrix + matrix.T).max(initial=0.0)
            if defect > TOLERANCE * np.abs(matrix).max(initial=0.0):
                raise StructureError(
                    f"{self._where} {letter}",
                    expected="a skew matrix",
                    got=f"a defect of {defect:.3g}",
                    fix="Move the symmetric part to R (of J) or S (of N), with the opposite sign in R.",
                )
        for letter, matrix in (("R", self.R), ("S", self.S)):
            require_semidefinite(f"{self._where} {letter}", matrix)
        require_semidefinite(f"{self._where} [[R, P], [P^T, S]]", np.block([[self.R, self.P], [self.P.T, self.S]]))
        mass = self.Q.T @ self.E
        idle = ~mass.any(axis=0)
        kept = mass[~idle][:, ~idle]
        if kept.size:
            size = np.linalg.eigvalsh(kept / np.sqrt(np.outer(kept.diagonal(), kept.diagonal())))
            if size[0] < 1e-14:
                raise DataError(
                    f"{self._where} Q^T E",
                    expected="a definite matrix, or rows of zeros for the states without energy",
                    got="a singular combination of states",
                    fix="Transform the states so that those without energy stand alone.",
                )

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the block to its matrices.

        Parameters
        ----------
        gives : mapping of str to bool
            As typed.

        Returns
        -------
        Form
            The states x, and with feedthrough (given, taken) for each input.
        """
        n, m = self.G.shape
        Q = self.Q
        through = bool(self.P.any() or self.S.any() or self.N.any())
        size = n + 2 * m * through
        E, J, R = (np.zeros((size, size)) for _ in range(3))
        mass, skew, loss = Q.T @ self.E, Q.T @ self.J @ Q, Q.T @ self.R @ Q
        E[:n, :n], J[:n, :n], R[:n, :n] = (mass + mass.T) / 2, (skew - skew.T) / 2, (loss + loss.T) / 2
        x, y, a = slice(0, n), slice(n, n + m), slice(n + m, n + 2 * m)
        runs = [state(f"x{i}", unit, self.energy if mass[i].any() else NO_ENERGY) for i, unit in enumerate(self.units)]
        output = np.zeros((m, size))
        if through:
            # 0 = u - a;  0 = y - (G + P)^T Q x - (S + N) a
            runs += [state(f"given{i}", "") for i in range(m)] + [state(f"taken{i}", "") for i in range(m)]
            J[x, a], J[a, x] = Q.T @ self.G, -self.G.T @ Q
            R[x, a], R[a, x] = Q.T @ self.P, self.P.T @ Q
            J[y, a], J[a, y] = -np.eye(m), np.eye(m)
            J[a, a], R[a, a] = -self.N, self.S
            output[:, y] = np.eye(m)
        else:
            output[:, x] = self.G.T @ Q
        outputs = {name: (self._gives(name), output[list(port.columns)]) for name, port in self.typing.items()}
        start = np.concatenate([self.start, np.zeros(size - n)])
        return lumped_form(self._ports, runs, E, J, R, outputs, start)
