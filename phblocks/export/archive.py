"""``.npz``: NumPy archive of plain arrays, for ``numpy.load``. A sparse matrix E is E_row, E_col, E_data, E_shape."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from phblocks.export.record import ALL_LABELS, ALL_MATRICES, ALL_VECTORS, TEXTS, Record


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
    """
    arrays: dict[str, Any] = {key: np.array(text, dtype=np.str_) for key, text in record.texts.items()}
    arrays |= {key: np.array(labels, dtype=np.str_) for key, labels in record.labels.items()}
    arrays |= record.vectors
    for key, matrix in record.matrices.items():
        entries = matrix.tocoo()
        arrays[f"{key}_row"] = entries.row.astype(np.int64)
        arrays[f"{key}_col"] = entries.col.astype(np.int64)
        arrays[f"{key}_data"] = entries.data
        arrays[f"{key}_shape"] = np.array(entries.shape, dtype=np.int64)
    content = BytesIO()
    np.savez_compressed(content, **arrays)
    path.write_bytes(content.getbuffer())
    return (path,)


def read(path: Path) -> Record:
    """Read a file; nothing in it is executed.

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
        If it is not a NumPy archive, or a field is of another kind.
    """
    content = BytesIO(path.read_bytes())
    archive = np.load(content, allow_pickle=False)
    if not isinstance(archive, np.lib.npyio.NpzFile):
        raise ValueError("a single array, not an archive")
    with archive:
        matrices = [key for key in ALL_MATRICES if f"{key}_data" in archive]
        return Record(
            {key: str(_texts(archive[key]).item()) for key in TEXTS if key in archive},
            {key: tuple(_texts(archive[key]).tolist()) for key in ALL_LABELS if key in archive},
            {key: archive[key] for key in ALL_VECTORS if key in archive},
            {key: _matrix(*(archive[f"{key}_{part}"] for part in ("row", "col", "data", "shape"))) for key in matrices},
        )


def _texts(value: NDArray[Any]) -> NDArray[np.str_]:
    if value.dtype.kind != "U":
        raise ValueError(f"expected text, got {value.dtype}")
    return value


def _matrix(row: NDArray[Any], col: NDArray[Any], data: NDArray[Any], shape: NDArray[Any]) -> sp.csr_array:
    rows, columns = shape.tolist()
    return sp.coo_array((data, (row, col)), shape=(rows, columns))
