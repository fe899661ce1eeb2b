"""The variables of an FMU: inputs, outputs, energies, with units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from phblocks.export.extras import require_extra
from phblocks.export.statespace import legal_names
from phblocks.fmu.runtime import Runtime

#: Units with a name as powers of the base units of FMI.
NAMED: dict[str, dict[str, int]] = {
    **{base: {base: 1} for base in ("kg", "m", "s", "A", "rad")},
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
}


def declare(slave: Any, runtime: Runtime) -> None:
    """Register all variables.

    Parameters
    ----------
    slave : pythonfmu3.Fmi3Slave
        The instance.
    runtime : Runtime
        What they are read from and written to.
    """
    pythonfmu3 = require_extra("pythonfmu3", "fmu", "FMU")
    unit_class = require_extra("pythonfmu3.unit", "fmu", "FMU").Unit
    causality, variability = pythonfmu3.Fmi3Causality, pythonfmu3.Fmi3Variability
    inputs = runtime.system.inputs
    names = structured([*runtime.system.input_names, *runtime.system.output_names])
    units = [*(i.imposed.unit for i in inputs), *(i.answered.unit for i in inputs)]
    bases = {unit: base_units(unit) for unit in ("s", "J", *units)}
    slave.register_units([unit_class(unit, **base) for unit, base in bases.items() if base is not None])

    def add(name: str, unit: str, role: Any, read: Any, write: Any = None, **more: Any) -> None:
        known = unit if bases.get(unit) is not None else None
        variable = pythonfmu3.Float64(name, unit=known, causality=role, getter=read, setter=write, **more)
        slave.register_variable(variable, nested=False)

    def set_input(k: int, value: float) -> None:
        runtime.u[k] = value

    add("time", "s", causality.independent, lambda: runtime.time, variability=variability.continuous)
    for k in range(len(inputs)):
        add(names[k], units[k], causality.input, lambda k=k: runtime.u[k], lambda v, k=k: set_input(k, v))
    for k, (name, unit) in enumerate(zip(names[len(inputs) :], units[len(inputs) :], strict=True)):
        add(name, unit, causality.output, lambda k=k: runtime.outputs()[k])
    for key in ("stored", "gravity", "supplied", "dissipated", "error"):
        add(f"energy.{key}", "J", causality.output, lambda key=key: runtime.energy[key])
    add(
        "longest_step",
        "s",
        causality.parameter,
        lambda: runtime.longest_step,
        lambda v: setattr(runtime, "longest_step", v),
        variability=variability.tunable,
    )


def structured(names: list[str]) -> list[str]:
    """Make names that FMI calls structured: identifiers joined by dots.

    Parameters
    ----------
    names : list of str
        Such as ``"tip.x velocity"``.

    Returns
    -------
    list of str
        Such as ``"tip.x_velocity"``, all different.
    """
    plain = [".".join(re.sub(r"^(?=\d)", "_", legal_names([part])[0]) for part in name.split(".")) for name in names]
    ascii_names = [re.sub(r"[^\x00-\x7f]", "_", name) for name in plain]
    return [name if ascii_names.index(name) == i else f"{name}_{i}" for i, name in enumerate(ascii_names)]


def base_units(unit: str) -> Mapping[str, int] | None:
    """Write a unit as powers of base units.

    Parameters
    ----------
    unit : str
        Such as ``"N m/rad"``: units with spaces between them, powers with ^, divided by those after a slash.

    Returns
    -------
    mapping of str to int or None
        ``None`` if a part of it is not known.
    """
    if unit.count("/") > 1:
        return None
    powers: dict[str, int] = {}
    for i, side in enumerate(unit.split("/")):
        for part in side.split():
            name, _, power = part.partition("^")
            if name == "1" and not power:
                continue
            if name not in NAMED or not (power or "1").lstrip("-").isdigit():
                return None
            for base, exponent in NAMED[name].items():
                powers[base] = powers.get(base, 0) + (-1 if i else 1) * exponent * int(power or 1)
    return powers or None
