"""Where large rotations may be left out: a block that hardly turns, and spins far below its first frequency.

The linear theory about rest knows no centrifugal force and no stiffness from it: with frames that stay as they are, the
first frequency f of a beam is what it is at rest, whatever the spin omega. Written with linear strains in coordinates
that turn with the beam it is even ``a'' = (omega^2 - f^2) a``: softer with the spin, and divergent above f. In truth
the tension of the spin makes it stiffer.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from phblocks.assembly.approximation import requested
from phblocks.errors import ApproximationError, ApproximationWarning
from phblocks.system import Part, State, System
from phblocks.triplets import Floats, real_array

#: A block that turns further has large rotations, rad.
SMALL_TURN = 0.1
#: Spins above this part of the first frequency change it by more than half a percent.
SLOW_SPIN = 0.1
#: What is slow beside the first frequency of a block, as a part of it.
SLOW = 1e-3
#: Units of the inputs that move blocks by themselves.
MOTIONS = ("rad/s", "m/s")
#: How many modes are searched for the first one of a block, and the part of its energy that the block has at least.
MODES, SHARE = 12, 0.1


def justified(system: System) -> System:
    """Record what is left out, and refuse what the drives of the diagram say is wrong.

    Parameters
    ----------
    system : System
        As assembled.

    Returns
    -------
    System
        With its record; the very same object if nothing is left out.

    Raises
    ------
    ApproximationError
        If a block without large rotations is driven at more than a tenth of its first frequency.
    """
    record = requested(system)
    if not record:
        return system
    system = replace(system, approximations=record, effects=system.effects.joined(record))
    require_slow(system, system.start, _constants(system)[None])
    return system


def _constants(system: System) -> Floats:
    """The inputs that constant sources give; zero for all others."""
    u = np.zeros(system.n_inputs)
    for name in dict.fromkeys(entry.exposure for entry in system.inputs):
        span = [i for i, entry in enumerate(system.inputs) if entry.exposure == name]
        signal = system.inputs[span[0]].signal
        value = None if signal is None or callable(signal) else real_array(signal)
        if value is not None:
            u[span] = value
    return u


def watched(system: System) -> Sequence[Part]:
    """List the blocks whose large rotations are left out, and not on insistence.

    Parameters
    ----------
    system : System
        The system.

    Returns
    -------
    sequence of Part
        None in most systems.
    """
    return [part for part in system.parts if part.form.frozen and not part.block.kept.insist]


def require_slow(system: System, state: State, u: Floats) -> None:
    """Refuse spins at which the linear theory is wrong.

    Parameters
    ----------
    system : System
        The system.
    state : State
        At the start of a run.
    u : numpy.ndarray
        Inputs at some times, shape (times, n_inputs).

    Raises
    ------
    ApproximationError
        If a block without large rotations spins faster than a tenth of its first frequency: at the start, or as soon as
        everything follows what the inputs impose.
    """
    x = system.sharing.expand(state.x)
    drives = _drives(system, u)
    for part in watched(system):
        spin = np.abs(x[part.states][part.form.rotation_states]).max(initial=0.0)
        if spin == 0.0 and not drives.size:
            continue
        first = _first_frequency(system, part)
        if first is None:
            continue
        if drives.size:
            spin = max(spin, _driven(system, part, drives, SLOW * first))
        if spin > SLOW_SPIN * first:
            raise _refusal(part.name, float(spin), first)


def _refusal(name: str, spin: float, first: float) -> ApproximationError:
    if spin > first:
        fate = f"diverges at the rate {np.sqrt(spin**2 - first**2):.4g} 1/s"
    else:
        fate = f"falls to {np.sqrt(first**2 - spin**2):.4g} rad/s"
    return ApproximationError(
        f"block {name!r} with large_rotation=False",
        expected=f"a spin below {SLOW_SPIN * first:.4g} rad/s, a tenth of its first frequency {first:.4g} rad/s",
        got=f"{spin:.4g} rad/s, where a linear model loses the centrifugal stiffening: its frequency stays that at "
        f"rest (in one with strains linear in turning coordinates it {fate})",
        fix='Use large_rotation="second-order" or True, or insist=True if that is known.',
    )


def _drives(system: System, u: Floats) -> Floats:
    """What the outside imposes of velocities and spins, all other inputs zero, shape (n_inputs, times); maybe empty."""
    imposed = np.array([i.common and i.imposed.unit in MOTIONS for i in system.inputs], dtype=bool)
    driven = np.where(imposed, u, 0.0).T
    return driven[:, driven.any(axis=0)]


def _driven(system: System, part: Part, drives: Floats, rate: float) -> float:
    """The fastest angular velocity of a block when what is imposed has lasted for a time of 1 / rate.

    By the slow response ``(rate E - A) w = B u``, whatever is between: gears, joints, other blocks, soft springs.
    """
    linear = system.linearize()
    factor = splu(sp.csc_array(rate * linear.E - linear.A))
    w = factor.solve(np.asarray(linear.B @ drives[linear.inputs]))[: system.n]
    spins = system.sharing.of_block(w.T, part.states)[:, part.form.rotation_states]
    return float(np.abs(spins).max(initial=0.0))


def _first_frequency(system: System, part: Part) -> float | None:
    """The lowest frequency of a mode that the block takes part in, rad/s."""
    modes, E = system.excited_modes(MODES), part.form.E.csr((part.form.size,) * 2)
    share = np.zeros(modes.frequencies.size)
    for shapes in (modes.shapes.real, modes.shapes.imag):  # of unit energy
        own = system.sharing.of_block(shapes[: system.n].T, part.states)
        share += 0.5 * np.einsum("mi,mi->m", own, (E @ own.T).T)
    found = np.flatnonzero(share >= SHARE)
    return float(modes.frequencies[found[0]]) if found.size else None


def warn_of_turns(system: System, theta: Floats) -> None:
    """Warn of blocks that turned further than their approximation allows.

    Parameters
    ----------
    system : System
        The system.
    theta : numpy.ndarray
        Rotation states of a run, shape (times, n_theta), rad.
    """
    for part in watched(system):
        turned = np.abs(part.turned(theta)).max(initial=0.0)
        if turned > SMALL_TURN:
            warnings.warn(
                f"block {part.name!r} turned by {turned:.3g} rad, but was computed with large_rotation=False, which is "
                f"good for turns up to about {SMALL_TURN} rad: its frames stayed as they were at the start. Use "
                'large_rotation="second-order" or True, or insist=True.',
                ApproximationWarning,
                stacklevel=3,
            )
