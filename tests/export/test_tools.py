"""The files read with the tools they are for, without our reader."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from phblocks.export import write
from phblocks.export.record import FILE_FORMAT, LABELS, MATRICES, TANGENT_LABELS, TANGENT_MATRICES, TEXTS, VECTORS

OCTAVE = shutil.which("octave-cli")


def tangent_of(matrices, key):
    return getattr(matrices.tangent, key.removesuffix("_lin").removeprefix("lin_"))


def test_loadmat(tmp_path, beam):
    write(beam, tmp_path / "model.mat")
    m = scipy.io.loadmat(tmp_path / "model.mat")
    for key in MATRICES:
        assert sp.issparse(m[key]) and m[key].dtype == np.float64 and m[key].shape == getattr(beam, key).shape
        np.testing.assert_array_equal(m[key].toarray(), getattr(beam, key).toarray())
    for key in VECTORS:
        assert m[key].dtype == np.float64
        np.testing.assert_array_equal(m[key], getattr(beam, key)[:, None])
    for key in LABELS:
        labels = getattr(beam, key)
        assert m[key].dtype == object and m[key].shape == (len(labels), 1)
        assert tuple(json.loads(f'"{cell.item()}"') for cell in m[key].ravel()) == labels
    assert m["state_units"][0, 0].item() == "m/s"
    assert m["state_names"][0, 0].item() == "Tr\\u00e4ger.V1[0]"
    assert m["convention"].item() == beam.convention
    assert m["file_format"].item() == FILE_FORMAT


def test_loadmat_every_field(tmp_path, full):
    write(full, tmp_path / "model.mat")
    m = scipy.io.loadmat(tmp_path / "model.mat")
    assert {*TEXTS, *LABELS, *VECTORS, *MATRICES, *TANGENT_LABELS, *TANGENT_MATRICES} == {
        key for key in m if not key.startswith("__")
    }
    assert all(re.fullmatch("[A-Za-z][A-Za-z0-9_]{0,30}", key) for key in m if not key.startswith("__"))
    for key in TANGENT_MATRICES:
        np.testing.assert_array_equal(m[key].toarray(), tangent_of(full, key).toarray())
    for key in (*LABELS, *TANGENT_LABELS):
        assert all(cell.item().isascii() for cell in m[key].ravel() if cell.size)


def test_loadmat_no_inputs(tmp_path, closed):
    write(closed, tmp_path / "model.mat")
    m = scipy.io.loadmat(tmp_path / "model.mat")
    assert m["G"].shape == m["P"].shape == (5, 0)
    assert m["S"].shape == m["N"].shape == (0, 0)
    assert m["input_names"].shape == (0, 1) and m["input_names"].dtype == object


@pytest.mark.parametrize("which", ["full", "closed"])
def test_numpy_load(request, tmp_path, which):
    matrices = request.getfixturevalue(which)
    write(matrices, tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz", allow_pickle=False) as z:
        for key in (*MATRICES, *TANGENT_MATRICES):
            expected = tangent_of(matrices, key) if key in TANGENT_MATRICES else getattr(matrices, key)
            got = sp.coo_array((z[f"{key}_data"], (z[f"{key}_row"], z[f"{key}_col"])), shape=z[f"{key}_shape"])
            np.testing.assert_array_equal(got.toarray(), expected.toarray())
        for key in (*LABELS, *TANGENT_LABELS):
            expected = tangent_of(matrices, key) if key in TANGENT_LABELS else getattr(matrices, key)
            assert z[key].dtype.kind == "U" and tuple(z[key].tolist()) == expected
        for key in VECTORS:
            np.testing.assert_array_equal(z[key], getattr(matrices, key))
        assert z["about"].item() == matrices.about


@pytest.mark.parametrize("which", ["full", "closed", "beam"])
def test_mmread(request, tmp_path, which):
    matrices = request.getfixturevalue(which)
    names, *files = write(matrices, tmp_path / "model.mtx")
    assert names.name == "model.mtx.json"
    head = json.loads(names.read_text("utf-8"))
    listed = head.pop("matrices")
    assert {entry["file"] for entry in listed.values()} == {file.name for file in files}
    for key, entry in listed.items():
        expected = tangent_of(matrices, key) if key in TANGENT_MATRICES else getattr(matrices, key)
        got = scipy.io.mmread(tmp_path / f"model.{key}.mtx")
        assert got.shape == expected.shape == tuple(entry["shape"])
        assert got.nnz == expected.nnz == entry["entries"]
        np.testing.assert_array_equal(got.toarray(), expected.toarray())
        assert (tmp_path / entry["file"]).read_bytes().startswith(b"%%MatrixMarket matrix coordinate real general\n")
    assert head.keys() == {*TEXTS, *LABELS, *VECTORS} | ({*TANGENT_LABELS} if matrices.tangent else set())
    assert tuple(head["state_names"]) == matrices.state_names
    assert [np.nan if p is None else p for p in head["state_positions"]] == pytest.approx(
        matrices.state_positions.tolist(), abs=0, rel=0, nan_ok=True
    )


def octave(code: str, folder: Path) -> str:
    return subprocess.run(
        [OCTAVE, "--quiet", "--no-gui", "--norc", "--eval", code],
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
        encoding="utf-8",
    ).stdout


@pytest.mark.skipif(OCTAVE is None, reason="Octave is not installed")
def test_shapes_and_names_in_octave(tmp_path, full, closed):
    write(full, tmp_path / "full.mat")
    write(closed, tmp_path / "closed.mat")
    code = """
    m = load('full.mat');
    for k = 1:numel(m.state_names), disp(sprintf('%d,', jsondecode(['"' m.state_names{k} '"']))), end
    m = load('closed.mat');
    disp([size(m.G) size(m.S) size(m.input_names) issparse(m.G) iscell(m.input_names) isa(m.x0, 'double')])
    """
    *names, shapes = octave(code, tmp_path).splitlines()
    # Octave keeps text as UTF-8.
    assert [bytes(map(int, filter(None, name.split(",")))).decode() for name in names] == list(full.state_names)
    assert list(map(int, shapes.split())) == [5, 0, 0, 0, 0, 1, 1, 1, 1]
