"""``.mat``: MATLAB version 5, for ``load`` in MATLAB and Octave and ``scipy.io.loadmat``.

Text outside ASCII is written with the escapes of JSON strings, backslash and double quote included: tools differ in how
they count the characters of other encodings, and cut or refuse them.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from phblocks.errors import ExportError
from phblocks.export import hdf5
from phblocks.export.record import ALL_LABELS, ALL_MATRICES, ALL_VECTORS, TEXTS, Record

HEADER_SIZE = 128
HEADER_END = b"\x00\x01IM"  # version 5, little-endian
MATRIX, COMPRESSED = 14, 15  # kinds of elements
#: Bytes, or rows, of a matrix above which the file is of version 7.3: MATLAB's own limit for version 5.
LARGEST = 2**31 - 1


def write(record: Record, path: Path) -> tuple[Path, ...]:
    """Write one file: sparse matrices, columns of doubles, columns of cells of text.

    Of version 5, and of version 7.3 (HDF5) if a matrix is too large for that.

    Parameters
    ----------
    record : Record
        The content.
    path : pathlib.Path
        Where to.

    Returns
    -------
    tuple of pathlib.Path
        The file.

    Raises
    ------
    ExportError
        If a matrix is too large for the format.
    ExtraMissingError
        If a matrix is too large for version 5 and h5py is not installed.
    """
    if any(max(16 * m.nnz + 8 * m.shape[1], m.shape[0]) > LARGEST for m in record.matrices.values()):
        return hdf5.write(record, path)
    from scipy.io import savemat
    from scipy.io.matlab import MatWriteError

    variables: dict[str, Any] = {key: _escaped(text) for key, text in record.texts.items()}
    variables |= {key: _cells(labels) for key, labels in record.labels.items()}
    variables |= {key: vector[:, None] for key, vector in record.vectors.items()}
    variables |= record.matrices
    content = BytesIO()
    try:
        savemat(content, variables, format="5", do_compression=True)
    except (MatWriteError, OverflowError) as error:
        raise ExportError(
            f"file {path}", expected="less than 4 GB a matrix", got=str(error), fix="Export to .npz instead."
        ) from error
    path.write_bytes(content.getbuffer())
    return (path,)


def read(path: Path) -> Record:
    """Read a file.

    Parameters
    ----------
    path : pathlib.Path
        The file.

    Returns
    -------
    Record
        Its content, not yet checked.

    Raises
    ------
    ValueError
        If it is not a MATLAB 5 file, or a field is of another kind.
    """
    from scipy.io import loadmat

    content = path.read_bytes()
    if hdf5.is_hdf5(content):
        return hdf5.read(path)
    _check_sums(content)
    variables = loadmat(BytesIO(content))
    return Record(
        {key: _text(variables[key]) for key in TEXTS if key in variables},
        {key: _label_column(variables[key]) for key in ALL_LABELS if key in variables},
        {key: np.reshape(variables[key], -1) for key in ALL_VECTORS if key in variables},
        {key: _checked(variables[key]) for key in ALL_MATRICES if key in variables},
    )


def _check_sums(content: bytes) -> None:
    """Go through the elements and their check sums first: loadmat may crash the interpreter on damaged bytes."""
    if content[HEADER_SIZE - len(HEADER_END) : HEADER_SIZE] != HEADER_END:
        raise ValueError("not a MATLAB 5 file (little-endian)")
    start = HEADER_SIZE
    while start < len(content):
        kind, size = struct.unpack_from("<II", content, start)
        element = content[start + 8 : start + 8 + size]
        if kind not in (MATRIX, COMPRESSED) or len(element) < size:
            raise ValueError(f"the element at byte {start} is damaged or cut off")
        if kind == COMPRESSED:
            zlib.decompress(element)
        start += 8 + size


def _escaped(text: str) -> str:
    return json.dumps(text)[1:-1]


def _cells(labels: Sequence[str]) -> NDArray[np.object_]:
    """Make a column of cells; also an empty one keeps its shape, (0, 1)."""
    column = np.empty((len(labels), 1), dtype=object)
    column[:, 0] = [_escaped(label) for label in labels]
    return column


def _text(value: Any) -> str:
    if not isinstance(value, np.ndarray) or value.dtype.kind != "U" or value.size > 1:
        raise ValueError(f"expected text, got {value!r}")
    return str(json.loads(f'"{value.item()}"', strict=False)) if value.size else ""


def _label_column(value: Any) -> tuple[str, ...]:
    if not isinstance(value, np.ndarray) or value.dtype != object:
        raise ValueError(f"expected cells of text, got {value!r}")
    return tuple(_text(cell) for cell in value.ravel())


def _checked(value: Any) -> Any:
    """Check the indices, which scipy trusts, before anything follows them."""
    if not sp.issparse(value):
        return value
    if value.format == "csc":  # depends on the version of scipy
        value.check_format(full_check=True)
    entries = value.tocoo()
    return sp.coo_array((entries.data, (entries.row, entries.col)), shape=entries.shape)
