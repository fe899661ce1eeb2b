"""The scenes of the accuracy page in Exudyn, a C++ multibody code: its geometrically exact planar beam.

Generalised-alpha with Newton's absolute and relative tolerance 1e-4, sparse Eigen solver, results kept in memory at the
times asked for only; what Exudyn's own examples do. Its fast build (without range checks, AVX2), one thread.
``pip install exudyn``;
J. Gerstmayr, Exudyn, Multibody System Dynamics 60 (2024), doi:10.1007/s11044-023-09937-1.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

sys.exudynFast = True  # type: ignore[attr-defined]  # Exudyn asks for it, before it is imported

import exudyn as exu  # noqa: E402
import numpy as np  # noqa: E402
from exudyn.itemInterface import (  # noqa: E402
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
    SensorUserFunction,
)
from exudyn.solver import ComputeLinearizedSystem  # noqa: E402

Array = np.ndarray[Any, np.dtype[np.float64]]
Point = tuple[float, float]


@dataclass(frozen=True)
class Run:
    """Positions of one point at the times asked for, and what they cost; energies only if they were asked for."""

    t: Array
    positions: Array
    seconds: float
    steps: int
    iterations: int
    unknowns: int
    finished: bool
    energies: Array  # kinetic, strain, gravity; shape (times, 3), J

    def at(self, times: Sequence[float]) -> Array:
        """Positions at some of the times, shape (times, 2)."""
        places = [int(np.abs(self.t - time).argmin()) for time in times]
        assert np.allclose(self.t[places], times), "a time was not recorded"
        return self.positions[places]


@dataclass(frozen=True)
class Bar:
    """Stiffnesses and inertias of a beam."""

    EA: float
    kGA: float
    EI: float
    mass: float
    inertia: float


@dataclass(frozen=True)
class Beam:
    """The nodes of a beam, straight at the start, for its energy: Exudyn tells forces, not energies."""

    bar: Bar
    order: int
    nodes: Array  # numbers, from one end to the other
    start: Array  # positions and angles of the nodes, shape (nodes, 3)
    element: float  # length

    def energies(self, moved: Array, gravity: Array) -> Array:
        """Strain and gravity energy; coordinates have the shape (nodes of the scene, 3).

        One Gauss point in an element of two nodes, two in one of three, as in Exudyn.
        """
        order, q = self.order, self.start + moved[self.nodes]
        elements = np.stack([q[i : len(q) - order + i : order] for i in range(order + 1)])
        points, weights = np.polynomial.legendre.leggauss(order)
        places = np.linspace(-1.0, 1.0, order + 1)
        basis = [np.polynomial.Polynomial.fit(places, row, order) for row in np.eye(order + 1)]
        shape = np.array([[f(x) for f in basis] for x in points])
        slope = np.array([[f.deriv()(x) for f in basis] for x in points]) * 2.0 / self.element
        at, rate = np.einsum("gi,ieq->geq", shape, elements), np.einsum("gi,ieq->geq", slope, elements)
        c, s, bar = np.cos(at[..., 2]), np.sin(at[..., 2]), self.bar
        axial, shear = c * rate[..., 0] + s * rate[..., 1] - 1.0, c * rate[..., 1] - s * rate[..., 0]
        density = 0.5 * (bar.EA * axial**2 + bar.kGA * shear**2 + bar.EI * rate[..., 2] ** 2)
        height = -(at[..., :2] @ gravity)
        return np.array([weights @ part.sum(axis=1) * self.element / 2.0 for part in (density, bar.mass * height)])


class Scene:
    """Beams, pins and gravity; one point is watched."""

    def __init__(self, gravity: Point = (0.0, 0.0)) -> None:
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.gravity = [*gravity, 0.0]
        self.ground = self.system.AddObject(ObjectGround())
        self.sensor = -1
        self.beams: list[Beam] = []

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
        at = np.array([[*(a + s * (b - a)), angle] for s in places])
        self.beams.append(Beam(bar, order, np.array(nodes, dtype=int), at, length / elements))
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

    def run(
        self,
        t_end: float,
        dt: float,
        every: float,
        modified: bool = False,
        adaptive: bool = False,
        energies: bool = False,
    ) -> Run:
        """Integrate, and time that alone; with energies the time says nothing."""
        numbers = {"position": self.sensor}
        if energies:
            every = min(every, 0.1)
            sensor = SensorUserFunction(
                sensorNumbers=[], factors=[], storeInternal=True, writeToFile=False, sensorUserFunction=self._energies
            )
            numbers["energy"] = self.system.AddSensor(sensor)
        self.system.Assemble()
        self._mass = np.asarray(ComputeLinearizedSystem(self.system)[0]) if energies else None
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
        data = {name: np.asarray(self.system.GetSensorStoredData(number)) for name, number in numbers.items()}
        return Run(
            t=data["position"][:, 0],
            positions=data["position"][:, 1:3],
            seconds=seconds,
            steps=self.system.sys["dynamicSolver"].it.currentStepIndex,
            iterations=self.system.sys["dynamicSolver"].it.newtonStepsCount,
            unknowns=len(self.system.systemData.GetODE2Coordinates()),
            finished=finished,
            energies=data["energy"][:, 1:] if energies else np.empty((0, 3)),
        )

    def _energies(self, system: Any, t: float, numbers: list[int], factors: list[float], configuration: Any) -> Any:
        moved = system.systemData.GetODE2Coordinates(configuration).reshape(-1, 3)
        rate = system.systemData.GetODE2Coordinates_t(configuration)
        stored = sum(beam.energies(moved, np.array(self.gravity[:2])) for beam in self.beams)
        return [float(0.5 * rate @ self._mass @ rate), *map(float, stored)]


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
    """Simo's free flexible beam under a force and a moment at one end until t = 2.5 s: that end.

    At 2.5 s itself half the loads act: Exudyn takes loads at the ends of steps, and any other value there makes an
    error of their impulse of first order in the step.
    """
    scene = Scene()
    nodes = scene.beam(Bar(1e4, 1e4, 100.0, 1.0, 10.0), (6.0, 0.0), (0.0, 8.0), elements, order)
    scene.load(nodes[0], (8.0, 0.0), -80.0, lambda t: 0.5 - 0.5 * math.copysign(min(1.0, abs(t - 2.5) * 1e6), t - 2.5))
    scene.watch(nodes[0])
    return scene.run(t_end, dt, 0.5, **options)
