"""A block with any energy: the user's Hamiltonian with its gradient and Hessian."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from phblocks.blocks import symbolic
from phblocks.blocks.branch import lumped_form, state
from phblocks.blocks.checks import require_matrix
from phblocks.blocks.form import NO_ENERGY, Form
from phblocks.blocks.modulation import Given, Modulation, StateMatrix, typical
from phblocks.blocks.storage import Storage
from phblocks.blocks.system_block import SystemPort, Typed
from phblocks.errors import ArgumentTypeError, DataError, PhblocksError, StructureError
from phblocks.triplets import Floats, Ints, real_array

#: Relative difference between a derivative and that by differences that counts as a mistake.
DERIVATIVE = 1e-4
#: How much of the change of a difference with twice its step may be missing: 1/3 if smooth, 2.4 if like sqrt(h).
LEFT_OUT = 3.0

#: A matrix, or a function of the energy variables that returns one.
MatrixOfState = ArrayLike | Given

#: The matrices there may be.
LETTERS = "JRGPSN"

#: How many states near the start the structure is verified at, how near they are, and the step of differences there,
#: relative to the state.
NEAR, DISTANCE, STEP = 8, 0.05, 1e-5


class CustomBlock(Typed):
    """A port-Hamiltonian system with an energy and matrices of the user's.

    ``x' = (J(x) - R(x)) z + (G(x) - P(x)) u`` and ``y = (G(x) + P(x))^T z + (S(x) + N(x)) u`` with
    ``z = grad H(x)``. In the assembled system x and z are both states, and with P, S, N or a G that depends on x the
    output and the input of each column too. The energy need not be quadratic, so ``simulate`` takes
    ``DiscreteGradient()``, and refuses ``Midpoint()``.

    Each matrix is an array or a function of x. Functions are verified at the start and at states near it, and in
    ``simulate`` at the midpoint of every step: a J(x) that is not skew or an R(x) that is not positive semidefinite
    there ends the run with a status that says so.

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
    J, R : array_like or callable, optional
        Shape (n, n): skew, and symmetric positive semidefinite; zero by default.
    G, P : array_like or callable, optional
        Shape (n, m); zero by default.
    S, N : array_like or callable, optional
        Feedthrough, shape (m, m), symmetric and skew, with ``[[R, P], [P^T, S]]`` positive semidefinite; zero by
        default.
    ports : mapping of str to SystemPort, optional
        By name; together they have each of the m inputs once.
    start : array_like, optional
        x at the start, shape (n,); zero by default.
    energy : str, optional
        Kind of energy.
    units : sequence of str, optional
        SI units of x, for tables; unknown ("") by default.
    derivatives : mapping of str to callable, optional
        By the letter of a matrix that is a function: its derivative, with one more axis for the variable, so that
        entry (i, j, k) is that of (i, j) by x[k]. By default central differences, see ``StateMatrix``; they serve
        Newton's method and linear models only.

    Raises
    ------
    DataError
        If a shape does not fit, H, a derivative or a matrix is not finite at the start, or the ports do not have each
        input once.
    StructureError
        If J or N is not skew, ``[[R, P], [P^T, S]]`` not symmetric and positive semidefinite, or a derivative not one,
        seen at the start and near it.
    ArgumentTypeError
        If an argument is of the wrong kind.
    """

    makers = ("from_sympy",)
    _expression: tuple[Any, Any] | None = None

    def __init__(
        self,
        name: str,
        size: int,
        hamiltonian: Callable[[Floats], Any],
        gradient: Callable[[Floats], ArrayLike],
        hessian: Callable[[Floats], ArrayLike],
        J: MatrixOfState | None = None,
        R: MatrixOfState | None = None,
        G: MatrixOfState | None = None,
        P: MatrixOfState | None = None,
        S: MatrixOfState | None = None,
        N: MatrixOfState | None = None,
        ports: Mapping[str, SystemPort] | None = None,
        start: ArrayLike | None = None,
        energy: str = "stored",
        units: Sequence[str] | None = None,
        derivatives: Mapping[str, Given] | None = None,
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
        x = np.zeros(n) if start is None else real_array(start)
        if x is None or x.shape != (n,) or not np.isfinite(x).all():
            raise DataError(f"{self._where} start", expected=f"{n} finite numbers", got=repr(start), fix="Correct it.")
        self.start, self.energy = x, energy
        self.units = ("",) * n if units is None else tuple(units)
        if len(self.units) != n:
            raise DataError(
                f"{self._where} units", expected=f"{n} texts", got=str(len(self.units)), fix="Name one for each state."
            )
        self._require_shapes()
        m = self._take({"J": J, "R": R, "G": G, "P": P, "S": S, "N": N}, derivatives or {})
        self._check_matrices()
        self._make_ports(ports, m)
        if not all(isinstance(f, symbolic.Derived) for f in (hamiltonian, gradient, hessian)):
            self._check_derivatives()

    @classmethod
    def from_sympy(cls, name: str, hamiltonian: Any, variables: Sequence[Any], **options: Any) -> CustomBlock:
        """Make a block from expressions; all derivatives are derived.

        Parameters
        ----------
        name : str
            Unique in the diagram.
        hamiltonian : sympy.Expr
            H, with numbers for all parameters.
        variables : sequence of sympy.Symbol
            The energy variables x, in their order.
        **options : object
            J, R, G, ports and so on, as of the class; matrices may be sympy matrices in the variables.

        Returns
        -------
        CustomBlock
            The block.

        Raises
        ------
        DataError
            If an expression depends on other symbols.
        ArgumentTypeError
            If it is not an expression, or a variable not a symbol.
        """
        given = dict(options)
        where, x = f"CustomBlock {name!r}", symbolic.require_symbols(f"CustomBlock {name!r} variables", variables)
        functions = symbolic.energy_of(f"{where} hamiltonian", hamiltonian, x)
        derivatives = dict(options.pop("derivatives", None) or {})
        for letter in LETTERS:
            found = symbolic.matrix_of(f"{where} {letter}", options.get(letter), x)
            if found is not None:
                options[letter], slope = found
                if slope is not None:
                    derivatives.setdefault(letter, slope)
        block = cls(name, len(x), *functions, derivatives=derivatives, **options)
        block._expression = (tuple(x), hamiltonian)
        block._made_by("from_sympy", name, hamiltonian, tuple(x), **given)
        return block

    def _take(self, given: Mapping[str, MatrixOfState | None], derivatives: Mapping[str, Given]) -> int:
        """Keep the matrices; return the number of inputs."""
        n, m, at_start = self.start.size, 0, {}
        for letter, value in given.items():
            if value is not None:
                at_start[letter] = self._called(letter, value) if callable(value) else value
        for letter, axis in (("N", 0), ("S", 0), ("P", 1), ("G", 1)):  # the first of G, P, S, N says how many inputs
            array = real_array(at_start.get(letter))
            m = array.shape[axis] if array is not None and array.ndim == 2 else m
        shapes = {"J": (n, n), "R": (n, n), "G": (n, m), "P": (n, m), "S": (m, m), "N": (m, m)}
        self.matrices: dict[str, StateMatrix] = {}
        for letter, shape in shapes.items():
            where, function, derivative = f"{self._where} {letter}", given[letter], derivatives.get(letter)
            if derivative is not None and not (callable(function) and callable(derivative)):
                raise ArgumentTypeError(
                    f"{self._where} derivatives",
                    expected="functions, of matrices that are functions",
                    got=f"{derivative!r} for {letter} = {function!r}"[:120],
                    fix="Leave it out, or give both as functions of x.",
                )
            matrix = np.zeros(shape) if function is None else require_matrix(where, at_start[letter], shape)
            source = function if callable(function) else matrix
            self.matrices[letter] = StateMatrix(where, source, shape, self._size, derivative)
        if unknown := sorted(derivatives.keys() - shapes.keys()):
            raise DataError(
                f"{self._where} derivatives", expected="letters of J, R, G, P, S, N", got=repr(unknown), fix="Correct."
            )
        return m

    def _called(self, word: str, function: Callable[[Floats], Any]) -> Any:
        """Evaluate a function of the user's at the start."""
        try:
            return function(self.start)
        except (TypeError, ValueError, IndexError) as error:
            raise ArgumentTypeError(
                f"{self._where} {word}", expected="a function of x", got=str(error), fix="Correct it."
            ) from error

    def _check_matrices(self) -> None:
        """See that J and R are what they must be, at the start and near it, and derivatives derivatives."""
        modulation = self._modulation(np.arange(self.start.size), np.arange(self._acted))
        matrices = tuple(self.matrices.values())
        near = [at for at in self._near() if _defined(matrices, at)]
        modulation.verified(np.stack(near))
        for letter, matrix in self.matrices.items():
            for at in [] if matrix.constant else near:
                scale = typical(at, self._size)
                noise = 1e-9 * float(np.abs(matrix(at)).max(initial=0.0))
                found, wide = (matrix.differences(at, factor) * scale for factor in (1.0, 2.0))
                defect = _derivative_defect(matrix.slope(at) * scale, found, wide, noise)
                if defect is not None:
                    raise StructureError(
                        f"{self._where} derivative of {letter}",
                        expected=f"the derivative of {letter}(x)",
                        got=f"one that differs by {defect:.3g}, for variables of their size, at x = {at.tolist()}",
                        fix="Correct the function, or leave it out.",
                    )

    def _require_shapes(self) -> None:
        """See that energy and derivatives have their shapes at the start; find how large a variable is."""
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
        curvature = np.abs(self.hessian(x).diagonal())
        self._size = 1.0 / np.sqrt(np.where(curvature > 0.0, curvature, 1.0))

    def _check_derivatives(self) -> None:
        """See that the derivatives are derivatives, at the start and near it."""
        for at in self._near():
            scale = typical(at, self._size)  # products with it are all of one unit, J
            steps = STEP * np.diag(scale)
            if not all(_defined((self.hamiltonian, self.gradient), at + f * d) for d in steps for f in (-2, -1, 1, 2)):
                continue
            for word, function, derivative in (
                ("gradient", self.hamiltonian, self.gradient(at)),
                ("hessian", lambda x, scale=scale: self.gradient(x) * scale, self.hessian(at) * scale[:, None]),
            ):
                ends = np.array([[function(at + f * d) for f in (1, -1, 2, -2)] for d in steps])
                found, wide = ((ends[:, i] - ends[:, i + 1]).T / (f * 2.0 * STEP) for i, f in ((0, 1.0), (2, 2.0)))
                noise = 1e-14 / STEP * float(np.abs(ends).max())
                defect = _derivative_defect(derivative * scale, found, wide, noise)
                if defect is not None:
                    raise StructureError(
                        f"{self._where} {word}",
                        expected=f"the derivative of the {'hamiltonian' if word == 'gradient' else 'gradient'}",
                        got=f"one that differs by {defect:.3g} J, for variables of their size, at x = {at.tolist()}",
                        fix="Correct the function, or let CustomBlock.from_sympy derive it.",
                    )

    def _near(self) -> list[Floats]:
        """The start, and states around it where the energy is defined."""
        random, x = np.random.default_rng(0), self.start
        around = x + random.uniform(-DISTANCE, DISTANCE, (NEAR, x.size)) * typical(x, self._size)
        return [x, *(at for at in around if _defined((self.hamiltonian, self.gradient, self.hessian), at))]

    @property
    def _varying(self) -> bool:
        return not all(matrix.constant for matrix in self.matrices.values())

    @property
    def _through(self) -> bool:
        """Outputs and inputs are states too: the inputs act on each other, or how they act depends on x."""
        G, *others = (self.matrices[letter] for letter in "GPSN")
        return not G.constant or any(not matrix.constant or matrix(self.start).any() for matrix in others)

    @property
    def _acted(self) -> int:
        """How many states the matrices act on: z, and with feedthrough (given, taken) for each input."""
        n, m = self.start.size, len(self.matrices["S"](self.start))
        return n + 2 * m * self._through

    def _modulation(self, by: Ints, on: Ints) -> Modulation:
        letters, size = self.matrices, self._acted

        def interconnection(x: Floats) -> Floats:
            return _interconnection(size, letters["J"](x), letters["G"](x), letters["N"](x), 1.0)

        def dissipation(x: Floats) -> Floats:
            return _dissipation(size, letters["R"](x), letters["P"](x), letters["S"](x))

        def slope(x: Floats) -> Floats:
            d = {letter: matrix.slope(x) for letter, matrix in letters.items()}
            return _interconnection(size, d["J"], d["G"], d["N"], 0.0) - _dissipation(size, d["R"], d["P"], d["S"])

        names = ("[[J, G], [-G^T, -N]]", "[[R, P], [P^T, S]]") if self._through else ("J", "R")
        return Modulation(self._where, by, on, interconnection, dissipation, slope, names)

    def form(self, gives: Mapping[str, bool]) -> Form:
        """Reduce the block to its matrices and its energy.

        Parameters
        ----------
        gives : mapping of str to bool
            As typed.

        Returns
        -------
        Form
            The states x, then z, and with feedthrough (given, taken) for each input.
        """
        n, m = self.start.size, len(self.matrices["S"](self.start))
        energy, coenergy, acted = np.arange(n), np.arange(n, 2 * n), np.arange(n, n + self._acted)
        modulation = self._modulation(energy, acted)
        E, J, R = (np.zeros((n + acted.size, n + acted.size)) for _ in range(3))
        if not self._varying:
            skew, loss = modulation.interconnection(self.start), modulation.dissipation(self.start)
            J[n:, n:], R[n:, n:] = (skew - skew.T) / 2.0, (loss + loss.T) / 2.0
        runs = [state(f"x{i}", unit, self.energy) for i, unit in enumerate(self.units)]
        runs += [state(f"z{i}", f"J/({unit})" if unit else "", NO_ENERGY) for i, unit in enumerate(self.units)]
        output = np.zeros((m, n + acted.size))
        if self._through:
            runs += [state(f"given{i}", "") for i in range(m)] + [state(f"taken{i}", "") for i in range(m)]
            output[:, 2 * n : 2 * n + m] = np.eye(m)
        else:
            output[:, coenergy] = self.matrices["G"](self.start).T
        outputs = {name: (self._gives(name), output[list(port.columns)]) for name, port in self.typing.items()}
        start = np.concatenate([self.start, self.gradient(self.start), np.zeros(acted.size - n)])
        form = lumped_form(self._ports, runs, E, J, R, outputs, start)
        storage = Storage(energy, coenergy, self.hamiltonian, self.gradient, self.hessian, self._size, self._expression)
        return replace(form, storage=storage, modulation=modulation if self._varying else None)


def _defined(functions: Sequence[Callable[[Floats], Any]], x: Floats) -> bool:
    """Whether functions have finite values at a state; a logarithm need not."""
    with np.errstate(all="ignore"):
        try:
            return all(np.isfinite(function(x)).all() for function in functions)
        except PhblocksError:
            raise
        except (ValueError, ArithmeticError):
            return False


def _derivative_defect(given: Floats, found: Floats, wide: Floats, noise: float) -> float | None:
    """How far a derivative is from that by differences; none if that is round-off, or differences say nothing.

    ``wide`` is that of twice the step. Their difference is the size of what differences leave out, which may be all
    there is: a quarter of x^4 has no curvature at zero, its gradient over a step h has h^2.
    """
    defect = np.abs(given - found)
    size = np.abs(given).max(initial=0.0) + np.abs(found).max(initial=0.0)
    allowed = DERIVATIVE * size + noise + LEFT_OUT * np.abs(wide - found)
    told = np.isfinite(found).all() and np.isfinite(wide).all() and not (defect <= allowed).all()
    return float(defect.max()) if told else None


def _interconnection(size: int, J: Floats, G: Floats, N: Floats, unit: float) -> Floats:
    """Put J, G, N in place; a third axis stays the third. ``0 = u - a``, ``0 = y - G^T z - N a``."""
    n, m = G.shape[:2]
    matrix = np.zeros((size, size, *J.shape[2:]))
    matrix[:n, :n] = J
    if size > n:
        y, a = np.arange(n, n + m), slice(n + m, size)
        matrix[:n, a], matrix[a, :n], matrix[a, a] = G, -G.swapaxes(0, 1), -N
        matrix[y, y + m], matrix[y + m, y] = -unit, unit
    return matrix


def _dissipation(size: int, R: Floats, P: Floats, S: Floats) -> Floats:
    """Put R, P, S in place; a third axis stays the third."""
    n, m = P.shape[:2]
    matrix = np.zeros((size, size, *R.shape[2:]))
    matrix[:n, :n] = R
    if size > n:
        a = slice(n + m, size)
        matrix[:n, a], matrix[a, :n], matrix[a, a] = P, P.swapaxes(0, 1), S
    return matrix
