"""How much each effect has to do with a scene, from one run: what is worth an audit, and what is not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from phblocks.errors import ArgumentTypeError
from phblocks.results.solution import Solution
from phblocks.studies.table import Table
from phblocks.system import Part
from phblocks.triplets import Floats


@dataclass(frozen=True, kw_only=True)
class Share:
    """What an effect takes part in, in one block.

    Parameters
    ----------
    block : str
        Its name.
    effect : str
        A field of :class:`~phblocks.Approximation`.
    states : int
        Number of states that carry its energy.
    share : float
        Largest over the saved times, relative to the largest energy of the whole system; of large rotations the
        largest turn, rad. NaN if it is not known.
    measure : str
        What it is a share of: "stored energy", "dissipated energy", "potential energy", or "turn (rad)".
    """

    block: str
    effect: str
    states: int
    share: float
    measure: str


@dataclass(frozen=True, repr=False)
class EffectShares(Table[Share]):
    """Shares of all effects of all blocks.

    Parameters
    ----------
    rows : tuple of Share
        Block by block.
    """

    row_type: ClassVar[type[Share]] = Share
    shown: ClassVar[tuple[str, ...]] = ("block", "effect", "states", "share", "measure")

    @property
    def notes(self) -> tuple[str, ...]:
        """What the shares are of."""
        return (
            "Share: largest over the saved times, of the largest energy of the system; of large rotations: the turn.",
        )

    def of(self, effect: str) -> dict[str, float]:
        """Return the shares of an effect by the name of the block.

        Parameters
        ----------
        effect : str
            Its name.

        Returns
        -------
        dict
            Of the blocks that have it.
        """
        return {row.block: row.share for row in self.rows if row.effect == effect}


def effect_shares(solution: Solution) -> EffectShares:
    """Estimate from one run how much each effect has to do with a scene.

    A share is no bound of the error made by leaving the effect out: a strain of little energy may still shift a motion
    in time. It tells which effects are worth an audit by ``ph.studies.effects``, at the price of one run, which may be
    short and coarse.

    Parameters
    ----------
    solution : Solution
        Of the full system, or of one with some effects left out.

    Returns
    -------
    EffectShares
        A row for each effect that a block has.

    Raises
    ------
    ArgumentTypeError
        If it is no solution.
    """
    if not isinstance(solution, Solution):
        raise ArgumentTypeError(
            "effect_shares", expected="a Solution", got=type(solution).__name__, fix="Call ph.simulate() first."
        )
    system, ledger = solution.system, solution.recording.ledger
    potential = np.ptp(ledger.potential, axis=0)
    whole = max(float(ledger.stored.sum(axis=(1, 2)).max()), float(np.ptp(ledger.potential.sum(axis=1))))
    rows = []
    for number, part in enumerate(system.parts):
        energies = _energies(solution, part)
        turned = np.abs(part.turned(solution.recording.theta))
        others: Mapping[str, tuple[float, str]] = {
            "large_rotation": (float(turned.max()) if turned.size and part.angles_known else math.nan, "turn (rad)"),
            "gravity": (_relative(float(potential[number]), whole), "potential energy"),
            "internal_damping": (_relative(float(ledger.dissipated[-1, number]), whole), "dissipated energy"),
        }
        for effect, states in part.block.effects(part.form).items():
            if effect == "gravity" and not system.gravity.any():
                continue
            stored = float(energies[:, states].sum(axis=1).max(initial=0.0))
            share, measure = others.get(effect, (_relative(stored, whole), "stored energy"))
            rows.append(Share(block=part.name, effect=effect, states=states.size, share=share, measure=measure))
    return EffectShares(tuple(rows))


def _energies(solution: Solution, part: Part) -> Floats:
    """Energy by state of a block at the saved times, J; of states that E couples, half of the products each."""
    x = solution.system.sharing.of_block(solution.recording.x, part.states)
    return np.asarray(0.5 * x * (part.form.E.csr((part.form.size, part.form.size)) @ x.T).T)


def _relative(energy: float, whole: float) -> float:
    return energy / whole if whole > 0.0 else math.nan
