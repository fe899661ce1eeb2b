"""Writing and reading, in every format: identical content, and bad files refused."""

import io
import os
import pickle
import random
import shutil
import time
import warnings
from dataclasses import replace

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from phblocks.errors import ArgumentTypeError, ExportError
from phblocks.export import Matrices, read, suffixes, write

FORMATS = pytest.mark.parametrize("suffix", suffixes())
FREQUENCIES = 2j * np.pi * np.array([0.1, 10.0, 300.0, 2e3, 5e4])


def test_formats():
    assert suffixes() == (".mat", ".npz", ".mtx")


@FORMATS
@pytest.mark.parametrize("which", ["beam", "full", "closed"])
def test_comes_back_identical(request, tmp_path, identical, which, suffix):
    matrices = request.getfixturevalue(which)
    files = write(matrices, tmp_path / f"model{suffix}")
    assert sorted(files) == sorted(tmp_path.iterdir())
    identical(read(tmp_path / f"model{suffix}"), matrices)


@FORMATS
def test_without_states(tmp_path, identical, closed, suffix):
    none = Matrices(
        name="",
        about="",
        **{key: np.zeros((0, 0)) for key in "EJRQG"},
        **dict.fromkeys(("x0", "f0", "state_positions"), np.zeros(0)),
        **{f"{of}_{what}": () for of in ("state", "input", "output") for what in ("names", "units")},
    )
    write(none, tmp_path / f"model{suffix}")
    identical(read(tmp_path / f"model{suffix}"), none)


@FORMATS
def test_same_transfer_function(tmp_path, system, beam, response, suffix):
    write(beam, tmp_path / f"model{suffix}")
    m = read(tmp_path / f"model{suffix}")
    for s in FREQUENCIES:
        expected = response(system.E, system.J(), system.R, system.Q, system.G(), s)
        got = response(m.E, m.J, m.R, m.Q, m.G, s)
        assert np.abs(got - expected).max() <= 1e-12 * np.abs(expected).max()


@FORMATS
def test_replaces_and_takes_strings(tmp_path, identical, monkeypatch, beam, full, suffix):
    monkeypatch.chdir(tmp_path)
    write(full, f"a.b{suffix.upper()}")
    write(beam, f"a.b{suffix.upper()}")
    identical(read(f"a.b{suffix.upper()}"), beam)


@FORMATS
def test_large_stays_sparse(tmp_path, identical, suffix):
    n = 20_000
    rng = np.random.default_rng(1)
    band = sp.diags_array(rng.normal(size=(5, n)), offsets=[-2, -1, 0, 1, 2], shape=(n, n))
    large = Matrices(
        name="large",
        about="at rest",
        E=sp.eye_array(n),
        J=sp.triu(band, 1) - sp.triu(band, 1).T,
        R=sp.eye_array(n),
        Q=sp.eye_array(n),
        G=sp.csr_array(([1.0], ([n - 1], [0])), shape=(n, 1)),
        x0=np.zeros(n),
        f0=np.zeros(n),
        state_names=tuple(f"beam.V1[{i}]" for i in range(n)),
        state_units=("m/s",) * n,
        state_positions=np.linspace(0, 1, n),
        input_names=("tip",),
        input_units=("N",),
        output_names=("tip velocity",),
        output_units=("m/s",),
    )
    start = time.perf_counter()
    files = write(large, tmp_path / f"model{suffix}")
    got = read(tmp_path / f"model{suffix}")
    assert time.perf_counter() - start < 30.0  # some 3 s; a dense matrix of this size has 3.2 GB
    assert sum(file.stat().st_size for file in files) < 10e6
    identical(got, large)


@pytest.mark.parametrize("path", ["model.xls", "model", "model.mat.zip", ".mat", ""])
def test_unknown_suffix(tmp_path, monkeypatch, beam, path):
    monkeypatch.chdir(tmp_path)
    for act in (lambda: write(beam, path), lambda: read(path)):
        with pytest.raises(ExportError, match=r"a suffix out of \.mat, \.npz, \.mtx"):
            act()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("path", [None, 3, io.BytesIO()])
def test_not_a_path(beam, path):
    with pytest.raises(ArgumentTypeError, match="expected a path"):
        write(beam, path)
    with pytest.raises(ArgumentTypeError, match="expected a path"):
        read(path)


def test_not_matrices(tmp_path, system):
    with pytest.raises(ArgumentTypeError, match="expected Matrices"):
        write(system, tmp_path / "model.mat")


@FORMATS
def test_folder_does_not_exist(tmp_path, beam, suffix):
    path = tmp_path / "nowhere" / f"model{suffix}"
    with pytest.raises(ExportError, match="nowhere") as caught:
        write(beam, path)
    assert str(path) in str(caught.value)


@FORMATS
def test_cannot_be_written(tmp_path, beam, suffix):
    """A folder of that name is in the way (also for root, whom permissions do not stop)."""
    for name in (f"model{suffix}", "model.E.mtx"):
        (tmp_path / name).mkdir()
    path = tmp_path / f"model{suffix}"
    with pytest.raises(ExportError, match="expected a place to write to") as caught:
        write(beam, path)
    assert str(path) in str(caught.value)
    assert isinstance(caught.value.__cause__, OSError)


@FORMATS
def test_name_that_no_file_can_have(tmp_path, beam, suffix):
    with pytest.raises(ExportError, match="expected a place to write to"):
        write(beam, tmp_path / f"a\0b{suffix}")
    with pytest.raises(ExportError):
        read(tmp_path / f"a\0b{suffix}")


@FORMATS
def test_no_such_file(tmp_path, suffix):
    with pytest.raises(ExportError, match=r"expected a file that can be read.*model"):
        read(tmp_path / f"model{suffix}")


FOREIGN = {
    "empty": b"",
    "text": b"Not what it says.\n" * 20,
    "zeros": bytes(1000),
    "json list": b"[]",
    "json object": b"{}",
    "json of another kind": b'{"file_format": "phblocks matrices, version 1", "matrices": {"E": 3}}',
}


@FORMATS
@pytest.mark.parametrize("content", FOREIGN.values(), ids=FOREIGN)
def test_foreign_bytes(tmp_path, suffix, content):
    (tmp_path / f"model{suffix}").write_bytes(content)
    (tmp_path / f"model{suffix}.json").write_bytes(content)
    with pytest.raises(ExportError, match="model"):
        read(tmp_path / f"model{suffix}")


def test_sound_files_of_something_else(tmp_path):
    scipy.io.savemat(tmp_path / "other.mat", {"E": np.eye(3)})
    np.savez(tmp_path / "other.npz", E_data=np.eye(3))
    with pytest.raises(ExportError, match="file_format"):
        read(tmp_path / "other.mat")
    with pytest.raises(ExportError):
        read(tmp_path / "other.npz")
    np.savez(tmp_path / "other.npz", E=np.eye(3))
    with pytest.raises(ExportError, match="file_format"):
        read(tmp_path / "other.npz")
    with open(tmp_path / "array.npz", "wb") as file:
        np.save(file, np.eye(3))
    with pytest.raises(ExportError, match="a single array"):
        read(tmp_path / "array.npz")


@FORMATS
def test_damaged(tmp_path, identical, full, suffix):
    """Cut, altered, shifted at random: refused, or read right where it does not matter; never something else."""
    rng = random.Random(3)
    path = tmp_path / f"model{suffix}"
    files = write(full, path)
    sound = {file: file.read_bytes() for file in files}
    refused = 0
    for _ in range(150):
        file = rng.choice(files) if rng.random() < 0.7 else files[0]
        content = bytearray(sound[file])
        at = rng.randrange(len(content))
        match rng.randrange(4):
            case 0:
                del content[at:]
            case 1:
                content[at] ^= 1 << rng.randrange(8)
            case 2:
                content[at : at + 8] = rng.randbytes(8)
            case 3:
                del content[at : at + rng.randrange(1, 20)]
        file.write_bytes(content)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                got = read(path)
        except ExportError as error:
            refused += 1
            assert str(path) in str(error)
        else:
            if not file.name.endswith(".json"):  # what is changed in plain text may be plain text again
                identical(got, full)
        file.write_bytes(sound[file])
    assert refused > 100


class Bomb:
    """What unpickling it does shows."""

    def __reduce__(self):
        return os.mkdir, ("exploded",)


def test_nothing_is_executed(tmp_path, monkeypatch, beam):
    monkeypatch.chdir(tmp_path)
    write(beam, "model.npz")
    with np.load("model.npz") as archive:
        arrays = dict(archive)
    for key in ("file_format", "state_names", "E_data", "x0"):
        np.savez("bomb.npz", **(arrays | {key: np.array([Bomb()], dtype=object)}), allow_pickle=True)
        with pytest.raises(ExportError):
            read("bomb.npz")
    (tmp_path / "bomb.npz").write_bytes(pickle.dumps(Bomb()))
    with pytest.raises(ExportError):
        read("bomb.npz")
    assert not (tmp_path / "exploded").exists()


def test_other_version(tmp_path, beam):
    write(beam, tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz") as archive:
        arrays = dict(archive)
    np.savez(tmp_path / "model.npz", **(arrays | {"file_format": np.array("phblocks matrices, version 2")}))
    with pytest.raises(ExportError, match="version 2"):
        read(tmp_path / "model.npz")


@pytest.mark.parametrize("missing", ["f0", "state_units", "about", "N_data", "A_data", "lin_state_units", "E_row"])
def test_missing_field(tmp_path, full, missing):
    write(full, tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz") as archive:
        arrays = {key: value for key, value in archive.items() if key != missing}
    np.savez(tmp_path / "model.npz", **arrays)
    with pytest.raises(ExportError, match=missing.removesuffix("_data")):
        read(tmp_path / "model.npz")


def test_fields_that_do_not_fit(tmp_path, beam):
    write(beam, tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz") as archive:
        arrays = dict(archive)
    for change in ({"state_names": arrays["state_names"][1:]}, {"E_row": arrays["E_row"] + 10_000}, {"x0": np.ones(1)}):
        np.savez(tmp_path / "model.npz", **(arrays | change))
        with pytest.raises(ExportError, match="undamaged"):
            read(tmp_path / "model.npz")


def test_too_large_for_matlab(tmp_path, monkeypatch, beam):
    def savemat(*_args, **_kwargs):
        raise scipy.io.matlab.MatWriteError("Matrix too large to save with Matlab 5 format")

    monkeypatch.setattr(scipy.io, "savemat", savemat)
    with pytest.raises(ExportError, match=r"too large.*Export to \.npz instead"):
        write(beam, tmp_path / "model.mat")
    assert list(tmp_path.iterdir()) == []


def test_matrix_market_files_belong_together(tmp_path, beam):
    """A matrix of another export of the same shape is noticed, and a file elsewhere is not touched."""
    names, *_ = write(beam, tmp_path / "model.mtx")
    write(replace(beam, R=beam.R + beam.E), tmp_path / "other.mtx")
    sound = (tmp_path / "model.R.mtx").read_bytes()
    shutil.copy(tmp_path / "other.R.mtx", tmp_path / "model.R.mtx")
    with pytest.raises(ExportError, match=r"model\.R\.mtx is not as it was exported"):
        read(tmp_path / "model.mtx")
    (tmp_path / "model.R.mtx").unlink()
    with pytest.raises(ExportError, match=r"model\.R\.mtx"):
        read(tmp_path / "model.mtx")
    (tmp_path / "model.R.mtx").write_bytes(sound)
    names.write_text(names.read_text("utf-8").replace('"model.R.mtx"', '"../model.R.mtx"'), "utf-8")
    with pytest.raises(ExportError, match="not in the same folder"):
        read(tmp_path / "model.mtx")
