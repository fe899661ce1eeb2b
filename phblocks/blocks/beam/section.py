"""Cross sections: the stiffnesses and inertias of a beam per unit of length."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from phblocks.blocks.checks import require_positive, require_real
from phblocks.errors import ArgumentTypeError, DataError
from phblocks.space import SPATIAL, Space
from phblocks.triplets import Floats

#: Of a dimension, m.
SMALLEST = 1e-30

Pair = float | tuple[float, float]


@dataclass(frozen=True)
class Section:
    """Stiffness and inertia of a cross section.

    The axes are those of the material frame: 1 along the beam, 2 in the plane of a planar diagram, 3 out of it.
    ``shear``, ``bending`` and ``rotary`` take one number for both directions or a pair. A stiffness may be
    ``math.inf``: its compliance is exactly zero, and the force or moment is one of constraint, as with
    ``ph.Approximation(extension=False)``.

    Parameters
    ----------
    axial : float
        EA, N.
    shear : float or tuple of float
        kGA (along 2, along 3), N.
    bending : float or tuple of float
        EI (about 2, about 3), N m^2. A planar beam bends about 3.
    mass : float
        rho A, kg/m.
    rotary : float or tuple of float
        rho I (about 2, about 3), kg m.
    torsion : float, optional
        GJ, N m^2; needed by spatial beams only.
    polar : float, optional
        rho J about the beam's axis, kg m; by default the sum of the two rotary inertias.

    Raises
    ------
    DataError
        If a value is not positive, or a mass or inertia not finite.
    ArgumentTypeError
        If a value is not a number or a pair of numbers.

    Notes
    -----
    Saint-Venant's linear material law of the intrinsic beam, Hodges (2003), doi:10.2514/2.2054.
    """

    axial: float
    shear: Pair
    bending: Pair
    mass: float
    rotary: Pair
    torsion: float | None = None
    polar: float | None = None

    def __post_init__(self) -> None:
        """Check all values."""
        pairs = {name: _pair(name, getattr(self, name)) for name in ("shear", "bending", "rotary")}
        stiff = [("axial", self.axial), *((name, value) for name in ("shear", "bending") for value in pairs[name])]
        inert = [("mass", self.mass), *(("rotary", value) for value in pairs["rotary"])]
        stiff += [] if self.torsion is None else [("torsion", self.torsion)]
        inert += [] if self.polar is None else [("polar", self.polar)]
        for name, value in stiff:
            _require_stiffness(f"Section {name}", value)
        for name, value in inert:
            require_positive(f"Section {name}", value)

    @classmethod
    def _isotropic(
        cls,
        area: float,
        second: tuple[float, float],
        twist: float,
        *,
        young: float,
        poisson: float,
        density: float,
        shear_factor: float,
    ) -> Section:
        """From area, second moments (about 2, about 3) and torsion constant of an isotropic solid."""
        for name, value in (("young", young), ("density", density), ("shear_factor", shear_factor)):
            require_positive(f"Section {name}", value)
        if not -1.0 < require_real("Section poisson", poisson) <= 0.5:
            raise DataError(
                "Section poisson",
                expected="a Poisson number in (-1, 0.5]",
                got=repr(poisson),
                fix="Isotropic solids have Poisson numbers in this range; steel has 0.3.",
            )
        modulus = young / (2.0 * (1.0 + poisson))
        return cls(
            axial=young * area,
            shear=shear_factor * modulus * area,
            bending=(young * second[0], young * second[1]),
            mass=density * area,
            rotary=(density * second[0], density * second[1]),
            torsion=modulus * twist,
        )

    @classmethod
    def rectangle(
        cls,
        width: float,
        height: float,
        young: float,
        poisson: float,
        density: float,
        shear_factor: float = 5.0 / 6.0,
    ) -> Section:
        """Make a solid rectangle of an isotropic material.

        Parameters
        ----------
        width : float
            Along axis 3, m.
        height : float
            Along axis 2, m: the bending stiffness in the plane is ``young * width * height**3 / 12``.
        young : float
            Young's modulus, Pa.
        poisson : float
            Poisson's number, in (-1, 0.5].
        density : float
            kg/m^3.
        shear_factor : float, optional
            Factor k of kGA, 5/6 by default.

        Returns
        -------
        Section
            With the torsion constant of Young and Budynas, Roark's Formulas, 7th ed., table 10.1.

        Raises
        ------
        DataError
            If a value is out of its range.
        """
        b, h = _dimension("width", width), _dimension("height", height)
        long, short = max(b, h), min(b, h)
        twist = long * short**3 * (1.0 / 3.0 - 0.21 * short / long * (1.0 - (short / long) ** 4 / 12.0))
        return cls._isotropic(
            b * h,
            (h * b**3 / 12.0, b * h**3 / 12.0),
            twist,
            young=young,
            poisson=poisson,
            density=density,
            shear_factor=shear_factor,
        )

    @classmethod
    def circle(
        cls, radius: float, young: float, poisson: float, density: float, shear_factor: float = 6.0 / 7.0
    ) -> Section:
        """Make a solid circle of an isotropic material.

        Parameters
        ----------
        radius : float
            m.
        young : float
            Young's modulus, Pa.
        poisson : float
            Poisson's number, in (-1, 0.5].
        density : float
            kg/m^3.
        shear_factor : float, optional
            Factor k of kGA, 6/7 by default.

        Returns
        -------
        Section
            Equal stiffness about both axes.

        Raises
        ------
        DataError
            If a value is out of its range.
        """
        r = _dimension("radius", radius)
        second = math.pi * r**4 / 4.0
        return cls._isotropic(
            math.pi * r**2,
            (second, second),
            2.0 * second,
            young=young,
            poisson=poisson,
            density=density,
            shear_factor=shear_factor,
        )

    @classmethod
    def tube(
        cls,
        radius: float,
        thickness: float,
        young: float,
        poisson: float,
        density: float,
        shear_factor: float = 0.5,
    ) -> Section:
        """Make a round tube of an isotropic material.

        Parameters
        ----------
        radius : float
            Outer radius, m.
        thickness : float
            Of the wall, m, less than the radius.
        young : float
            Young's modulus, Pa.
        poisson : float
            Poisson's number, in (-1, 0.5].
        density : float
            kg/m^3.
        shear_factor : float, optional
            Factor k of kGA, 1/2 (thin tube) by default.

        Returns
        -------
        Section
            Equal stiffness about both axes.

        Raises
        ------
        DataError
            If a value is out of its range.
        """
        outer = _dimension("radius", radius)
        inner = outer - require_positive("Section thickness", thickness)
        if inner <= 0.0:
            raise DataError(
                "Section thickness",
                expected=f"less than the radius {outer}",
                got=repr(thickness),
                fix="Use circle().",
            )
        second = math.pi * (outer**4 - inner**4) / 4.0
        return cls._isotropic(
            math.pi * (outer**2 - inner**2),
            (second, second),
            2.0 * second,
            young=young,
            poisson=poisson,
            density=density,
            shear_factor=shear_factor,
        )

    def coefficients(self, space: Space) -> Floats:
        """Return what multiplies the rate of each of the twelve components in the energy.

        Parameters
        ----------
        space : Space
            A spatial beam needs the torsional stiffness.

        Returns
        -------
        numpy.ndarray
            Shape (12,): inertias of V1 V2 V3 (kg/m) and W1 W2 W3 (kg m), compliances of N1 N2 N3 (1/N) and
            M1 M2 M3 (1/(N m^2)).

        Raises
        ------
        DataError
            If the space has torsion and the section has none.
        """
        if self.torsion is None and 0 in space.rotation:
            raise DataError(
                "Section torsion",
                expected=f"GJ for a {SPATIAL.name} beam",
                got="none",
                fix="Give torsion=GJ, N m^2.",
            )
        (i2, i3), (s2, s3), (b2, b3) = (_pair(n, getattr(self, n)) for n in ("rotary", "shear", "bending"))
        polar = i2 + i3 if self.polar is None else self.polar
        torsion = math.inf if self.torsion is None else self.torsion
        inertia = [self.mass, self.mass, self.mass, polar, i2, i3]
        return np.array(inertia + [1.0 / k for k in (self.axial, s2, s3, torsion, b2, b3)])


def _dimension(name: str, value: object) -> float:
    """Check a width or the like: its fourth power must still be a number."""
    size = require_positive(f"Section {name}", value)
    if not SMALLEST <= size <= 1.0 / SMALLEST:
        raise DataError(
            f"Section {name}",
            expected=f"between {SMALLEST:g} m and {1.0 / SMALLEST:g} m",
            got=repr(value),
            fix="Give a value in m.",
        )
    return size


def _require_stiffness(where: str, value: object) -> None:
    """Check a stiffness: positive; infinity is one of no compliance."""
    number = require_real(where, value)
    if math.isinf(number) and value != number:
        got = "a number too large for floating point"
        raise DataError(where, expected="a number > 0, or math.inf", got=got, fix="Give a value in SI units.")
    if not (number > 0.0 and math.isfinite(1.0 / number)):
        raise DataError(where, expected="a number > 0, or math.inf", got=repr(value), fix="Give a value in SI units.")


def _pair(name: str, value: object) -> tuple[float, float]:
    if isinstance(value, (tuple, list)):
        if len(value) != 2:
            raise ArgumentTypeError(
                f"Section {name}",
                expected="a number or a pair",
                got=f"{len(value)} values",
                fix="Give (about 2, about 3).",
            )
        return value[0], value[1]
    return value, value  # type: ignore[return-value]  # require_positive names what is wrong with it
