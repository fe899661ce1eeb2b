"""E, J0 and T of a whole beam: the reference element spread over the mesh, and the gyrator at the switch."""

from __future__ import annotations

import numpy as np

from phblocks.blocks.beam.mesh import Mesh
from phblocks.blocks.beam.tensors import component_index, reference_element
from phblocks.triplets import Floats, Ints, Triplets


def beam_matrices(
    mesh: Mesh, coefficients: Floats, offsets: Floats, modulating: Floats | None = None
) -> tuple[Triplets, Triplets, Triplets]:
    """Assemble the constant matrices of a beam.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.
    coefficients : numpy.ndarray
        Shape (12,): inertias and compliances per length, see :meth:`Section.coefficients`.
    offsets : numpy.ndarray
        Shape (12,): the constant part of strain (e1 at N) and curvature (initial curvature at M), else zero.
    modulating : numpy.ndarray, optional
        Shape (12,): what makes momentum, strain and curvature of a field where it modulates, in T; the coefficients
        by default.

    Returns
    -------
    E, J0, T : Triplets
        Shape (size, size) twice and (size, size, size); J0 and T skew in the first two axes to the last bit. What a
        zero multiplies has no entries.
    """
    modulating = coefficients if modulating is None else modulating
    E, J0, T = [], [], []
    for i, segment in enumerate(mesh.segments):
        element = reference_element(mesh.degree, segment.variant, mesh.space)
        states = mesh.local_states(i)
        h = mesh.lengths[segment.first : segment.last, None]
        mass = _nonzero(element.mass, coefficients[element.mass_coefficient])
        E.append(_spread(mass[0], states, h * mass[1]))
        J0.append(_spread(element.slope, states, 1.0))
        curved = _nonzero(element.product, offsets[element.product_offset])
        J0.append(_spread(curved[0], states, h * curved[1]))
        cubic = _nonzero(element.cubic, modulating[element.cubic_coefficient])
        T.append(_spread(cubic[0], states, h * cubic[1]))
    J0.append(_switch(mesh))
    return Triplets.join(E), Triplets.join(J0), Triplets.join(T, order=3)


def trace(mesh: Mesh, field: str, direction: int, at_end: bool) -> int:
    """Return the state that is the value of a continuous field at an end of the beam.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.
    field : {"V", "W", "N", "M"}
        A field that is in CG at that end.
    direction : int
        0, 1 or 2.
    at_end : bool
        At the end (s = L) or at the start.

    Returns
    -------
    int
        Number of the state.
    """
    states = mesh.states[-1 if at_end else 0][field, direction]
    return int(states[-1, -1] if at_end else states[0, 0])


def _switch(mesh: Mesh) -> Triplets:
    """Couple the two sides of the switch: velocity one way, force back, in the same cross section."""
    if len(mesh.segments) == 1:
        return Triplets.empty()
    left, right = (s.variant for s in mesh.segments)
    entries = []
    for velocity, stress in (("V", "N"), ("W", "M")):
        if left.is_continuous(velocity) == right.is_continuous(velocity):
            continue
        directions = mesh.space.translation if velocity == "V" else mesh.space.rotation
        for d in directions:
            if left.is_continuous(velocity):  # end of the left side: +<psi_V, N>; start of the right: -<psi_N, V>
                v, s, sign = mesh.states[0][velocity, d][-1, -1], mesh.states[1][stress, d][0, 0], 1.0
            else:  # start of the right side: -<psi_V, N>; end of the left: +<psi_N, V>
                v, s, sign = mesh.states[1][velocity, d][0, 0], mesh.states[0][stress, d][-1, -1], -1.0
            entries.append(Triplets.of(v, s, values=sign).skew)
    return Triplets.join(entries)


def _spread(entries: Triplets, states: Ints, factors: Floats | float) -> Triplets:
    """Put entries of the reference element into every element."""
    return Triplets.of(*(states[:, axis] for axis in entries.indices), values=factors * entries.values[None, :])


def _nonzero(entries: Triplets, factors: Floats) -> tuple[Triplets, Floats]:
    keep = factors != 0.0
    return Triplets(tuple(i[keep] for i in entries.indices), entries.values[keep]), factors[keep]


def strain_offsets(curvature: float) -> Floats:
    """Return the constant parts of strain and curvature of an initially circular beam.

    Parameters
    ----------
    curvature : float
        Initial curvature about axis 3, 1/m.

    Returns
    -------
    numpy.ndarray
        Shape (12,).
    """
    offsets = np.zeros(12)
    offsets[component_index("N", 0)] = 1.0
    offsets[component_index("M", 2)] = curvature
    return offsets
