"""How far strain and configuration part in blocks, and how far joints open: energy shows neither."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from phblocks.errors import UnknownNameError
from phblocks.frames import rotate
from phblocks.triplets import Floats

if TYPE_CHECKING:
    from phblocks.results.recording import Recording
    from phblocks.results.solution import Solution
    from phblocks.system import Part, Site, System


def block_gaps(solution: Solution) -> Mapping[str, Floats]:
    """Measure how far strain and configuration are apart, block by block.

    Parameters
    ----------
    solution : Solution
        Of a run.

    Returns
    -------
    mapping of str to numpy.ndarray
        For each block with both positions the largest distance over its outline, shape (times,), m.
    """
    gaps = {}
    for part in solution.system.parts:
        with suppress(UnknownNameError):  # not every block has both positions
            apart = [
                np.linalg.norm(
                    solution.position(part.name, s, source="strain") - solution.position(part.name, s), axis=1
                )
                for s in part.form.outline()
            ]
            if apart:
                gaps[part.name] = np.max(apart, axis=0)
    return gaps


def joint_gaps(system: System, recording: Recording, spots: Callable[[Site], Sequence[Floats]]) -> Mapping[str, Floats]:
    """Measure how far joints open.

    Parameters
    ----------
    system : System
        The system.
    recording : Recording
        Of a run of it.
    spots : callable
        Tells where all that is joined at a site has gone, each of shape (times, dimension), m.

    Returns
    -------
    mapping of str to numpy.ndarray
        For each joint the largest distance between what it joins, shape (times,), m; of a slider across its guide.
        Joints to imposed motions are left out if the run did not start in the initial configuration.
    """
    gaps = {}
    for site in system.sites:
        at = spots(site)
        if len(at) < 2:  # it is not known where an imposed motion holds it
            continue
        gaps[site.name] = np.max([np.linalg.norm(a - b, axis=1) for i, a in enumerate(at) for b in at[:i]], axis=0)
    for guide in system.guides:
        span = spots(guide.second)[0] - spots(guide.first)[0]
        if guide.anchor is not None:
            places, weights, reference = system.anchor_angles[guide.anchor]
            span = rotate(-(reference + recording.theta[:, places] @ weights), span)
        across = span @ guide.across.T
        gaps[guide.name] = np.linalg.norm(across - across[0], axis=1)
    return gaps


def sizes(system: System) -> Mapping[str, float]:
    """Measure blocks in the initial configuration.

    Parameters
    ----------
    system : System
        The system.

    Returns
    -------
    mapping of str to float
        Largest distance between mass points or anchors of each block that has an extension, m.
    """
    return {part.name: size for part in system.parts if (size := _size(part)) > 0.0}


def _size(part: Part) -> float:
    anchors = [a.position for a in part.block.anchors.values() if a.position is not None]
    points = [] if part.form.points is None else list(part.form.points.start)
    return float(np.linalg.norm(np.ptp([*anchors, *points], axis=0))) if anchors or points else 0.0
