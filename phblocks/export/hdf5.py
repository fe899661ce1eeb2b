"""``.mat``, version 7.3: HDF5 as MATLAB writes it, for matrices that are too large for version 5.

A header of 512 bytes in front; texts are 16-bit characters, columns of cells references into the group ``#refs#``,
sparse matrices groups of ``data``, ``ir``, ``jc`` with the number of rows as an attribute. HDF5 counts dimensions the
other way round.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from phblocks.export.extras import require_extra
from phblocks.export.record import ALL_LABELS, ALL_MATRICES, ALL_VECTORS, TEXTS, Record

HEADER_SIZE = 512
#: Bytes 116 to 127: no subsystem, version 2.0, little-endian.
HEADER_END = bytes(8) + b"\x00\x02IM"
SIGNATURE = b"\x89HDF\r\n\x1a\n"
REFERENCES = "#refs#"


def write(record: Record, path: Path) -> tuple[Path, ...]:
    """Write one file.

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
    ExtraMissingError
        If h5py is not installed.
    """
    h5py = require_extra("h5py", "hdf5", f"file {path}: .mat of version 7.3")
    with h5py.File(path, "w", userblock_size=HEADER_SIZE, libver=("earliest", "v108")) as file:
        for key, text in record.texts.items():
            _text(file, key, text)
        cells = file.create_group(REFERENCES)
        for key, labels in record.labels.items():
            _cells(h5py, file, cells, key, labels)
        for key, vector in record.vectors.items():
            _classed(file, key, vector[None, :], "double")
        for key, matrix in record.matrices.items():
            _sparse(file, key, sp.csc_array(matrix))
    date = datetime.now(UTC).strftime("%a %b %d %H:%M:%S %Y")
    header = f"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: {date} HDF5 schema 1.00 ."
    with path.open("r+b") as raw:
        raw.write(header.encode("ascii").ljust(116) + HEADER_END)
    return (path,)


def is_hdf5(content: bytes) -> bool:
    """Tell a file of version 7.3 by its beginning.

    Parameters
    ----------
    content : bytes
        At least the first 520 bytes.

    Returns
    -------
    bool
        Whether it is one.
    """
    return content[124:128] == HEADER_END[8:] and content[HEADER_SIZE:].startswith(SIGNATURE)


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
        If a field is of another kind.
    ExtraMissingError
        If h5py is not installed.
    """
    h5py = require_extra("h5py", "hdf5", f"file {path}: .mat of version 7.3")
    with h5py.File(path, "r") as file:
        # links to other files are not followed
        found = {key: file[key] for key in file if isinstance(file.get(key, getlink=True), h5py.HardLink)}
        return Record(
            {key: _text_of(found[key]) for key in TEXTS if key in found},
            {key: _labels_of(file, found[key]) for key in ALL_LABELS if key in found},
            {key: _array_of(found[key]) for key in ALL_VECTORS if key in found},
            {key: _sparse_of(found[key]) for key in ALL_MATRICES if key in found},
        )


def _classed(group: Any, key: str, data: NDArray[Any], kind: str) -> Any:
    """Write an array with its MATLAB class; of an empty one, its dimensions."""
    empty = data.size == 0
    content = np.array(data.shape[::-1], dtype=np.uint64) if empty else data
    dataset = group.create_dataset(key, data=content)
    dataset.attrs["MATLAB_class"] = np.bytes_(kind)
    if empty:
        dataset.attrs["MATLAB_empty"] = np.uint8(1)
    return dataset


def _text(group: Any, key: str, text: str) -> Any:
    characters = np.frombuffer(text.encode("utf-16-le"), dtype="<u2")[:, None]
    data = characters if text else np.empty((0, 0), dtype="<u2")
    dataset = _classed(group, key, data, "char")
    dataset.attrs["MATLAB_int_decode"] = np.int32(2)
    return dataset


def _cells(h5py: Any, file: Any, cells: Any, key: str, labels: Sequence[str]) -> None:
    references = np.empty((1, len(labels)), dtype=h5py.ref_dtype)
    for i, label in enumerate(labels):
        references[0, i] = _text(cells, f"{key}_{i}", label).ref
    if labels:
        _classed(file, key, references, "cell")
    else:
        _classed(file, key, np.empty((1, 0)), "cell")


def _sparse(file: Any, key: str, matrix: sp.csc_array) -> None:
    group = file.create_group(key)
    group.attrs["MATLAB_class"] = np.bytes_("double")
    group.attrs["MATLAB_sparse"] = np.uint64(matrix.shape[0])
    if matrix.nnz:
        group.create_dataset("data", data=matrix.data, compression="gzip", shuffle=True)
        group.create_dataset("ir", data=matrix.indices.astype(np.uint64), compression="gzip", shuffle=True)
    group.create_dataset("jc", data=matrix.indptr.astype(np.uint64))


def _is_empty(item: Any) -> bool:
    return bool(item.attrs.get("MATLAB_empty", 0))


def _text_of(item: Any) -> str:
    if item.attrs.get("MATLAB_class") != b"char":
        raise ValueError(f"expected text, got {item!r}")
    return "" if _is_empty(item) else item[()].astype("<u2").tobytes().decode("utf-16-le")


def _labels_of(file: Any, item: Any) -> tuple[str, ...]:
    if item.attrs.get("MATLAB_class") != b"cell":
        raise ValueError(f"expected cells of text, got {item!r}")
    return () if _is_empty(item) else tuple(_text_of(file[reference]) for reference in np.ravel(item[()]))


def _array_of(item: Any) -> NDArray[Any]:
    return np.empty(0) if _is_empty(item) else np.ravel(item[()])


def _sparse_of(item: Any) -> sp.coo_array:
    rows, jc = int(item.attrs["MATLAB_sparse"]), item["jc"][()].astype(np.int64)
    data, ir = (item[name][()] if name in item else np.empty(0) for name in ("data", "ir"))
    matrix = sp.csc_array((data, ir.astype(np.int64), jc), shape=(rows, jc.size - 1))
    matrix.check_format(full_check=True)
    return matrix.tocoo()
