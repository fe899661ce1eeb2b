"""What a compilation kept, pruned or approximated, one record an effect."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Effect:
    """One effect in one block (or in the whole diagram), and what became of it.

    Parameters
    ----------
    block : str
        Name of the block; empty for the whole diagram.
    name : str
        The effect, such as ``"bending"``, ``"positions"`` or ``"shear"``.
    status : {"kept", "pruned", "approximated"}
        Whether it is computed, proven to change nothing, or left out on request.
    states : int
        Number of states it has (kept) or would have had (pruned, approximated).
    reason : str
        The proof (pruned: which pattern, from which excitation), or the request (approximated).
    """

    block: str
    name: str
    status: Literal["kept", "pruned", "approximated"]
    states: int
    reason: str
