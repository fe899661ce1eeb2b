"""Where large rotations may be left out: a block that hardly turns, and spins far below its first frequency.

The linear theory about rest knows no centrifugal force and no stiffness from it. Seen from a frame that turns at the
rate omega, a beam of first frequency f obeys ``a'' = (omega^2 - f^2) a`` in the linear theory: its frequency falls with
the spin, and above f it diverges. In truth the tension of the spin makes it stiffer.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from phblocks.assembly.approximation import requested
from phblocks.errors import ApproximationError, ApproximationWarning
from phblocks.system import Part, State, System
from phblocks.triplets import Floats, real_array

#: A block that turns further has large rotations, rad.
SMALL_TURN = 0.1
#: Spins above this part of the first frequency change it by more than half a percent.
SLOW_SPIN = 0.1
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
    known = [_constant(system, number) for number in range(system.n_inputs)]
    require_slow(system, system.start, np.array(known))
    return system


def _constant(system: System, number: int) -> float:
    """The value of an input whose signal is constant, zero otherwise."""
    signal, exposure = system.inputs[number].signal, system.inputs[number].exposure
    array = None if signal is None or callable(signal) else real_array(signal)
    if array is None:
        return 0.0
    first = next(i for i, entry in enumerate(system.inputs) if entry.exposure == exposure)
    return float(array.ravel()[number - first])


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
        Inputs there, shape (n_inputs,).

    Raises
    ------
    ApproximationError
        If a block without large rotations spins faster than a tenth of its first frequency.
    """
    x = system.sharing.expand(state.x)
    for part in watched(system):
        spin = max(np.abs(x[part.states][part.form.rotation_states]).max(initial=0.0), _driven(system, part, u))
        if spin == 0.0:
            continue
        first = _first_frequency(system, part)
        if first is not None and spin > SLOW_SPIN * first:
            raise _refusal(part.name, float(spin), first)


def _refusal(name: str, spin: float, first: float) -> ApproximationError:
    if spin > first:
        fate = f"seen from the turning block it diverges at the rate {np.sqrt(spin**2 - first**2):.4g} 1/s"
    else:
        fate = f"seen from the turning block the first frequency falls to {np.sqrt(first**2 - spin**2):.4g} rad/s"
    return ApproximationError(
        f"block {name!r} with large_rotation=False",
        expected=f"a spin below {SLOW_SPIN * first:.4g} rad/s, a tenth of its first frequency {first:.4g} rad/s",
        got=f"{spin:.4g} rad/s, where a linear model loses the centrifugal stiffening: {fate}",
        fix='Use large_rotation="second-order" or True, or insist=True if that is known.',
    )


def _driven(system: System, part: Part, u: Floats) -> float:
    """The fastest angular velocity that the outside imposes on a block."""
    row, number, _ = system.connections.supply.indices
    here = np.unique(number[(row >= part.states.start) & (row < part.states.stop)])
    return max((abs(float(u[i])) for i in here if _imposes_spin(system, int(i))), default=0.0)


def _imposes_spin(system: System, number: int) -> bool:
    entry = system.inputs[number]
    return entry.common and entry.imposed.unit == "rad/s"


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
