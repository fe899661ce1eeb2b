"""Fields of a beam at points: rows that interpolate states, and the material points."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from phblocks.blocks.beam.mesh import Mesh
from phblocks.blocks.beam.spaces import gauss
from phblocks.errors import DataError
from phblocks.triplets import Floats, Ints, Triplets


def fraction(s: object, where: str = "place on a beam") -> float:
    """Check a fraction of the length.

    Parameters
    ----------
    s : object
        The candidate.
    where : str, optional
        What it is, for the message.

    Returns
    -------
    float
        From 0 to 1.

    Raises
    ------
    DataError
        If it is not a number from 0 to 1.
    """
    if isinstance(s, bool) or not isinstance(s, (int, float, np.number)) or not 0.0 <= float(s) <= 1.0:
        raise DataError(
            where,
            expected="a fraction of the length from 0 to 1",
            got=repr(s),
            fix="0 is the start, 1 the end.",
        )
    return float(s)


def weighted(values: Floats, weights: Floats) -> Floats:
    """Sum vectors at points.

    Parameters
    ----------
    values : numpy.ndarray
        Shape (times, points, dimension).
    weights : numpy.ndarray
        Of the points, shape (points,).

    Returns
    -------
    numpy.ndarray
        Shape (times, dimension).
    """
    return np.asarray(np.einsum("tmd,m->td", values, weights))


def quadrature(mesh: Mesh) -> tuple[Ints, Floats, Floats]:
    """List the material points of a beam: k + 1 Gauss points in each element.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.

    Returns
    -------
    elements : numpy.ndarray
        Element of each point.
    xi : numpy.ndarray
        Coordinate in the element.
    weights : numpy.ndarray
        Length that the point stands for, m.
    """
    points, weights = gauss(mesh.degree + 1)
    n = mesh.lengths.size
    return (
        np.repeat(np.arange(n), points.size),
        np.tile(points, n),
        (mesh.lengths[:, None] * weights).ravel(),
    )


def field_triplets(mesh: Mesh, name: str, direction: int, elements: Ints, xi: Floats) -> Triplets:
    """Interpolate a component at points.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.
    name : {"V", "W", "N", "M"}
        The field.
    direction : int
        0, 1 or 2.
    elements : numpy.ndarray
        Element of each point, shape (m,).
    xi : numpy.ndarray
        Coordinate of each point in its element, shape (m,).

    Returns
    -------
    Triplets
        Shape (m, states).
    """
    parts = []
    for i, segment in enumerate(mesh.segments):
        here = np.flatnonzero((elements >= segment.first) & (elements < segment.last))
        if here.size:
            states = mesh.states[i][name, direction][elements[here] - segment.first]
            parts.append(Triplets.of(here[:, None], states, values=mesh.basis(i, name).at(xi[here])))
    return Triplets.join(parts)


def field_rows(mesh: Mesh, name: str, direction: int, elements: Ints, xi: Floats) -> sp.csr_array:
    """Interpolate a component at points, as a matrix; see :func:`field_triplets`.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.
    name : {"V", "W", "N", "M"}
        The field.
    direction : int
        0, 1 or 2.
    elements : numpy.ndarray
        Element of each point, shape (m,).
    xi : numpy.ndarray
        Coordinate of each point in its element, shape (m,).

    Returns
    -------
    scipy.sparse.csr_array
        Shape (m, states).
    """
    return field_triplets(mesh, name, direction, elements, xi).csr((elements.size, mesh.size))


def angle_rows(mesh: Mesh, elements: Ints, xi: Floats, direction: int = 2) -> tuple[sp.csr_array, sp.csr_array]:
    """Interpolate the angle at points from the rotation states and, where W is discontinuous, from curvature.

    Parameters
    ----------
    mesh : Mesh
        Elements and numbering.
    elements : numpy.ndarray
        Element of each point, shape (m,).
    xi : numpy.ndarray
        Coordinate of each point in its element, shape (m,).
    direction : int, optional
        Component of W and M, by default that of the plane.

    Returns
    -------
    rotation : scipy.sparse.csr_array
        Shape (m, states), to be applied to the time integrals of W.
    bending : scipy.sparse.csr_array
        Shape (m, states), to be applied to M and multiplied by the compliance.
    """
    points, weights = gauss(mesh.degree + 1)
    h, n = mesh.lengths[elements][:, None], elements.size
    spots = np.arange(n * points.size).reshape(n, points.size)

    def integral(name: str, at: Floats, factors: Floats) -> sp.csr_array:
        """Sum of factors times the field at points of the same element, both of shape (n, points)."""
        values = field_rows(
            mesh, name, direction, np.repeat(elements, points.size), np.broadcast_to(at, spots.shape).ravel()
        )
        return Triplets.of(np.arange(n)[:, None], spots, values=factors).csr((n, spots.size)) @ values

    smooth = np.array([mesh.segments[mesh.segment_of(int(e))].variant.spin for e in elements], dtype=np.float64)
    keep, replace = sp.diags_array(smooth), sp.diags_array(1.0 - smooth)
    up_to_xi = integral("M", xi[:, None] * points, h * xi[:, None] * weights)
    mean_of_that = integral("M", points, h * weights * (1.0 - points))
    interpolated = field_rows(mesh, "W", direction, elements, xi)
    mean = integral("W", points, weights)
    return (
        sp.csr_array(keep @ interpolated + replace @ mean),
        sp.csr_array(replace @ (up_to_xi - mean_of_that)),
    )
