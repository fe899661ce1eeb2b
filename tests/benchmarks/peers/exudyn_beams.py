"""The scenes of the accuracy page in Exudyn, a C++ multibody code: its geometrically exact planar beam.

Generalised-alpha with Newton's absolute and relative tolerance 1e-4, sparse Eigen solver, results kept in memory at the
times asked for only; what Exudyn's own examples do. ``pip install exudyn``;
J. Gerstmayr, Exudyn, Multibody System Dynamics 60 (2024), doi:10.1007/s11044-023-09937-1.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    LoadForceVector,
    LoadMassProportional,
    LoadTorqueVector,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerNodePosition,
    MarkerNodeRigid,
    NodeRigidBody2D,
    ObjectBeamGeometricallyExact2D,
    ObjectGround,
    ObjectJointRevolute2D,
    SensorNode,
)

Array = np.ndarray[Any, np.dtype[np.float64]]
Point = tuple[float, float]


@dataclass(frozen=True)
class Run:
    """Positions of one point at the times asked for, and what they cost."""

    t: Array
    positions: Array
    seconds: float
    steps: int
    finished: bool


@dataclass(frozen=True)
class Bar:
    """Stiffnesses and inertias of a beam."""

    EA: float
    kGA: float
    EI: float
    mass: float
    inertia: float


class Scene:
    """Beams, pins and gravity; one point is watched."""

    def __init__(self, gravity: Point = (0.0, 0.0)) -> None:
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.gravity = [*gravity, 0.0]
        self.ground = self.system.AddObject(ObjectGround())
        self.sensor = -1

    def beam(self, bar: Bar, start: Point, end: Point, elements: int, order: int) -> list[int]:
        """Add a beam; return its nodes."""
        a, b = np.array(start), np.array(end)
        length, angle = float(np.linalg.norm(b - a)), math.atan2(*(b - a)[::-1])
        places = np.linspace(0.0, 1.0, elements * order + 1)
        nodes = [self.system.AddNode(NodeRigidBody2D(referenceCoordinates=[*(a + s * (b - a)), angle])) for s in places]
        for e in range(elements):
            element = self.system.AddObject(
                ObjectBeamGeometricallyExact2D(
                    nodeNumbers=nodes[e * order : (e + 1) * order + 1],
                    length=length / elements,
                    massPerLength=bar.mass,
                    crossSectionInertia=bar.inertia,
                    bendingStiffness=bar.EI,
                    axialStiffness=bar.EA,
                    shearStiffness=bar.kGA,
                    includeReferenceRotations=True,
                )
            )
            if any(self.gravity):
                marker = self.system.AddMarker(MarkerBodyMass(bodyNumber=element))
                self.system.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=self.gravity))
        return nodes

    def pin(self, node: int, other: int | Point) -> None:
        """Join two nodes, or a node and a place, so that they can turn."""
        first = self.system.AddMarker(MarkerNodePosition(nodeNumber=node))
        if isinstance(other, tuple):
            second = self.system.AddMarker(MarkerBodyPosition(bodyNumber=self.ground, localPosition=[*other, 0.0]))
        else:
            second = self.system.AddMarker(MarkerNodePosition(nodeNumber=other))
        self.system.AddObject(ObjectJointRevolute2D(markerNumbers=[first, second]))

    def load(self, node: int, force: Point, moment: float, factor: Callable[[float], float]) -> None:
        """Load a node; the factor is a function of time."""

        def vector(_: Any, t: float, load: list[float]) -> list[float]:
            return [factor(t) * x for x in load]

        marker = self.system.AddMarker(MarkerNodeRigid(nodeNumber=node))
        self.system.AddLoad(
            LoadForceVector(markerNumber=marker, loadVector=[*force, 0.0], loadVectorUserFunction=vector)
        )
        self.system.AddLoad(
            LoadTorqueVector(markerNumber=marker, loadVector=[0.0, 0.0, moment], loadVectorUserFunction=vector)
        )

    def watch(self, node: int) -> None:
        """Record the position of a node."""
        sensor = SensorNode(
            nodeNumber=node, outputVariableType=exu.OutputVariableType.Position, storeInternal=True, writeToFile=False
        )
        self.sensor = self.system.AddSensor(sensor)

    def run(self, t_end: float, dt: float, every: float, modified: bool = False, adaptive: bool = False) -> Run:
        """Integrate, and time that alone."""
        self.system.Assemble()
        settings = exu.SimulationSettings()
        steps = round(t_end / dt)
        integration = settings.timeIntegration
        integration.numberOfSteps, integration.endTime, integration.verboseMode = steps, t_end, 0
        integration.newton.useModifiedNewton = modified
        integration.newton.absoluteTolerance = integration.newton.relativeTolerance = 1e-4
        integration.adaptiveStep = adaptive
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = every
        settings.show.statistics = False
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        clock, finished = time.perf_counter(), True
        try:
            self.system.SolveDynamic(settings)
        except Exception:  # the only sign that Exudyn gives of a failed run
            finished = False
        seconds = time.perf_counter() - clock
        data = np.asarray(self.system.GetSensorStoredData(self.sensor))
        return Run(data[:, 0], data[:, 1:3], seconds, steps, finished)


def four_bar(elements: Sequence[int], order: int, dt: float, t_end: float = 10.0, **options: bool) -> Run:
    """The reference four-bar (physics.md, section 6): the middle of the coupler once a second."""
    side, young, density = 0.05, 2.1e11, 2710.0
    area, second = side**2, side**4 / 12
    bar = Bar(young * area, young / 2.6 * area, young * second, density * area, density * second)
    scene = Scene((0.0, -9.81))
    crank, coupler, rocker = (
        scene.beam(bar, start, end, n, order)
        for (start, end), n in zip(
            [((0.0, 0.5), (2.0, 1.5)), ((2.0, 1.5), (3.5, 1.5)), ((3.5, 1.5), (2.5, 0.5))], elements, strict=True
        )
    )
    scene.pin(crank[0], (0.0, 0.5))
    scene.pin(crank[-1], coupler[0])
    scene.pin(coupler[-1], rocker[0])
    scene.pin(rocker[-1], (2.5, 0.5))
    assert len(coupler) % 2, "the coupler needs a node in its middle"
    scene.watch(coupler[len(coupler) // 2])
    return scene.run(t_end, dt, 1.0, **options)


def rubber_pendulum(elements: int, order: int, dt: float, t_end: float = 1.0, **options: bool) -> Run:
    """A bar of rubber, 1 m long, falling from the horizontal: its tip at the end."""
    radius, young, shear, factor, density = 0.01, 5e6, 5e6 / 3.0, 0.9642857142857143, 1000.0
    area, second = math.pi * radius**2, math.pi * radius**4 / 4
    bar = Bar(young * area, factor * shear * area, young * second, density * area, density * second)
    scene = Scene((0.0, -9.81))
    nodes = scene.beam(bar, (0.0, 0.0), (1.0, 0.0), elements, order)
    scene.pin(nodes[0], (0.0, 0.0))
    scene.watch(nodes[-1])
    return scene.run(t_end, dt, t_end, **options)


def flying_spaghetti(elements: int, order: int, dt: float, t_end: float = 6.0, **options: bool) -> Run:
    """Simo's free flexible beam under a force and a moment at one end until t = 2.5 s: that end."""
    scene = Scene()
    nodes = scene.beam(Bar(1e4, 1e4, 100.0, 1.0, 10.0), (6.0, 0.0), (0.0, 8.0), elements, order)
    scene.load(nodes[0], (8.0, 0.0), -80.0, lambda t: 1.0 if t <= 2.5 else 0.0)
    scene.watch(nodes[0])
    return scene.run(t_end, dt, 0.5, **options)
