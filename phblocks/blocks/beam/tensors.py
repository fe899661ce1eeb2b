"""E, J0 and T of one beam element on [0, 1], free of size and material.

The equations are those of ``docs/theory.md`` (intrinsic geometrically exact beam, twelve components):

    rhoA V' = d_s N + K x N + (rhoA V) x W
    rhoJ W' = d_s M + K x M + (e1 + Gamma) x N + (rhoA V) x V + (rhoJ W) x W
    C_t  N' = d_s V + K x V + (e1 + Gamma) x W
    C_r  M' = d_s W + K x W

Every product is a cross product of a test field, a state field and a *modulating* field: momentum, spin, strain
``Gamma = C_t N`` or curvature ``K = K0 + C_r M``.  Only half of them is written down here (:data:`PRODUCTS`); the
other half is its negative transpose, which makes J skew to the last bit.  An element of length h with inertias
and compliances c has

    E = h c mass,   J0 = slope + h (offset . product),   T = h c cubic.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from phblocks.blocks.beam.spaces import Basis, continuous, discontinuous, gauss
from phblocks.space import LEVI_CIVITA, Space
from phblocks.triplets import Floats, Ints, Triplets

#: Fields in the order of the states; V and N are a pair, and W and M.
FIELDS = ("V", "W", "N", "M")

#: (test field, state field, modulating field); the mirrored product follows from skewness.
PRODUCTS = (
    ("V", "N", "M"),  # K x N         mirrored in the stress equation:    K x V
    ("V", "W", "V"),  # (rhoA V) x W  mirrored in the balance of moments: (rhoA V) x V
    ("W", "N", "N"),  # Gamma x N     mirrored in the stress equation:    Gamma x W
    ("W", "M", "M"),  # K x M         mirrored in the curvature equation: K x W
    ("W", "W", "W"),  # (rhoJ W) x W  its own mirror
)

#: Components are numbered V1 V2 V3 W1 ... M3, whether or not the space has them.
Component = tuple[str, int]


def component_index(field: str, direction: int) -> int:
    """Number a component among the twelve.

    Parameters
    ----------
    field : {"V", "W", "N", "M"}
        The field.
    direction : int
        0, 1 or 2.

    Returns
    -------
    int
        0 to 11.
    """
    return 3 * FIELDS.index(field) + direction


@dataclass(frozen=True)
class Variant:
    """Which side of each pair is continuous in an element.

    Parameters
    ----------
    velocity : bool
        V in CG and N in DG (ends take forces); otherwise the other way round.
    spin : bool
        W in CG and M in DG (ends take moments); otherwise the other way round.
    """

    velocity: bool
    spin: bool

    def is_continuous(self, field: str) -> bool:
        """Tell whether a field is in CG.

        Parameters
        ----------
        field : {"V", "W", "N", "M"}
            The field.

        Returns
        -------
        bool
            True for CG_k, False for DG_{k-1}.
        """
        return {"V": self.velocity, "N": not self.velocity, "W": self.spin, "M": not self.spin}[field]


@dataclass(frozen=True)
class ReferenceElement:
    """Entries in local numbering, each with the component whose coefficient multiplies it.

    Parameters
    ----------
    components : tuple
        (field, direction) of the components present, in local order.
    first : tuple of int
        First local state of each component.
    size : int
        Number of local states.
    mass : Triplets
        Times h and the coefficient of component ``mass_coefficient``.
    slope : Triplets
        Skew; the derivative d/ds.
    product : Triplets
        Skew; times h and the offset (initial curvature, e1) of component ``product_offset``.
    cubic : Triplets
        Order three, skew in the first two axes; times h and the coefficient of ``cubic_coefficient``.
    mass_coefficient, product_offset, cubic_coefficient : numpy.ndarray
        Component number (0 to 11) of each entry.
    """

    components: tuple[Component, ...]
    first: tuple[int, ...]
    size: int
    mass: Triplets
    mass_coefficient: Ints
    slope: Triplets
    product: Triplets
    product_offset: Ints
    cubic: Triplets
    cubic_coefficient: Ints


def field_basis(variant: Variant, field: str, degree: int) -> Basis:
    """Return the basis of a field.

    Parameters
    ----------
    variant : Variant
        Which side of each pair is continuous.
    field : {"V", "W", "N", "M"}
        The field.
    degree : int
        k of the pair CG_k, DG_{k-1}.

    Returns
    -------
    Basis
        CG_k or DG_{k-1}.
    """
    return continuous(degree) if variant.is_continuous(field) else discontinuous(degree)


def present_components(space: Space) -> tuple[Component, ...]:
    """List the components of a space in the order of the states.

    Parameters
    ----------
    space : Space
        Planar: V1 V2 W3 N1 N2 M3.

    Returns
    -------
    tuple of (str, int)
        Field and direction.
    """
    return tuple((f, d) for f in FIELDS for d in (space.translation if f in "VN" else space.rotation))


@cache
def reference_element(degree: int, variant: Variant, space: Space) -> ReferenceElement:
    """Integrate all entries of the element exactly.

    Parameters
    ----------
    degree : int
        k of the pair CG_k, DG_{k-1}.
    variant : Variant
        Which side of each pair is continuous.
    space : Space
        Which components are present.

    Returns
    -------
    ReferenceElement
        Mass, slope, product and cubic entries.
    """
    components = present_components(space)
    bases = {f: field_basis(variant, f, degree) for f in FIELDS}
    first = np.concatenate([[0], np.cumsum([bases[f].size for f, _ in components])])
    local = {c: first[i] + np.arange(bases[c[0]].size) for i, c in enumerate(components)}
    points, weights = gauss((3 * degree) // 2 + 1)
    value = {f: bases[f].at(points) for f in FIELDS}

    mass: list[Triplets] = []
    mass_coefficient: list[Ints] = []
    for c in components:
        gram = np.einsum("q,qi,qj->ij", weights, value[c[0]], value[c[0]])
        gram = (gram + gram.T) / 2.0
        mass.append(_entries((local[c], local[c]), gram))
        mass_coefficient.append(np.full(mass[-1].values.size, component_index(*c)))

    slope: list[Triplets] = []
    for velocity, stress in (("V", "N"), ("W", "M")):
        for d in space.translation if velocity == "V" else space.rotation:
            v, s = local[velocity, d], local[stress, d]
            if variant.is_continuous(velocity):  # -(psi_V', N) in the balance, +(psi_N, V') in the stress equation
                dv = bases[velocity].derivative(points)
                slope.append(_entries((v, s), -np.einsum("q,qi,qj->ij", weights, dv, value[stress])).skew)
            else:  # +(psi_V, N') in the balance, -(psi_N', V) in the stress equation
                ds = bases[stress].derivative(points)
                slope.append(_entries((v, s), np.einsum("q,qi,qj->ij", weights, value[velocity], ds)).skew)

    product: list[Triplets] = []
    product_offset: list[Ints] = []
    cubic: list[Triplets] = []
    cubic_coefficient: list[Ints] = []
    for test, state, modulating in PRODUCTS:
        pair = np.einsum("q,qi,qj->ij", weights, value[test], value[state])
        triple = np.einsum("q,qi,qj,qk->ijk", weights, value[test], value[state], value[modulating])
        for a, b, c in zip(*np.nonzero(LEVI_CIVITA), strict=True):  # (modulating_b x state_c) tested with a
            if test == state and a > c:
                continue  # its own mirror
            if (test, a) not in local or (state, c) not in local:
                continue
            sign, rows, columns = LEVI_CIVITA[a, b, c], local[test, a], local[state, c]
            product.append(_entries((rows, columns), sign * pair).skew)
            product_offset.append(np.full(product[-1].values.size, component_index(modulating, b)))
            if (modulating, b) in local:
                cubic.append(_entries((rows, columns, local[modulating, b]), sign * triple).skew)
                cubic_coefficient.append(np.full(cubic[-1].values.size, component_index(modulating, b)))

    return ReferenceElement(
        components=components,
        first=tuple(int(i) for i in first[:-1]),
        size=int(first[-1]),
        mass=Triplets.join(mass),
        mass_coefficient=_flat(mass_coefficient),
        slope=Triplets.join(slope),
        product=Triplets.join(product),
        product_offset=_flat(product_offset),
        cubic=Triplets.join(cubic, order=3),
        cubic_coefficient=_flat(cubic_coefficient),
    )


def _flat(parts: list[Ints]) -> Ints:
    return np.concatenate(parts) if parts else np.empty(0, dtype=np.int64)


def _entries(axes: tuple[Ints, ...], block: Floats) -> Triplets:
    """Entries of a dense block at given local states, without the zeros that symmetry of the basis leaves."""
    keep = np.abs(block) > 1e-14 * np.abs(block).max()
    grid = np.meshgrid(*axes, indexing="ij")
    return Triplets.of(*(g[keep] for g in grid), values=block[keep])
