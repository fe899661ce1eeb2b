"""Small systems in sympy: matrices, energy and equations, with the parameters of blocks as symbols."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from phblocks.blocks.parameter import parameters_in
from phblocks.errors import DataError, StructureError
from phblocks.export.statespace import legal_names
from phblocks.system.laurent import terms_of
from phblocks.triplets import Floats

if TYPE_CHECKING:
    from phblocks.system.system import System

#: Systems with more states are not small: expressions would fill pages.
MOST_STATES = 60


@dataclass(frozen=True, eq=False)
class SymbolicSystem:
    """A system in sympy: ``E x' = (J - R + V) x - dH + f + (G + Vu) u``, ``theta' = W x + Wu u``, ``y = G^T x``.

    V and Vu are the rates of spans. dH and the zeros in E for it are there where an energy is not quadratic: the
    gradient in the rows of its variables, see ``docs/theory.md``.

    Parameters
    ----------
    name : str
        Of the system.
    x, theta, u : tuple of sympy.Symbol
        States, rotation states (those that something depends on) and inputs.
    rates : tuple of sympy.Symbol
        Derivatives of x and theta by time.
    parameters : mapping of sympy.Symbol to float
        Symbols of parameters, and their values.
    E, J, R, V, G, Vu : sympy.Matrix
        Functions of x, theta and the parameters. E has ones for spans.
    f : sympy.Matrix
        Gravity, one column.
    dH : sympy.Matrix
        Gradients of energies that are not quadratic, one column.
    hamiltonian : sympy.Expr
        The stored energy, J, without the potential of gravity.
    equations : tuple of sympy.Eq
        One for each of x and theta.
    outputs : sympy.Matrix
        y, one column.
    """

    name: str
    x: tuple[Any, ...]
    theta: tuple[Any, ...]
    u: tuple[Any, ...]
    rates: tuple[Any, ...]
    parameters: Mapping[Any, float]
    E: Any
    J: Any
    R: Any
    V: Any
    G: Any
    Vu: Any
    f: Any
    dH: Any
    hamiltonian: Any
    equations: tuple[Any, ...]
    outputs: Any

    def latex(self) -> str:
        r"""Write energy and equations in LaTeX.

        Returns
        -------
        str
            An ``aligned`` block for use in mathematics, with a dot for derivatives.
        """
        import sympy

        names = {s: sympy.latex(s) for s in (*self.x, *self.theta)}
        dots = {r: rf"\dot{{{names[s]}}}" for r, s in zip(self.rates, names, strict=True)}
        lines = [rf"H &= {sympy.latex(self.hamiltonian)}"]
        for equation in self.equations:
            left, right = (sympy.latex(side, symbol_names=dots) for side in (equation.lhs, equation.rhs))
            lines.append(rf"{left} &= {right}")
        body = " \\\\\n".join(lines)
        return f"\\begin{{aligned}}\n{body}\n\\end{{aligned}}"


def symbolic(system: System) -> SymbolicSystem:
    """Write a system in sympy; see :meth:`System.symbolic`.

    Parameters
    ----------
    system : System
        The system.

    Returns
    -------
    SymbolicSystem
        The same in symbols.

    Raises
    ------
    DataError
        If it has more than 60 states.
    StructureError
        If matrices are functions of the user's, an energy is not an expression, or a parameter enters in another way
        than by powers.
    """
    import sympy

    where = f"symbolic {system.name!r}"
    if system.n > MOST_STATES:
        fix = "Take fewer elements, or export the matrices."
        raise DataError(where, expected=f"at most {MOST_STATES} states", got=str(system.n), fix=fix)
    if system.modulations or any(s.expression is None for s in system.storages):
        raise StructureError(
            where,
            expected="energies that are expressions, and matrices that do not depend on the state by functions",
            got="functions of the user's",
            fix="Make the block with CustomBlock.from_sympy and constant J, R, G.",
        )
    values = _parameters(system)
    symbols = {name: sympy.Symbol(name, real=True) for name in values}
    x, theta, u = (
        tuple(sympy.Symbol(name, real=True) for name in _free(names, symbols))
        for names in (system.state_names, system.theta_names, [f"u {system.input_names[i]}" for i in system.acting])
    )
    arrays = dict(_arrays(system))
    found = _entries(system, arrays, values, symbols, where)
    phi = _features(system, x, theta, found)
    n, m = system.n, system.acting.size

    def contracted(key: str, vector: list[Any], shape: tuple[int, int]) -> Any:
        matrix = sympy.zeros(*shape)
        for (i, j, k), value in found[key].items():
            matrix[i, j] += value * vector[k]
        return matrix

    def plain(key: str, shape: tuple[int, int]) -> Any:
        matrix = sympy.zeros(*shape)
        for (i, j), value in found[key].items():
            matrix[i, j] = value
        return matrix

    J = plain("J0", (n, n)) + contracted("T", list(x), (n, n)) + contracted("K", phi, (n, n))
    E, R, V = plain("E", (n, n)), plain("R0", (n, n)), contracted("V", phi, (n, n))
    G, Vu = plain("G0", (n, m)) + contracted("Ku", phi, (n, m)), plain("Vu", (n, m))
    f = plain("Kg", (n, len(phi))) * sympy.Matrix(phi)
    state, inputs = sympy.Matrix(n, 1, x), sympy.Matrix(m, 1, u)
    energy, dH = (state.T * plain("energy", (n, n)) * state)[0, 0] / 2, sympy.zeros(n, 1)
    for storage in system.storages:
        assert storage.expression is not None
        variables, expression = storage.expression
        own = expression.subs(dict(zip(variables, (x[i] for i in storage.energy), strict=True)), simultaneous=True)
        energy += own
        for i in storage.energy:
            dH[i] = own.diff(x[i])
    used = [i for i, s in enumerate(theta) if any(entry.has(s) for matrix in (J, V, G, f) for entry in matrix)]
    rates = tuple(sympy.Symbol(f"{s.name}_dot", real=True) for s in (*x, *(theta[i] for i in used)))
    right = (J - R + V) * state - dH + f + (G + Vu) * inputs
    left = E * sympy.Matrix(n, 1, rates[:n])
    W, Wu = plain("rates", (len(theta), n)), plain("input_rates", (len(theta), m))
    turning = W * state + Wu * inputs
    equations = [sympy.Eq(left[i], right[i], evaluate=False) for i in range(n)]
    equations += [sympy.Eq(rates[n + k], turning[i], evaluate=False) for k, i in enumerate(used)]
    return SymbolicSystem(
        name=system.name,
        x=x,
        theta=tuple(theta[i] for i in used),
        u=u,
        rates=rates,
        parameters={symbols[name]: value for name, value in values.items()},
        **{"E": E, "J": J, "R": R, "V": V, "G": G, "Vu": Vu, "f": f, "dH": dH},
        hamiltonian=energy,
        equations=tuple(equations),
        outputs=G.T * state,
    )


def _parameters(system: System) -> dict[str, float]:
    """The parameters of all blocks by name; none if the system cannot be made again with other values."""
    values: dict[str, float] = {}
    for part in system.parts if system.remake is not None else ():
        for parameter in parameters_in(part.block.arguments):
            if values.setdefault(parameter.symbol, float(parameter)) != float(parameter):
                raise DataError(
                    f"parameter {parameter.symbol!r}",
                    expected="one value",
                    got=f"{values[parameter.symbol]!r} and {float(parameter)!r}",
                    fix="Choose another name for one of them.",
                )
    return values


def _free(names: Any, taken: Mapping[str, Any]) -> list[str]:
    """Legal names that no parameter has."""
    return legal_names([*taken, *names])[len(taken) :]


def _arrays(system: System) -> Iterator[tuple[str, Any]]:
    """All constant arrays, by name, as dense ones or as coordinates of a fixed pattern."""
    n, f, acting = system.n, system.n_features, system.acting
    yield "E", system.rate_matrix.toarray()
    yield "energy", system.E.toarray()
    for key in ("J0", "R0", "rates"):
        yield key, getattr(system, key).toarray()
    for key in ("G0", "input_rates"):
        yield key, getattr(system, key).toarray()[:, acting]
    yield "Vu", system.kinematics_u.toarray()[:, acting]
    yield "T", _dense(tuple(system.T.coords), system.T.data, (n, n, n))
    yield "K", _dense(system.K.indices, system.K.values, (n, n, f))
    yield "V", _dense(system.kinematics.indices, system.kinematics.values, (n, n, f))
    yield "Ku", _dense(system.K_u.indices, system.K_u.values, (n, system.n_inputs, f))[:, acting]
    yield "Kg", _dense(system.K_g.indices, system.K_g.values, (n, f))
    yield "alpha0", system.angles.reference
    yield "beta0", system.lines.frames.reference
    yield "free", system.lines.free
    yield "stretch", sp.csr_array(system.lines.stretch).toarray()


def _dense(indices: Any, values: Floats, shape: tuple[int, ...]) -> Floats:
    array = np.zeros(shape)
    np.add.at(array, tuple(indices), values)
    return array


def _entries(
    system: System, arrays: Mapping[str, Any], values: Mapping[str, float], symbols: Mapping[str, Any], where: str
) -> dict[str, dict[tuple[int, ...], Any]]:
    """All entries that are not zero, as numbers or expressions of the parameters, by array and place."""
    import sympy

    def numbers(changed: Mapping[str, float]) -> Floats:
        assert system.remake is not None
        other = system.remake(changed) if changed else system
        if other.state_names != system.state_names:
            fix = "Give plain numbers."
            raise StructureError(where, expected="the same states for other values", got="others", fix=fix)
        return np.concatenate([np.ravel(array) for _, array in _arrays(other)])

    terms = terms_of(numbers, values, where) if values else {}
    found: dict[str, dict[tuple[int, ...], Any]] = {}
    first = 0
    for key, array in arrays.items():
        flat, entries = np.ravel(array), {}
        moving = [p - first for p in terms if first <= p < first + flat.size]
        for place in sorted({*np.flatnonzero(flat).tolist(), *moving}):
            at = tuple(int(i) for i in np.unravel_index(place, array.shape))
            if first + place in terms:
                entries[at] = sympy.Add(
                    *(
                        _number(c) * sympy.prod([s**p for s, p in zip(symbols.values(), powers, strict=True)])
                        for powers, c in terms[first + place].items()
                    )
                )
            else:
                entries[at] = _number(float(flat[place]))
        found[key], first = entries, first + flat.size
    return found


def _number(value: float) -> Any:
    """A fraction of small integers where it is one, else the number with all its digits."""
    import sympy

    simple = Fraction(value).limit_denominator(1000)
    if abs(float(simple) - value) <= 1e-13 * abs(value) and simple:
        return sympy.Rational(simple.numerator, simple.denominator)
    return sympy.Float(value, 17)


def _features(system: System, x: Any, theta: Any, found: Mapping[str, Any]) -> list[Any]:
    """Phi, with cosines and sines of the angles, and directions of lines."""
    import sympy

    def angles(rows: Any, key: str) -> list[Any]:
        result = [found[key].get((i,), sympy.Integer(0)) for i in range(rows.shape[0])]
        entries = rows.tocoo()
        for i, j, value in zip(*entries.coords, entries.data, strict=True):
            result[i] += _number(float(value)) * theta[j]
        return result

    lines = system.lines
    alpha, beta = angles(system.angles.rows, "alpha0"), angles(lines.frames.rows, "beta0")
    lengths = []
    for i in range(len(lines.free)):
        known = found["free"].get((i,), sympy.Integer(0))
        known += sum(value * x[j] for (k, j), value in found["stretch"].items() if k == i)
        rx, ry = (x[j] for j in lines.spans[i])
        lengths.append(known if lines.taut[i] else sympy.sqrt(rx**2 + ry**2))
    first, second = [], []
    for line, angle in zip(lines.line, beta, strict=True):
        rx, ry = (x[j] / lengths[line] for j in lines.spans[line])
        first.append(sympy.cos(angle) * rx + sympy.sin(angle) * ry)
        second.append(sympy.cos(angle) * ry - sympy.sin(angle) * rx)
    return [sympy.Integer(1), *map(sympy.cos, alpha), *map(sympy.sin, alpha), *first, *second]
