"""Flexible mechanisms and other port-Hamiltonian systems as block diagrams.

The names below are in the order of their use: make sections and blocks, join them in a diagram, check and
compile it to a system, simulate it, read the solution. A module is loaded when the first of its names is used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from phblocks import errors, export, fmu, plots, studies
    from phblocks.approximation import Approximation
    from phblocks.blocks.beam.beam import Beam
    from phblocks.blocks.beam.damping import Damping
    from phblocks.blocks.beam.load import LineLoad
    from phblocks.blocks.beam.section import Section
    from phblocks.blocks.body import Mass, RigidBody
    from phblocks.blocks.bushing import Bushing
    from phblocks.blocks.circuit import Capacitor, Inductor, Reference, Resistor
    from phblocks.blocks.custom import CustomBlock
    from phblocks.blocks.joints import RigidJoint, Slider
    from phblocks.blocks.motor import DCMotor
    from phblocks.blocks.parameter import Parameter
    from phblocks.blocks.sources import AngularVelocity, Current, Force, Moment, Velocity, Voltage
    from phblocks.blocks.spring import Damper, Spring
    from phblocks.blocks.system_block import SystemBlock, SystemPort
    from phblocks.blocks.torsion import TorsionDamper, TorsionSpring
    from phblocks.blocks.transformer import Gyrator, Transformer
    from phblocks.causality import CausalityReport
    from phblocks.diagram import Diagram, load
    from phblocks.effects import Effect, EffectsReport
    from phblocks.errors import PhblocksError
    from phblocks.files.access import read
    from phblocks.files.saved import SavedRun
    from phblocks.files.stream import Stream
    from phblocks.nesting import Nested
    from phblocks.ports import ELECTRICAL, HYDRAULIC, ROTATION, TRANSLATION, Anchor, Domain, Port, Quantity
    from phblocks.results.health import Health
    from phblocks.results.limits import Limits
    from phblocks.results.solution import Solution
    from phblocks.resumption import resume
    from phblocks.simulation import simulate
    from phblocks.solvers.adaptive import Adaptive
    from phblocks.solvers.discrete_gradient import DiscreteGradient
    from phblocks.solvers.gauss_legendre import GaussLegendre
    from phblocks.solvers.linearly_implicit import LinearlyImplicit
    from phblocks.solvers.midpoint import Midpoint
    from phblocks.solvers.newton import ModifiedNewton, Newton
    from phblocks.solvers.projection import Projection
    from phblocks.solvers.radau import RadauIIA
    from phblocks.solvers.scipy_ivp import ScipyIVP
    from phblocks.system import State, System
    from phblocks.system.stability import StabilityCard
else:
    #: Modules that are public themselves.
    _MODULES = ("errors", "export", "fmu", "plots", "studies")
    #: Where the other names are, by module.
    _NAMES = {
        "errors": "PhblocksError",
        "approximation": "Approximation",
        "blocks.beam.beam": "Beam",
        "blocks.beam.damping": "Damping",
        "blocks.beam.load": "LineLoad",
        "blocks.beam.section": "Section",
        "blocks.body": "Mass RigidBody",
        "blocks.bushing": "Bushing",
        "blocks.circuit": "Capacitor Inductor Reference Resistor",
        "blocks.custom": "CustomBlock",
        "blocks.joints": "RigidJoint Slider",
        "blocks.motor": "DCMotor",
        "blocks.parameter": "Parameter",
        "blocks.sources": "AngularVelocity Current Force Moment Velocity Voltage",
        "blocks.spring": "Damper Spring",
        "blocks.system_block": "SystemBlock SystemPort",
        "blocks.torsion": "TorsionDamper TorsionSpring",
        "blocks.transformer": "Gyrator Transformer",
        "causality": "CausalityReport",
        "diagram": "Diagram load",
        "effects": "Effect EffectsReport",
        "files.access": "read",
        "files.saved": "SavedRun",
        "files.stream": "Stream",
        "nesting": "Nested",
        "ports": "ELECTRICAL HYDRAULIC ROTATION TRANSLATION Anchor Domain Port Quantity",
        "results.health": "Health",
        "results.limits": "Limits",
        "results.solution": "Solution",
        "resumption": "resume",
        "simulation": "simulate",
        "solvers.adaptive": "Adaptive",
        "solvers.discrete_gradient": "DiscreteGradient",
        "solvers.gauss_legendre": "GaussLegendre",
        "solvers.linearly_implicit": "LinearlyImplicit",
        "solvers.midpoint": "Midpoint",
        "solvers.newton": "ModifiedNewton Newton",
        "solvers.projection": "Projection",
        "solvers.radau": "RadauIIA",
        "solvers.scipy_ivp": "ScipyIVP",
        "system": "State System",
        "system.stability": "StabilityCard",
    }
    _PLACES = {name: module for module, names in _NAMES.items() for name in names.split()}

    def __getattr__(name: str) -> object:
        """Load a name when it is first used (PEP 562); type checkers read the imports above instead."""
        if name in _MODULES:
            return import_module(f"phblocks.{name}")
        if name not in _PLACES:
            raise AttributeError(f"module 'phblocks' has no attribute {name!r}")
        value = globals()[name] = getattr(import_module(f"phblocks.{_PLACES[name]}"), name)
        return value

    def __dir__() -> list[str]:
        """List all public names, loaded or not."""
        return sorted({*globals(), *_MODULES, *_PLACES})


__all__ = [
    "ELECTRICAL",
    "HYDRAULIC",
    "ROTATION",
    "TRANSLATION",
    "Adaptive",
    "Anchor",
    "AngularVelocity",
    "Approximation",
    "Beam",
    "Bushing",
    "Capacitor",
    "CausalityReport",
    "Current",
    "CustomBlock",
    "DCMotor",
    "Damper",
    "Damping",
    "Diagram",
    "DiscreteGradient",
    "Domain",
    "Effect",
    "EffectsReport",
    "Force",
    "GaussLegendre",
    "Gyrator",
    "Health",
    "Inductor",
    "Limits",
    "LineLoad",
    "LinearlyImplicit",
    "Mass",
    "Midpoint",
    "ModifiedNewton",
    "Moment",
    "Nested",
    "Newton",
    "Parameter",
    "PhblocksError",
    "Port",
    "Projection",
    "Quantity",
    "RadauIIA",
    "Reference",
    "Resistor",
    "RigidBody",
    "RigidJoint",
    "SavedRun",
    "ScipyIVP",
    "Section",
    "Slider",
    "Solution",
    "Spring",
    "StabilityCard",
    "State",
    "Stream",
    "System",
    "SystemBlock",
    "SystemPort",
    "TorsionDamper",
    "TorsionSpring",
    "Transformer",
    "Velocity",
    "Voltage",
    "errors",
    "export",
    "fmu",
    "load",
    "plots",
    "read",
    "resume",
    "simulate",
    "studies",
]
__version__ = "0.1.0"
