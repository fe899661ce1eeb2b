"""What a diagram calls for: the pattern of its equations by components, and what its excitations reach in it.

A *component* is one run of states of a block, such as all nodes of ``V1`` of a beam. Entries of the matrices are taken
as they are at the start; those that go with an angle or a direction act on more as soon as that turns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from phblocks.assembly.entries import Entries
from phblocks.assembly.layout import Layout
from phblocks.assembly.points import Points
from phblocks.blocks.form import CONFIGURATION, Form
from phblocks.effects import PatternBuilder, Reached, reach
from phblocks.frames import ROUND_OFF, Turn
from phblocks.system import Sharing
from phblocks.triplets import Floats, Ints, Triplets, real_array

Mask = NDArray[np.bool_]


@dataclass
class Components:
    """The components of all blocks, numbered in the order of the coordinates.

    Parameters
    ----------
    names : list of (str, str)
        Block and field of each.
    of_coordinate : numpy.ndarray
        Component of each coordinate.
    first : dict of str to int
        The first of each block.
    configuration : numpy.ndarray
        Whether each belongs to the configuration.
    """

    names: list[tuple[str, str]]
    of_coordinate: Ints
    first: dict[str, int]
    configuration: Mask

    @classmethod
    def of(cls, layout: Layout) -> Components:
        """Number the components of a layout.

        Parameters
        ----------
        layout : Layout
            Of the diagram.

        Returns
        -------
        Components
            All of them.
        """
        runs = [(name, run) for name, form in layout.forms.items() for run in form.runs]
        counts = np.cumsum([0, *(len(form.runs) for form in layout.forms.values())]).tolist()
        return cls(
            [(name, run.field) for name, run in runs],
            np.repeat(np.arange(len(runs)), [run.positions.size for _, run in runs]),
            dict(zip(layout.forms, counts, strict=False)),
            np.array([run.energy == CONFIGURATION for _, run in runs], dtype=bool),
        )


@dataclass
class Reach:
    """The closure for a diagram.

    Parameters
    ----------
    components : Components
        The first nodes of the pattern.
    reached : Reached
        What the excitations reach.
    moving : numpy.ndarray
        For each component the node that says that it changes: itself, but for those of the configuration.
    joints, directions, inputs : int
        First node of the angles at joints, of the directions (two each) and of the inputs.
    theta : numpy.ndarray
        Node that each rotation state is the time integral of.
    excited : dict of int to str
        What excites nodes, in words.
    names : callable
        From a node to what it is, in words.
    """

    components: Components
    reached: Reached
    moving: Ints
    joints: int
    directions: int
    inputs: int
    theta: Ints
    excited: dict[int, str]
    names: Callable[[int], str]

    @property
    def anything(self) -> bool:
        """Whether the excitations reach any component that changes."""
        return bool(self.reached.mask[self.moving].any())

    def dropped(self) -> Mask:
        """Tell which components stay what they are at the start, and nobody asks what that is.

        Returns
        -------
        numpy.ndarray
            One for each component.
        """
        changes = self.reached.mask[self.moving]
        block = np.zeros(changes.size, dtype=np.int64)
        firsts = [first for first in self.components.first.values() if first < changes.size]
        np.add.at(block, firsts, 1)
        block = np.cumsum(block)
        active = np.zeros(block.max(initial=0) + 1, dtype=bool)
        active[block[changes]] = True
        return np.asarray(~np.where(self.components.configuration, active[block], changes))

    def quiet(self) -> Ints:
        """List inputs that are taken to be zero and would move, or turn, what is not reached.

        Returns
        -------
        numpy.ndarray
            Their numbers.
        """
        mask, pattern = self.reached.mask, self.reached.pattern
        pairs = np.concatenate([pattern.edges, pattern.products[[0, 2]], pattern.products[[1, 2]]], axis=1)
        would = np.concatenate([pairs[0][~mask[pairs[1]]], self.theta])
        return np.unique(would[(would >= self.inputs) & ~mask[would]]) - self.inputs


@dataclass
class _Scene:
    """A pattern in the making."""

    layout: Layout
    components: Components
    builder: PatternBuilder
    moving: Ints
    excited: dict[int, str] = field(default_factory=dict)


def find_reach(layout: Layout, joints: Entries, points: Points, gravity: Floats, sharing: Sharing) -> Reach:
    """Find what is reached by what excites a diagram.

    Parameters
    ----------
    layout : Layout
        Numbering and orientations.
    joints : Entries
        Of joints and inputs.
    points : Points
        The material points that gravity acts on; none without gravity.
    gravity : numpy.ndarray
        Acceleration, m/s^2.
    sharing : Sharing
        Of the states, with none left out.

    Returns
    -------
    Reach
        The closure.
    """
    components = Components.of(layout)
    n, builder = len(components.names), PatternBuilder()
    builder.add_nodes(n)
    moving = np.arange(n)
    moving[components.configuration] = n + np.arange(int(components.configuration.sum()))
    builder.add_nodes(int(components.configuration.sum()))
    builder.add_edges(moving[components.configuration], np.flatnonzero(components.configuration))
    scene = _Scene(layout, components, builder, moving)
    first_joint, first_frame = (builder.add_nodes(len(t)) for t in (joints.turns, joints.directions))
    first_direction = builder.add_nodes(2 * len(joints.directions))
    first_weight = builder.add_nodes(len(points.of_block))
    weight = builder.add_nodes(1)
    inputs = builder.add_nodes(len(layout.inputs))
    theta = np.empty(layout.n_theta, dtype=np.int64)
    theta[: layout.theta_states.size] = components.of_coordinate[layout.theta_states]
    rows, drivers = layout.driven_rows()
    theta[rows] = inputs + drivers
    for turns, first in ((joints.turns, first_joint), ([turn for _, turn in joints.directions], first_frame)):
        _add_turns(builder, turns, first, theta)
    _add_blocks(scene, sharing)
    start = _add_directions(scene, joints, first_frame, first_direction)
    phi = np.array([abs(f(t.reference)) > ROUND_OFF for t in joints.turns for f in (np.cos, np.sin)], dtype=bool)
    features = np.concatenate([phi, start])  # whether each differs from zero at the start

    def add(parts: Sequence[Triplets], targets: Ints, columns: Ints) -> None:
        """Entries with preliminary numbers of features."""
        i, j, f = Triplets.join(parts, order=3).indices
        number = np.where(f < 0, phi.size - f - 1, f - 1)
        changing = np.where(f < 0, first_direction - f - 1, first_joint + (f - 1) // 2)
        constant = f == 0
        constant[~constant] = features[number[~constant]]
        builder.add_edges(columns[j[constant]], targets[i[constant]])
        other = ~constant
        builder.add_products(columns[j[other]], changing[other], targets[i[other]])

    states, changes = components.of_coordinate, moving[components.of_coordinate]
    outside = inputs + np.arange(len(layout.inputs))
    add(joints.K, states, states)
    add(joints.kinematics, changes, states)
    add(joints.K_u, states, outside)
    add(joints.kinematics_u, changes, outside)
    if points.of_block:
        _add_weight(scene, points, gravity, weight, first_weight, theta)
    for number, what in _signals(layout):
        scene.excited[inputs + number] = what
    mask = np.zeros(builder.size, dtype=bool)
    mask[list(scene.excited)] = True
    begun = np.concatenate([np.zeros(f.size) if f.start is None else f.start for f in layout.forms.values()])
    at_start = np.unique(states[begun != 0.0])
    mask[at_start] = True
    reached = reach(builder.pattern(), mask)

    def name(node: int) -> str:
        if node < moving.max(initial=n - 1) + 1:
            component = node if node < n else int(np.flatnonzero(moving == node)[0])
            block, run = components.names[component]
            return f"{run} of {block!r}"
        if first_joint <= node < first_frame:
            return "the angle of a joint"
        if node < weight:
            return "a direction" if node < first_weight else "an orientation"
        return "gravity" if node == weight else f"input {layout.inputs[node - inputs].name!r}"

    excited = scene.excited
    for component in at_start[~components.configuration[at_start]]:
        excited.setdefault(int(component), "its start")
    return Reach(components, reached, moving, first_joint, first_direction, inputs, theta, excited, name)


def _add_turns(builder: PatternBuilder, turns: Sequence[Turn], first: int, theta: Ints) -> None:
    """Angles turn with the rotation states they depend on."""
    numbers = [first + m for m, turn in enumerate(turns) for _ in turn.places]
    builder.add_edges(theta[[p for turn in turns for p in turn.places] or np.empty(0, dtype=np.int64)], numbers)


def _add_blocks(scene: _Scene, sharing: Sharing) -> None:
    """The matrices of all blocks; what they share, and what is not linear, hangs together."""
    builder, component, forms = scene.builder, scene.components.of_coordinate, scene.layout.forms
    for order, kinds in ((2, ("E", "J0", "R")), (3, ("T",))):
        for kind in kinds:
            _add_tensors(scene, {name: getattr(form, kind) for name, form in forms.items()}, order)
    moved = {name: form.kinematics for name, form in forms.items() if form.kinematics.values.size}
    for name, entries in moved.items():
        i, j = (component[scene.layout.first_state[name] + axis] for axis in entries.indices)
        builder.add_edges(j, scene.moving[i])
    shared = sharing.expansion.tocoo()
    row, column = component[shared.coords[0]], component[sharing.kept[shared.coords[1]]]
    other = row != column
    builder.add_edges(np.concatenate([row[other], column[other]]), np.concatenate([column[other], row[other]]))
    for name, form in forms.items():
        if form.storage is None and form.modulation is None:
            continue
        first, count = scene.components.first[name], len(form.runs)
        own = first + np.arange(count)
        builder.add_edges(own[:, None], own[None, :])
        reason = _unquiet(form)
        if reason:
            scene.excited[first] = reason


def _unquiet(form: Form) -> str:
    """Why a block with an energy that is not quadratic does not stay as it is, if so."""
    if form.storage is None:
        return ""
    start = np.zeros(form.size) if form.start is None else form.start
    at = start[form.storage.energy]
    if np.any(form.storage.gradient(at)):
        return "the gradient of its energy at the start"
    return "its energy at the start" if form.storage.hamiltonian(at) != 0.0 else ""


def _add_tensors(scene: _Scene, of_blocks: dict[str, Triplets], order: int) -> None:
    """Matrices of blocks, each pair (triple) of components once; by marks in a cube for each block."""
    filled = [(name, entries) for name, entries in of_blocks.items() if entries.values.size]
    if not filled:
        return
    sizes = [entries.values.size for _, entries in filled]
    of = np.repeat(np.arange(len(filled)), sizes)
    state = np.array([scene.layout.first_state[name] for name, _ in filled])[of]
    first = np.array([scene.components.first[name] for name, _ in filled])
    count = np.array([len(scene.layout.forms[name].runs) for name, _ in filled])
    cubes = np.concatenate([[0], np.cumsum(count**order)])
    code = np.zeros(of.size, dtype=np.int64)
    for axis in range(order):
        index = np.concatenate([entries.indices[axis] for _, entries in filled])
        code = code * count[of] + scene.components.of_coordinate[index + state] - first[of]
    acting = np.concatenate([entries.values for _, entries in filled]) != 0.0
    marks = np.zeros(cubes[-1], dtype=bool)
    marks[(code + cubes[of])[acting]] = True
    code = np.flatnonzero(marks)
    of = np.searchsorted(cubes, code, side="right") - 1
    code -= cubes[of]
    axes = []
    for _ in range(order):
        axes.append(first[of] + code % count[of])
        code //= count[of]
    *columns, row = axes
    if order == 2:
        scene.builder.add_edges(columns[0], row)
    else:
        scene.builder.add_products(columns[0], columns[1], row)


def _add_directions(scene: _Scene, joints: Entries, first_frame: int, first_direction: int) -> Mask:
    """Directions change with their frame and with the span; tell which components are not zero at the start."""
    layout, count = scene.layout, len(joints.directions)
    if not count:
        return np.zeros(0, dtype=bool)
    spans = np.array([layout.first_state[name] + line.span for name, f in layout.forms.items() for line in f.lines])
    values = np.array(
        [f.start[line.span : line.span + 2] for f in layout.forms.values() for line in f.lines if f.start is not None]
    )
    line = np.array([line for line, _ in joints.directions])
    angle = np.array([turn.reference for _, turn in joints.directions])
    cos, sin = np.cos(angle), np.sin(angle)
    weights = np.stack([np.stack([cos, sin], axis=-1), np.stack([-sin, cos], axis=-1)], axis=1)
    weights[np.abs(weights) <= ROUND_OFF] = 0.0  # (direction, component, coordinate of the span)
    span = values[line][:, None, :]
    start = np.abs((weights * span).sum(axis=2)) > ROUND_OFF * np.linalg.norm(span, axis=2)
    number = first_direction + np.arange(2 * count).reshape(count, 2)
    scene.builder.add_edges((first_frame + np.arange(count))[:, None], number)
    for coordinate in range(2):
        d, b = np.nonzero(weights[:, :, coordinate])
        moved = scene.moving[scene.components.of_coordinate[spans[line[d]] + coordinate]]
        scene.builder.add_edges(moved, number[d, b])
    return np.asarray(start.ravel())


def _add_weight(scene: _Scene, points: Points, gravity: Floats, weight: int, first_weight: int, theta: Ints) -> None:
    """Gravity acts along the material directions that it has at the start, and along all once they turn."""
    block = np.repeat(np.arange(len(points.of_block)), [s.stop - s.start for s in points.of_block.values()])
    point, place = points.angle.rows.indices
    scene.builder.add_edges(theta[place], first_weight + block[point])
    row, state = points.velocity.indices
    at, component = row // gravity.size, row % gravity.size
    turned = points.angle.reference
    terms = np.stack([np.cos(turned)[:, None] * gravity, np.sin(turned)[:, None] * gravity[::-1] * (1.0, -1.0)])
    force = terms.sum(axis=0)
    force[np.abs(force) <= ROUND_OFF * np.linalg.norm(gravity)] = 0.0
    acting = force[at, component] * points.mass[at] != 0.0
    to = scene.components.of_coordinate[state]
    scene.builder.add_edges(weight, np.unique(to[acting]))
    pairs = np.unique(block[at] * len(scene.components.names) + to)
    pairs = np.stack([first_weight + pairs // len(scene.components.names), pairs % len(scene.components.names)])
    scene.builder.add_products(weight, *pairs)
    scene.excited[weight] = f"gravity ({', '.join(f'{g:g}' for g in gravity)})"


def _signals(layout: Layout) -> list[tuple[int, str]]:
    """The inputs that are not zero by their signal, in words."""
    found = []
    for number, given in enumerate(layout.inputs):
        what = f"{given.imposed.name} {given.name!r}"
        if given.signal is None:
            found.append((number, f"{what} (exposed)"))
        elif callable(given.signal):
            found.append((number, f"{what} (a function of time)"))
        else:
            values = real_array(given.signal)
            assert values is not None  # sources check their constants
            values, component = np.atleast_1d(values), number - layout.first_input[given.exposure]
            if abs(values[component]) > ROUND_OFF * np.abs(values).max():  # a quarter turn leaves 1e-17
                found.append((number, f"{what} (constant)"))
    return found
