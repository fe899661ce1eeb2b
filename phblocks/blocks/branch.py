"""Parts without extension: ports, and one through quantity that they share.

A *branch* carries one state f, such as a current or a moment, and takes the common quantities u_k of its ports::

    e f' = sum over ports of c_k u_k - r f,        what port k gives is c_k f

With e > 0 it stores energy (a spring, an inductor), with e = 0 it does not (a damper, a gear, a motor without
inductance): then the state has a row of zeros in E and the solver's linear algebra finds it. A port may also give
the common quantity: that becomes one more state v_k without energy, the one whose row says that the summed quantity
taken there is ``c_k f``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from phblocks.blocks.block import Block, PortChoice, Tie
from phblocks.blocks.form import FIXED, NO_ENERGY, AngleRows, Form, Piece, PortForm, StateRun
from phblocks.ports import ROTATION, Anchor, Domain, Port, Ports
from phblocks.space import Space
from phblocks.triplets import Floats, Triplets


class Lumped(Block):
    """A part that is nowhere in particular: it has ports and no anchors.

    Parameters
    ----------
    name : str
        Unique in the diagram.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._ports: list[Port] = []

    def _add_port(self, name: str, domain: Domain) -> Port:
        # a shaft that is turned from here gets its orientation from here: form.orientations has it by this name
        anchor = Anchor(self, name, None) if domain == ROTATION else None
        port = Port(self, name, domain, anchor)
        self._ports.append(port)
        return port

    @property
    def anchors(self) -> Mapping[str, Anchor]:
        """None."""
        return {}

    @property
    def space(self) -> Space | None:
        """It fits any space."""
        return None

    @property
    def ports(self) -> Mapping[str, Port]:
        """All ports by name."""
        return Ports(self.name, self._ports)

    def choices(self) -> tuple[Sequence[PortChoice], Sequence[Tie]]:
        """Say that all ports take the common quantity.

        Returns
        -------
        choices : sequence of PortChoice
            One for each port.
        ties : sequence of Tie
            None.
        """
        return [PortChoice(port, may_give=False, may_take=True) for port in self._ports], []


def state(field: str, unit: str, energy: str = NO_ENERGY) -> StateRun:
    """Describe one state of a part without extension.

    Parameters
    ----------
    field : str
        Its name.
    unit : str
        SI unit.
    energy : str, optional
        Kind of energy; none by default.

    Returns
    -------
    StateRun
        Of one state.
    """
    return StateRun(field, unit, energy, np.zeros(1))


def entries(matrix: Floats) -> Triplets:
    """Turn a small dense array into entries.

    Parameters
    ----------
    matrix : numpy.ndarray
        Of any order.

    Returns
    -------
    Triplets
        Without zeros.
    """
    places = np.nonzero(matrix)
    return Triplets.of(*places, values=matrix[places]) if places[0].size else Triplets.empty(matrix.ndim)


def lumped_form(
    ports: Iterable[Port],
    runs: Sequence[StateRun],
    E: Floats,
    J: Floats,
    R: Floats,
    outputs: Mapping[str, tuple[bool, Floats]],
    start: Floats | None = None,
) -> Form:
    """Make the form of a part without extension from dense matrices; vectors are in the fixed frame.

    Parameters
    ----------
    ports : iterable of Port
        All of them.
    runs : sequence of StateRun
        The states.
    E, J, R : numpy.ndarray
        Shape (states, states).
    outputs : mapping of str to (bool, numpy.ndarray)
        By name of the port: whether it gives the common quantity, and what it gives, shape (components, states).
    start : numpy.ndarray, optional
        States at the start; zero by default.

    Returns
    -------
    Form
        A rotation port that gives has an orientation: the time integral of what it gives.
    """
    shafts = {p.name: outputs[p.name] for p in ports if p.domain == ROTATION}
    turning = sorted({int(i) for gives, out in shafts.values() if gives for i in np.flatnonzero(out[0])})
    return Form(
        size=len(E),
        runs=runs,
        E=entries(E),
        J0=entries(J),
        R=entries(R),
        T=Triplets.empty(3),
        ports={name: PortForm(gives, (Piece(entries(out), FIXED),)) for name, (gives, out) in outputs.items()},
        rotation_states=np.array(turning, dtype=np.int64),
        orientations={
            name: AngleRows(entries(out[:1, turning]), np.zeros(1)) if gives else None
            for name, (gives, out) in shafts.items()
        },
        start=start,
    )


def branch_form(
    ends: Mapping[Port, float],
    gives: Mapping[str, bool],
    through: StateRun,
    e: float = 0.0,
    r: float = 0.0,
    start: float = 0.0,
    charge: StateRun | None = None,
    e_charge: float = 0.0,
    start_charge: float = 0.0,
) -> Form:
    """Reduce a branch to its matrices.

    Parameters
    ----------
    ends : mapping of Port to float
        The coefficient c_k of each port, all with one component.
    gives : mapping of str to bool
        For each port whether it gives the common quantity.
    through : StateRun
        The state f.
    e, r : float, optional
        In ``e f' = sum c_k u_k - r f``.
    start : float, optional
        f at the start.
    charge : StateRun, optional
        A second state q in series, ``e_charge q' = f``, that is subtracted on the right: the voltage of a capacitor.
    e_charge, start_charge : float, optional
        Of that.

    Returns
    -------
    Form
        States f, q if there is one, and one for each port that gives.
    """
    giving = [port for port in ends if gives[port.name]]
    series = [] if charge is None else [charge]
    runs = [through, *series]
    runs += [state(f"{port.domain.common.name} of {port.name}", port.domain.common.unit) for port in giving]
    n = len(runs)
    E, J, R, x = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
    E[0, 0], R[0, 0], x[0] = e, r, start
    if charge is not None:
        E[1, 1], J[1, 0], J[0, 1], x[1] = e_charge, 1.0, -1.0, start_charge
    outputs = {}
    for port, c in ends.items():
        out = np.zeros((1, n))
        if port in giving:
            k = 1 + len(series) + giving.index(port)
            J[0, k], J[k, 0], out[0, k] = c, -c, 1.0
        else:
            out[0, 0] = c
        outputs[port.name] = (gives[port.name], out)
    return lumped_form(ends, runs, E, J, R, outputs, x)
