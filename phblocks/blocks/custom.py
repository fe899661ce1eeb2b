"""A block with any energy: the user's Hamiltonian with its gradient and Hessian."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks.branch import lumped_form, state
from phblocks.blocks.checks import require_matrix, require_semidefinite
from phblocks.blocks.form import NO_ENERGY, Form
from phblocks.blocks.storage import Storage
from phblocks.blocks.system_block import TOLERANCE, SystemPort, Typed
from phblocks.errors import ArgumentTypeError, DataError, StructureError
from phblocks.triplets import Floats, real_array

#: Relative difference between a derivative and that by differences that counts as a mistake.
DERIVATIVE = 1e-4


class CustomBlock(Typed):
    """A port-Hamiltonian system with an energy of the user's, ``x' = (J - R) grad H(x) + G u``, ``y = G^T grad H(x)``.

    In the assembled system x and ``z = grad H(x)`` are both states. The energy need not be quadratic, so ``simulate``
    takes ``DiscreteGradient()``, and refuses ``Midpoint()``.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    size : int
        Number n of energy variables x.
    hamiltonian : callable
        H(x), J, for x of shape (n,).
    gradient : callable
        Of H, shape (n,).
    hessian : callable
        Of H, shape (n, n).
    J, R : array_like, optional
        Shape (n, n): skew, and symmetric positive semidefinite; zero by default.
    G : array_like, optional
        Shape (n, m); zero by default.
    ports : mapping of str to SystemPort, optional
        By name; together they have each of the m inputs once.
    start : array_like, optional
        x at the start, shape (n,); zero by default.
    energy : str, optional
        Kind of energy.
    units : sequence of str, optional
        SI units of x, for tables; unknown ("") by default.

    Raises
    ------
    DataError
        If a shape does not fit, H or a derivative is not finite at the start, or the ports do not have each input
        once.
    StructureError
        If J is not skew, R not symmetric and positive semidefinite, or gradient and Hessian are not the derivatives
        of H, seen near the start.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    def __init__(
        self,
        name: str,
        size: int,
        hamiltonian: Callable[[Floats], Any],
        gradient: Callable[[Floats], ArrayLike],
        hessian: Callable[[Floats], ArrayLike],
        J: ArrayLike | None = None,
        R: ArrayLike | None = None,
        G: ArrayLike | None = None,
        ports: Mapping[str, SystemPort] | None = None,
        start: ArrayLike | None = None,
        energy: str = "stored",
        units: Sequence[str] | None = None,
    ) -> None:
        super().__init__(name)
        if isinstance(size, bool) or not isinstance(size, (int, np.integer)) or size < 1:
            error = (
                DataError if isinstance(size, (int, np.integer)) and not isinstance(size, bool) else ArgumentTypeError
            )
            raise error(f"{self._where} size", expected="a positive integer", got=repr(size), fix="Count the states.")
        n = int(size)
        for word, function in (("hamiltonian", hamiltonian), ("gradient", gradient), ("hessian", hessian)):
            if not callable(function):
                raise ArgumentTypeError(
                    f"{self._where} {word}", expected="a function of x", got=repr(function), fix="Write a function."
                )
        self.hamiltonian: Callable[[Floats], float] = lambda x: float(hamiltonian(x))
        self.gradient: Callable[[Floats], Floats] = lambda x: np.asarray(gradient(x), dtype=float)
        self.hessian: Callable[[Floats], Floats] = lambda x: np.asarray(hessian(x), dtype=float)
        none = np.zeros((n, n))
        self.J = none if J is None else require_matrix(f"{self._where} J", J, (n, n))
        self.R = none if R is None else require_matrix(f"{self._where} R", R, (n, n))
        given = None if G is None else real_array(G)
        columns = given.shape[1] if given is not None and given.ndim == 2 else 0
        self.G = np.zeros((n, 0)) if G is None else require_matrix(f"{self._where} G", G, (n, columns))
        x = np.zeros(n) if start is None else real_array(start)
        if x is None or x.shape != (n,) or not np.isfinite(x).all():
            raise DataError(f"{self._where} start", expected=f"{n} finite numbers", got=repr(start), fix="Correct it.")
        self.start, self.energy = x, energy
        self.units = ("",) * n if units is None else tuple(units)
        if len(self.units) != n:
            raise DataError(
                f"{self._where} units", expected=f"{n} texts", got=str(len(self.units)), fix="Name one for each state."
            )
        defect = np.abs(self.J + self.J.T).max()
        if defect > TOLERANCE * np.abs(self.J).max():
            raise StructureError(
                f"{self._where} J",
                expected="a skew matrix",
                got=f"a defect of {defect:.3g}",
                fix="Move the symmetric part to R, with the opposite sign.",
            )
        require_semidefinite(f"{self._where} R", self.R)
        self._check_energy()
        self._make_ports(ports, self.G.shape[1])

    @classmethod
    def from_sympy(cls, name: str, hamiltonian: Any, variables: Sequence[Any], **options: Any) -> CustomBlock:
        """Make a block from an expression; gradient and Hessian are derived.

        Parameters
        ----------
        name : str
            Unique in the diagram.
        hamiltonian : sympy.Expr
            H, with numbers for all parameters.
        variables : sequence of sympy.Symbol
            The energy variables x, in their order.
        **options : object
            J, R, G, ports and so on, as of the class.

        Returns
        -------
        CustomBlock
            The block.

        Raises
        ------
        DataError
            If the expression depends on other symbols.
        ArgumentTypeError
            If it is not an expression, or a variable not a symbol.
        """
        import sympy

        where, x = f"CustomBlock {name!r}", list(variables)
        if not isinstance(hamiltonian, sympy.Expr):
            raise ArgumentTypeError(
                f"{where} hamiltonian", expected="a sympy expression", got=repr(hamiltonian), fix="Write one."
            )
        if not all(isinstance(symbol, sympy.Symbol) for symbol in x):
            raise ArgumentTypeError(
                f"{where} variables", expected="sympy symbols", got=repr(variables), fix="Use sympy.symbols."
            )
        others = sorted(str(symbol) for symbol in hamiltonian.free_symbols - set(x))
        if others:
            raise DataError(
                f"{where} hamiltonian",
                expected="an expression in the variables alone",
                got=f"one in {', '.join(others)} too",
                fix="Substitute numbers for the parameters.",
            )
        slopes = [hamiltonian.diff(a) for a in x]
        value, first, second = (
            sympy.lambdify([x], expression, modules="numpy", cse=True)
            for expression in (hamiltonian, slopes, [[slope.diff(b) for b in x] for slope in slopes])
        )
        return cls(name, len(x), value, first, second, **options)

    def _check_energy(self) -> None:
        """See that the derivatives have their shapes and are derivatives, at the start and near it."""
        n, x = self.start.size, self.start
        for word, function, shape in (
            ("hamiltonian", self.hamiltonian, ()),
            ("gradient", self.gradient, (n,)),
            ("hessian", self.hessian, (n, n)),
        ):
            try:
                value = np.asarray(function(x))
            except (TypeError, ValueError) as error:
                raise ArgumentTypeError(
                    f"{self._where} {word}", expected=f"numbers of shape {shape}", got=str(error), fix="Correct it."
                ) from error
            if value.shape != shape or not np.isfinite(value).all():
                got = f"shape {value.shape}" if value.shape != shape else "numbers that are not finite at the start"
                raise DataError(f"{self._where} {word}", expected=f"shape {shape}", got=got, fix="Correct it.")
        step = 1e-5 * (1.0 + np.abs(x))
        for at in (x, x + 1e3 * step * np.cos(np.arange(1, n + 1))):
            for word, function, derivative in (
                ("gradient", self.hamiltonian, self.gradient(at)),
                ("hessian", self.gradient, self.hessian(at)),
            ):
                ends = [(np.asarray(function(at + d)), np.asarray(function(at - d))) for d in np.diag(step)]
                found = np.stack([(b - a) / (2.0 * h) for (b, a), h in zip(ends, step, strict=True)], axis=-1)
                size = np.abs(derivative).max() + np.abs(found).max()
                round_off = 1e-15 * max(np.abs(b).max() for b, _ in ends) / step.min()
                defect = np.abs(found - derivative).max()
                if np.isfinite(found).all() and defect > DERIVATIVE * size + 10.0 * round_off + 1e-8:
                    raise StructureError(
                        f"{self._where} {word}",
                        expected=f"the derivative of the {'hamiltonian' if word == 'gradient' else 'gradient'}",
                        got=f"one that differs by {defect:.3g} at x = {at.tolist()}",
                        fix="Correct the function, or let CustomBlock.from_sympy derive it.",
                    )

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the block to its matrices and its energy.

        Parameters
        ----------
        gives : mapping of str to bool
            As typed.

        Returns
        -------
        Form
            The states x, then z.
        """
        n = self.start.size
        E, J, R = (np.zeros((2 * n, 2 * n)) for _ in range(3))
        J[n:, n:], R[n:, n:] = (self.J - self.J.T) / 2.0, (self.R + self.R.T) / 2.0
        runs = [state(f"x{i}", unit, self.energy) for i, unit in enumerate(self.units)]
        runs += [state(f"z{i}", f"J/({unit})" if unit else "", NO_ENERGY) for i, unit in enumerate(self.units)]
        output = np.hstack([np.zeros_like(self.G.T), self.G.T])
        outputs = {name: (self._gives(name), output[list(port.columns)]) for name, port in self.typing.items()}
        form = lumped_form(self._ports, runs, E, J, R, outputs, np.concatenate([self.start, self.gradient(self.start)]))
        curvature = np.abs(self.hessian(self.start).diagonal())
        size = 1.0 / np.sqrt(np.where(curvature > 0.0, curvature, 1.0))
        energy = np.arange(n)
        storage = Storage(energy, energy + n, self.hamiltonian, self.gradient, self.hessian, size)
        return replace(form, storage=storage)
