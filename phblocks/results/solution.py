"""The result of a run: arrays with names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Literal

import numpy as np

from phblocks.blocks.block import Block, BlockPoint
from phblocks.blocks.checks import is_one_of, require_real
from phblocks.blocks.form import History, Profile
from phblocks.errors import ArgumentTypeError, DataError, ForeignBlockError, UnknownNameError
from phblocks.frames import Attitude, rotate
from phblocks.ports import Anchor, Place
from phblocks.results.attitudes import in_frame, require_frames
from phblocks.results.ends import Ends
from phblocks.results.gaps import joint_gaps
from phblocks.results.kinematics import Base, Chords, bases, held_at, history_of
from phblocks.results.labels import Labels
from phblocks.results.limits import Limits
from phblocks.results.readings import Readings
from phblocks.results.recording import Recording
from phblocks.results.status import Statistics, Status
from phblocks.system import Part, Site, State, System
from phblocks.triplets import Floats, Ints

Source = Literal["velocity", "strain"]
Frame = Literal["fixed", "material"]
Target = Block | BlockPoint | Anchor | str


@dataclass(frozen=True, repr=False)
class Solution(Readings):
    """States, positions, energies and powers of a run.

    Parameters
    ----------
    system : System
        What was integrated.
    recording : Recording
        The arrays.
    status : Status
        How the run ended.
    statistics : Statistics
        What it took.
    limits : Limits, optional
        What its health is judged by.
    """

    system: System
    recording: Recording
    status: Status
    statistics: Statistics
    limits: Limits = field(default_factory=Limits)

    def at(self, time: float) -> State:
        """Return everything that evolves at a saved time, to start again from or to linearise about.

        Parameters
        ----------
        time : float
            s; the nearest saved time is taken.

        Returns
        -------
        State
            For ``simulate(..., start=...)``, ``system.linearize``, ``system.modes`` and ``system.export``.

        Raises
        ------
        DataError
            If the time is outside the run.
        """
        t = require_real("solution.at time", time)
        if not self.t[0] - 1e-9 <= t <= self.t[-1] * (1.0 + 1e-9) + 1e-9:
            raise DataError(
                "solution.at time",
                expected=f"a time from {self.t[0]:g} s to {self.t[-1]:g} s",
                got=repr(time),
                fix="Ask for a time within the run.",
            )
        i = int(np.abs(self.t - t).argmin())
        return State(self.recording.x[i], self.recording.theta[i], self.recording.points[i])

    def sliced(self, times: Ints) -> Solution:
        """Return the solution at some of the saved times, so that read-outs cost no more than those.

        Parameters
        ----------
        times : numpy.ndarray
            Numbers of the saved times.

        Returns
        -------
        Solution
            With these times only; energies and ledger are those at these times.
        """
        return replace(self, recording=self.recording.sliced(times))

    def state(self, name: str) -> Floats:
        """Return the series of one state; of one that is left out (``system.effects``) what it stays.

        Parameters
        ----------
        name : str
            Such as ``"crank.V1[0]"``; those that are computed are in ``system.state_names``.

        Returns
        -------
        numpy.ndarray
            Shape (times,).

        Raises
        ------
        UnknownNameError
            If there is no such state.
        """
        left_out = self.system.pruning.constants(self.system)
        if isinstance(name, str) and name in left_out:
            return np.full(self.t.size, left_out[name])
        return super().state(name)

    @cached_property
    def labels(self) -> Labels:
        """The names of the system."""
        return Labels.of(self.system)

    def position(self, target: Target, s: Place | None = None, source: Source | None = None) -> Floats:
        """Return the path of a point.

        Parameters
        ----------
        target : Block, BlockPoint, Anchor or str
            A block or its name together with ``s``, or ``beam.at(s)``, or an anchor such as ``beam.end``.
        s : Place, optional
            Place on the block: on a beam the fraction of the length, on a rigid body coordinates in its frame.
        source : {"velocity", "strain"}, optional
            "velocity": integrated from velocity, exact for the energy of gravity, with an error of relative size
            ``(spin * dt)**2 / 24`` in rotation. "strain": rebuilt from strain and orientation. By default
            velocity if positions are tracked, else strain.

        Returns
        -------
        numpy.ndarray
            Shape (times, dimension), m, in the fixed frame.

        Raises
        ------
        DataError
            If ``s`` is not a place on the block or the source is unknown.
        UnknownNameError
            If the block is not in the system, or positions were not tracked.
        OrientationError
            If the block turns in space.
        """
        part, place = self._target(target, s)
        require_frames([part], "position")
        history = self._history(part)
        if source is None:
            source = "velocity" if history.points is not None else "strain"
        if is_one_of(source, ("velocity",)):
            return part.form.position(history, place)
        if is_one_of(source, ("strain",)):
            base = self._bases.get(part.name)
            if base is None:
                raise UnknownNameError(
                    f"position of {part.name!r} from strain",
                    expected="a block joined to the ground, or tracked positions",
                    got="neither",
                    fix='Compile with outputs="all".',
                )
            self._require_angles(part)
            return base.position + part.form.chord(history, base.place, place)
        raise DataError("source", expected='"velocity" or "strain"', got=repr(source), fix="Choose one of them.")

    def angle(self, target: Target, s: Place | None = None) -> Floats:
        """Return the orientation of a cross section.

        Parameters
        ----------
        target : Block, BlockPoint, Anchor or str
            A block or its name together with ``s``, or ``beam.at(s)``, or an anchor.
        s : Place, optional
            Place on the block.

        Returns
        -------
        numpy.ndarray
            Shape (times,), rad, counted on over full turns.

        Raises
        ------
        UnknownNameError
            If the orientation was not kept.
        """
        known = self.system.anchor_angles.get(target.path) if isinstance(target, Anchor) and s is None else None
        if known is not None and not self._frame_is_held(target):
            places, weights, reference = known
            return np.asarray(reference + self.recording.theta[:, places] @ weights)
        part, place = self._target(target, s)
        self._require_angles(part)
        return part.form.angle(self._history(part), place)

    def velocity(self, target: Target, s: Place | None = None, frame: Frame = "fixed") -> Floats:
        """Return the velocity of a point.

        Parameters
        ----------
        target : Block, BlockPoint, Anchor or str
            A block or its name together with ``s``, or ``beam.at(s)``, or an anchor.
        s : Place, optional
            Place on the block.
        frame : {"fixed", "material"}, optional
            Where the components are taken.

        Returns
        -------
        numpy.ndarray
            Shape (times, dimension), m/s.

        Raises
        ------
        OrientationError
            If components in the fixed frame are asked for of what turns in space.
        """
        part, place = self._target(target, s)
        port = self._ends.port(part, place, "translation")
        known = None if port is None else self._ends.common(port)
        if known is not None:
            return self._from_fixed(known, target, s, frame)
        return self._turned(part.form.velocity(self._history(part), place), target, s, frame)

    def force(self, target: Target, s: Place | None = None, frame: Frame = "material") -> Floats:
        """Return the internal force of a beam: axial and shear force in the material frame.

        At an end it is what the joint there transmits. Elsewhere, where the force is discontinuous (towards an end
        that takes force), it is a polynomial of degree k - 1 in each element: at degree 1 a constant, which is off by
        up to half an element.

        Parameters
        ----------
        target : Block, BlockPoint, Anchor or str
            A block or its name together with ``s``, or ``beam.at(s)``, or an anchor.
        s : Place, optional
            Place on the block.
        frame : {"material", "fixed"}, optional
            Where the components are taken.

        Returns
        -------
        numpy.ndarray
            Shape (times, dimension), N: what the part towards the end does to the part towards the start.

        Raises
        ------
        OrientationError
            If components in the fixed frame are asked for of what turns in space.
        """
        part, place = self._target(target, s)
        sign, port = part.form.cut_sign(place), self._ends.port(part, place, "translation")
        known = None if sign is None or port is None else self._ends.summed(port)
        if known is not None and sign is not None:
            return self._from_fixed(sign * known, target, s, frame)
        return self._turned(self._components(part, place, "N"), target, s, frame)

    def moment(self, target: Target, s: Place | None = None) -> Floats:
        """Return the internal bending moment of a beam; in space also the twisting one.

        At an end it is what the joint there transmits. Elsewhere, where the moment is discontinuous (towards an end
        that takes moment), it is a polynomial of degree k - 1 in each element: at degree 1 a constant, which is off by
        up to half an element.

        Parameters
        ----------
        target : Block, BlockPoint, Anchor or str
            A block or its name together with ``s``, or ``beam.at(s)``, or an anchor.
        s : Place, optional
            Place on the block.

        Returns
        -------
        numpy.ndarray
            Shape (times,), N m; in space (times, 3), in the material frame.
        """
        part, place = self._target(target, s)
        sign, port = part.form.cut_sign(place), self._ends.port(part, place, "rotation")
        known = None if sign is None or port is None else self._ends.summed(port)
        if known is not None and sign is not None:
            return _alone(self._from_fixed(sign * known, target, s, "material", "rotation"))
        return _alone(self._components(part, place, "M"))

    def spin(self, target: Target, s: Place | None = None) -> Floats:
        """Return the angular velocity of a cross section.

        Parameters
        ----------
        target : Block, BlockPoint, Anchor or str
            A block or its name together with ``s``, or ``beam.at(s)``, or an anchor.
        s : Place, optional
            Place on the block.

        Returns
        -------
        numpy.ndarray
            Shape (times,), rad/s; in space (times, 3), in the material frame.
        """
        part, place = self._target(target, s)
        port = self._ends.port(part, place, "rotation")
        known = None if port is None else self._ends.common(port)
        if known is None:
            return _alone(self._components(part, place, "W"))
        return _alone(self._from_fixed(known, target, s, "material", "rotation"))

    def closure(self, source: Source = "strain") -> Mapping[str, Floats]:
        """Return the gap of every joint: joints are closed in velocity, not in position.

        Joints with multipliers are among them; that of a slider is the distance that opens across its guide. Joints to
        imposed motions are left out if the run was started elsewhere than in the initial configuration: how far those
        had come by then is not part of a state.

        Parameters
        ----------
        source : {"strain", "velocity"}, optional
            From which positions.

        Returns
        -------
        mapping of str to numpy.ndarray
            For each joint the largest distance between what it joins, shape (times,), m; by the anchors, a slider by
            its name.

        Raises
        ------
        OrientationError
            If a block turns in space.
        """
        require_frames(self.system.parts, "closure")
        return joint_gaps(self.system, self.recording, lambda site: self._spots(site, source))

    def animate(
        self,
        path: str | PathLike[str],
        *,
        colour: Profile | None = "moment",
        trails: Sequence[BlockPoint | Anchor] = (),
        speed: float = 1.0,
        fps: float = 25.0,
    ) -> Path:
        """Write a film of the run, deformed to scale: see :func:`phblocks.report.write_animation`.

        Parameters
        ----------
        path : str or path-like
            By suffix ``.html`` (a page that needs nothing else), ``.gif`` or ``.mp4`` (extra ``film``).
        colour : {"moment", "energy"} or None, optional
            Colour of beams: bending moment, N m, or strain energy a length, J/m.
        trails : sequence of BlockPoint or Anchor, optional
            Points that leave a trail.
        speed : float, optional
            Seconds of the run in a second of the film.
        fps : float, optional
            Pictures a second.

        Returns
        -------
        pathlib.Path
            Where it is.

        Raises
        ------
        ExportError
            If the suffix is another.
        ExtraMissingError
            If there is no ffmpeg for an MP4.
        DataError
            If speed or fps is not positive, the colour unknown, or no block has an extension.
        ArgumentTypeError
            If a trail is not a point.
        """
        from phblocks.report import write_animation

        return write_animation(self, path, colour=colour, trails=trails, speed=speed, fps=fps)

    def report(self, path: str | PathLike[str], *, colour: Profile | None = "moment") -> Path:
        """Write one page about the run that needs nothing else: see :func:`phblocks.report.write_report`.

        Parameters
        ----------
        path : str or path-like
            With suffix ``.html``.
        colour : {"moment", "energy"} or None, optional
            Colour of beams in the animation.

        Returns
        -------
        pathlib.Path
            Where it is.

        Raises
        ------
        ExportError
            If the suffix is another.
        DataError
            If the colour is unknown.
        """
        from phblocks.report import write_report

        return write_report(self, path, colour=colour)

    def _spots(self, site: Site, source: Source) -> list[Floats]:
        """Where all that is joined at a site has gone."""
        spots = [self.position(name, place, source=source) for name, place in site.places]
        return spots + held_at(self.system, site, self.recording)

    def _components(self, part: Part, place: Place, field: str) -> Floats:
        """A field in the material frame, shape (times, components)."""
        space, history = self.system.space, self._history(part)
        directions = space.translation if field in "VN" else space.rotation
        return np.stack([part.form.value(history, f"{field}{d + 1}", place) for d in directions], axis=1)

    def _from_fixed(
        self, vector: Floats, target: Target, s: Place | None, frame: Frame, kind: str = "translation"
    ) -> Floats:
        """Components in the frame asked for, of a vector in the fixed one, as a port gives it."""
        self._require_frame(frame)
        attitude = self._attitude(target, s)
        if attitude is not None:
            return in_frame(vector @ attitude.start, attitude, frame)
        if frame == "fixed" or not self.system.space.turns(kind):
            return vector
        return rotate(-self.angle(target, s), vector)

    def _turned(self, material: Floats, target: Target, s: Place | None, frame: Frame) -> Floats:
        """Components in the frame asked for, of a vector in the material one."""
        self._require_frame(frame)
        attitude = self._attitude(target, s)
        if attitude is not None:
            return in_frame(material, attitude, frame)
        return material if frame == "material" else rotate(self.angle(target, s), material)

    def _attitude(self, target: Target, s: Place | None) -> Attitude | None:
        """How a place stands in space, at an end as what it is joined to lets it; ``None`` in the plane."""
        if not self.system.attitudes:
            return None
        part, place = self._target(target, s)
        port = self._ends.port(part, place, "translation")
        if port is not None and port.anchor is not None and port.anchor.path in self.system.attitudes:
            return self.system.attitudes[port.anchor.path]
        return part.form.attitude(place)

    @staticmethod
    def _require_frame(frame: object) -> None:
        if not is_one_of(frame, ("fixed", "material")):
            raise DataError("frame", expected='"fixed" or "material"', got=repr(frame), fix="Choose one of them.")

    @cached_property
    def _ends(self) -> Ends:
        return Ends(self.system, self.recording)

    @cached_property
    def _bases(self) -> Mapping[str, Base]:
        return bases(Chords(self.system, self.recording))

    def _history(self, part: Part) -> History:
        return history_of(self.system, self.recording, part)

    def _require_angles(self, part: Part) -> None:
        if not part.angles_known:
            raise UnknownNameError(
                f"orientation of {part.name!r}",
                expected="a system that keeps orientations",
                got="one compiled without",
                fix='Compile with outputs="all".',
            )

    def _frame_is_held(self, anchor: Target) -> bool:
        """Whether the frame of an anchor stays as it is at the start, though its block turns."""
        if not isinstance(anchor, Anchor) or anchor.block.shared:
            return False
        part = self.system.part(anchor.block.name)
        return part.form.frozen and part.theta.size > 0 and anchor.turns

    def _part(self, block: Block) -> Part:
        part = self.system.part(block.name)
        if block not in (part.block, part.block.original):
            raise ForeignBlockError(
                f"block {block.name!r}",
                expected=f"a block of system {self.system.name!r}",
                got="another one of the same name",
                fix="Ask with the block that was added to the diagram, or with its name.",
            )
        return part

    def _target(self, target: Target, s: Place | None) -> tuple[Part, Place]:
        if isinstance(target, (BlockPoint, Anchor)):
            if s is not None:
                raise DataError("s", expected="none together with a point", got=repr(s), fix="Leave it out.")
            return self._part(target.block), target.place
        if not isinstance(target, (Block, str)):
            raise ArgumentTypeError(
                "target",
                expected="a block, its name, beam.at(s) or an anchor",
                got=repr(target),
                fix="Give one.",
            )
        part = self.system.part(target) if isinstance(target, str) else self._part(target)
        if s is None:
            raise DataError(f"place on {part.name!r}", expected="s", got="none", fix="Give the place on the block.")
        return part, part.form.place(s, f"place on {part.name!r}")


def _alone(values: Floats) -> Floats:
    """A series of numbers if there is one component."""
    return values[:, 0] if values.shape[1] == 1 else values
