"""What can be read of parts that turn in space: all that does not depend on how their frames stand."""

from __future__ import annotations

from collections.abc import Sequence

from phblocks.errors import OrientationError
from phblocks.frames import Attitude
from phblocks.system import Part
from phblocks.triplets import Floats


def require_frames(parts: Sequence[Part], what: str) -> None:
    """Check that the frames of parts stay as they are, or turn in the plane.

    Parameters
    ----------
    parts : sequence of Part
        The blocks.
    what : str
        What is asked for, for the message.

    Raises
    ------
    OrientationError
        If one of them turns in space.
    """
    turning = [part.name for part in parts if part.form.unoriented]
    if turning:
        raise OrientationError(
            f"{what} of {turning[0]!r}",
            expected="a part whose frames stay as they are (large_rotation=False), or a planar one",
            got="one that turns in space: how its frames stand then is not computed yet",
            fix='Read velocities, forces, moments and spins in its own frames, frame="material".',
        )


def in_frame(material: Floats, attitude: Attitude, frame: str) -> Floats:
    """Return components of vectors of space in the frame asked for.

    Parameters
    ----------
    material : numpy.ndarray
        Components in the material frame, shape (times, 3).
    attitude : Attitude
        How that stands.
    frame : {"fixed", "material"}
        Which is asked for.

    Returns
    -------
    numpy.ndarray
        Shape (times, 3).

    Raises
    ------
    OrientationError
        If it is the fixed one, and the material one turns.
    """
    if frame == "material":
        return material
    if not attitude.fixed:
        raise OrientationError(
            'frame="fixed" of what turns in space',
            expected='frame="material"',
            got="the fixed one: how the material frame stands is not computed yet",
            fix='Read it with frame="material", or leave large rotations out.',
        )
    return material @ attitude.start.T
