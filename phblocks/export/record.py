"""The fields of an export file, the same in every format: which there are, and how they make up the matrices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import scipy.sparse as sp

from phblocks.errors import ExportError
from phblocks.export.matrices import Matrices, Tangent
from phblocks.export.nonlinear import LABELS as NAMES
from phblocks.export.nonlinear import LENGTHS, SHAPES, NonlinearModel, parts_of
from phblocks.triplets import Floats

#: First field of every file: what it is, and which fields to expect.
FILE_FORMAT = "phblocks matrices, version 1"

TEXTS = ("file_format", "name", "about", "convention")
LABELS = ("state_names", "state_units", "input_names", "input_units", "output_names", "output_units")
VECTORS = ("state_positions", "x0", "f0")
MATRICES = ("E", "J", "R", "Q", "G", "P", "S", "N")
# Present only together.
TANGENT_LABELS = ("lin_state_names", "lin_state_units")
TANGENT_MATRICES = ("A", "B", "C", "D", "E_lin")
NONLINEAR_LABELS = tuple(f"nl_{key}" for key in NAMES)
NONLINEAR_VECTORS = tuple(f"nl_{key}" for key in LENGTHS)
NONLINEAR_MATRICES = tuple(f"nl_{key}" for key in SHAPES)
#: All there may be.
ALL_LABELS = (*LABELS, *TANGENT_LABELS, *NONLINEAR_LABELS)
ALL_VECTORS = (*VECTORS, *NONLINEAR_VECTORS)
ALL_MATRICES = (*MATRICES, *TANGENT_MATRICES, *NONLINEAR_MATRICES)


@dataclass(frozen=True)
class Record:
    """The content of a file, by field.

    Parameters
    ----------
    texts : mapping of str to str
        The fields ``TEXTS``.
    labels : mapping of str to tuple of str
        The fields ``LABELS``, ``TANGENT_LABELS`` if there is a tangent, ``NONLINEAR_LABELS`` if the nonlinear model.
    vectors : mapping of str to numpy.ndarray
        The fields ``VECTORS``, each of shape (n,), and ``NONLINEAR_VECTORS``.
    matrices : mapping of str to scipy.sparse array
        The fields ``MATRICES``, and ``TANGENT_MATRICES`` and ``NONLINEAR_MATRICES``.
    """

    texts: Mapping[str, str]
    labels: Mapping[str, tuple[str, ...]]
    vectors: Mapping[str, Floats]
    matrices: Mapping[str, sp.csr_array]


def record_of(matrices: Matrices) -> Record:
    """Take matrices apart into the fields of a file.

    Parameters
    ----------
    matrices : Matrices
        What is written.

    Returns
    -------
    Record
        All fields.
    """
    texts = {"file_format": FILE_FORMAT, **{key: getattr(matrices, key) for key in TEXTS[1:]}}
    labels = {key: getattr(matrices, key) for key in LABELS}
    arrays = {key: getattr(matrices, key) for key in MATRICES}
    tangent = matrices.tangent
    if tangent is not None:
        labels |= {key: getattr(tangent, key.removeprefix("lin_")) for key in TANGENT_LABELS}
        arrays |= {key: getattr(tangent, key.removesuffix("_lin")) for key in TANGENT_MATRICES}
    vectors = {key: getattr(matrices, key) for key in VECTORS}
    if matrices.nonlinear is not None:
        parts = {f"nl_{key}": value for key, value in parts_of(matrices.nonlinear).items()}
        labels |= {key: parts[key] for key in NONLINEAR_LABELS}
        vectors |= {key: parts[key] for key in NONLINEAR_VECTORS}
        arrays |= {key: parts[key] for key in NONLINEAR_MATRICES}
    return Record(texts, labels, vectors, arrays)


def matrices_of(record: Record, where: str) -> Matrices:
    """Put the fields of a file together.

    Parameters
    ----------
    record : Record
        What was read.
    where : str
        The file, for messages.

    Returns
    -------
    Matrices
        The content.

    Raises
    ------
    ExportError
        If it is the file of something else, or fields are missing.
    DataError
        If the fields do not fit each other.
    """
    found = record.texts.get("file_format")
    if found != FILE_FORMAT:
        raise ExportError(
            where,
            expected=f"a file that says file_format = {FILE_FORMAT!r}",
            got="one without" if found is None else repr(found),
            fix="Give a file written by phblocks.export.write, of this version of the library.",
        )
    fields: dict[str, Any] = {**record.texts, **record.labels, **record.vectors, **record.matrices}
    optional = {*TANGENT_LABELS, *TANGENT_MATRICES}
    of_motion = {*NONLINEAR_LABELS, *NONLINEAR_VECTORS, *NONLINEAR_MATRICES}
    required = {*TEXTS, *LABELS, *VECTORS, *MATRICES}
    wanted = required.union(*(group for group in (optional, of_motion) if group & fields.keys()))
    if missing := sorted(wanted - fields.keys()):
        raise ExportError(where, expected="all fields", got=f"none named {', '.join(missing)}", fix="Export once more.")
    tangent = None
    if optional <= fields.keys():
        arrays = {key.removesuffix("_lin"): fields[key] for key in TANGENT_MATRICES}
        labels = {key.removeprefix("lin_"): fields[key] for key in TANGENT_LABELS}
        tangent = Tangent(**arrays, **labels)
    nonlinear = NonlinearModel(**{k[3:]: fields[k] for k in of_motion}) if of_motion <= fields.keys() else None
    return Matrices(**{key: fields[key] for key in required - {"file_format"}}, tangent=tangent, nonlinear=nonlinear)
