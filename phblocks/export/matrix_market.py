"""``.mtx``: Matrix Market, one text file a matrix, and a JSON file with everything else.

``x.mtx`` stands for ``x.E.mtx``, ``x.J.mtx``, ... and ``x.mtx.json``, which lists them. All matrices are of the kind
"coordinate real general", which every reader of the format knows.
"""

from __future__ import annotations

import hashlib
import json
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from phblocks.export.record import ALL_LABELS, ALL_MATRICES, ALL_VECTORS, TEXTS, Record
from phblocks.triplets import Floats

#: Significant digits that bring every double back to the bit.
PRECISION = 17


def sidecar(path: Path) -> Path:
    """Return the file with the names.

    Parameters
    ----------
    path : pathlib.Path
        Such as ``x.mtx``.

    Returns
    -------
    pathlib.Path
        Such as ``x.mtx.json``.
    """
    return path.with_name(path.name + ".json")


def write(record: Record, path: Path) -> tuple[Path, ...]:
    """Write a file for each matrix, and last the one that lists them.

    Parameters
    ----------
    record : Record
        The content.
    path : pathlib.Path
        Such as ``x.mtx``; no file of this name is written.

    Returns
    -------
    tuple of pathlib.Path
        The files, that with the names first.
    """
    from scipy.io import mmwrite

    contents: dict[Path, bytes] = {}
    listed: dict[str, Any] = {}
    for key, matrix in record.matrices.items():
        content = BytesIO()
        mmwrite(content, matrix, comment=f"{key} of {path.stem}", precision=PRECISION, symmetry="general")
        file = path.with_name(f"{path.stem}.{key}{path.suffix}")
        contents[file] = content.getvalue()
        listed[key] = {
            "file": file.name,
            "shape": list(matrix.shape),
            "entries": matrix.nnz,
            "sha256": hashlib.sha256(contents[file]).hexdigest(),
        }
    head = {
        **record.texts,
        **record.labels,
        **{key: _numbers(vector) for key, vector in record.vectors.items()},
        "matrices": listed,
    }
    text = json.dumps(head, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    names = sidecar(path)
    names.unlink(missing_ok=True)  # so that a write cut short leaves no list of files that do not belong together
    for file, data in contents.items():
        file.write_bytes(data)
    names.write_text(text, encoding="utf-8", newline="\n")
    return (names, *contents)


def read(path: Path) -> Record:
    """Read the files.

    Parameters
    ----------
    path : pathlib.Path
        Such as ``x.mtx``, for ``x.mtx.json`` and the files listed there.

    Returns
    -------
    Record
        Their content, not yet checked.

    Raises
    ------
    ValueError
        If a file is not what the list says, or a field is of another kind.
    """
    head = json.loads(sidecar(path).read_bytes())
    if not isinstance(head, dict) or not isinstance(head.get("matrices", {}), dict):
        raise ValueError(f"{sidecar(path).name} is not a list of matrices")
    listed = head.get("matrices", {})
    return Record(
        {key: head[key] for key in TEXTS if key in head},
        {key: head[key] for key in ALL_LABELS if key in head},
        {key: _vector(head[key]) for key in ALL_VECTORS if key in head},
        {key: _matrix(path, listed[key]) for key in ALL_MATRICES if key in listed},
    )


def _matrix(path: Path, listed: dict[str, Any]) -> sp.coo_array:
    from scipy.io import mmread

    name = listed["file"]
    if Path(name).name != name:
        raise ValueError(f"{name!r} is not in the same folder")
    content = path.with_name(name).read_bytes()
    # Before mmread sees it, which may crash the interpreter on damaged text.
    if hashlib.sha256(content).hexdigest() != listed["sha256"]:
        raise ValueError(f"{name} is not as it was exported (another SHA-256 sum)")
    return sp.coo_array(mmread(BytesIO(content)))


def _numbers(vector: Floats) -> list[float | None]:
    """JSON has no NaN."""
    return [None if number != number else number for number in vector.tolist()]


def _vector(numbers: list[float | None]) -> Floats:
    return np.array([np.nan if number is None else number for number in numbers], dtype=np.float64)
