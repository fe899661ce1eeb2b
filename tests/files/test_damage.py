"""Files that are cut off, damaged or something else: a typed error each, and never a crash."""

import io
import os
import random
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import phblocks as ph
from phblocks.errors import ExportError, ResultFileError
from phblocks.export import read as read_matrices
from phblocks.export import suffixes, write
from phblocks.files.envelope import BLOCK, image
from phblocks.files.stored import chunk_of, folder_of

MANY = settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def finished(systems, tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("finished") / "run.h5"
    ph.simulate(systems["arm"], 0.1, 0.002, save=ph.Stream(path, chunk=20))
    return path.read_bytes()


@pytest.fixture(scope="module")
def partial(systems, tmp_path_factory, cut):
    path = tmp_path_factory.mktemp("partial") / "run.h5"
    cut(systems["arm"], ph.Stream(path, chunk=20), 0.08, t_end=0.1, dt=0.002, inputs={"tip": lambda t: (0.0, 0.0)})
    return path


def refused(path, system):
    """All ways to open a run say the same."""
    for act in (lambda: ph.read(path), lambda: ph.read(path, system), lambda: ph.resume(path, system)):
        with pytest.raises(ResultFileError) as caught:
            act()
        assert caught.value.code == "PH502" and path.name.removesuffix(".h5") in caught.value.where and caught.value.fix


@MANY
@given(at=st.floats(0.0, 1.0, exclude_max=True), mask=st.integers(1, 255))
def test_one_wrong_byte_anywhere(finished, systems, tmp_path, at, mask):
    damaged = bytearray(finished)
    damaged[int(at * len(damaged))] ^= mask
    (tmp_path / "run.h5").write_bytes(damaged)
    refused(tmp_path / "run.h5", systems["arm"])


@MANY
@given(at=st.integers(0, BLOCK - 1), mask=st.integers(1, 255))
def test_one_wrong_byte_in_the_block_with_the_sum(finished, systems, tmp_path, at, mask):
    damaged = bytearray(finished)
    damaged[at] ^= mask
    (tmp_path / "run.h5").write_bytes(damaged)
    refused(tmp_path / "run.h5", systems["arm"])


@MANY
@given(at=st.floats(0.0, 1.0, exclude_max=True), more=st.binary(max_size=20))
def test_cut_off_or_continued(finished, systems, tmp_path, at, more):
    (tmp_path / "run.h5").write_bytes(finished[: int(at * len(finished))] + more)
    refused(tmp_path / "run.h5", systems["arm"])
    if more:
        (tmp_path / "run.h5").write_bytes(finished + more)
        refused(tmp_path / "run.h5", systems["arm"])


@settings(MANY, max_examples=40)
@given(number=st.integers(0, 2), at=st.floats(0.0, 1.0, exclude_max=True), mask=st.integers(0, 255))
def test_damaged_chunks(partial, systems, tmp_path, number, at, mask):
    """A wrong byte, or (mask 0) cut off there."""
    shutil.rmtree(folder_of(tmp_path / "run.h5"), ignore_errors=True)
    shutil.copytree(folder_of(partial), folder_of(tmp_path / "run.h5"))
    chunk = chunk_of(tmp_path / "run.h5", number)
    data = bytearray(chunk.read_bytes())
    place = int(at * len(data))
    data[place] ^= mask
    chunk.write_bytes(data if mask else data[:place])
    refused(tmp_path / "run.h5", systems["arm"])


def foreign(finished) -> dict[str, bytes]:
    array, archive, other = io.BytesIO(), io.BytesIO(), io.BytesIO()
    np.save(array, np.arange(100.0))
    np.savez(archive, x=np.arange(100.0))
    with h5py.File(other, "w") as file:
        file["rows/t"] = np.arange(10.0)
    changed = bytearray(finished)
    changed[:BLOCK] = bytes(BLOCK)
    return {
        "empty": b"",
        "text": b"t,x\n0.0,1.0\n",
        "the first line only": finished[:24],
        "array": array.getvalue(),
        "archive": archive.getvalue(),
        "other hdf5": other.getvalue(),
        "hdf5 of ours without its block": bytes(changed),
        "hdf5 without a user block": finished[BLOCK:],
        "pickle": b"\x80\x04\x95cos\nsystem\n(S'echo executed'\ntR.",
        "noise": random.Random(1).randbytes(5000),
        # a right sum and other contents
        "sealed, empty": image({}),
        "sealed, other": image({"rows/t": np.arange(10.0), "index": np.array(0)}),
        "sealed, not JSON": image({"about": "{", "index": np.array(0), "totals": "", "status": "[1"}),
    }


def test_foreign_files(finished, systems, tmp_path):
    for name, data in foreign(finished).items():
        path = tmp_path / f"{name}.h5"
        path.write_bytes(data)
        refused(path, systems["arm"])


def test_no_file_and_folders(systems, tmp_path):
    refused(tmp_path / "nothing.h5", systems["arm"])
    refused(tmp_path / "no" / "folder.h5", systems["arm"])
    (tmp_path / "folder.h5").mkdir()
    refused(tmp_path / "folder.h5", systems["arm"])
    (tmp_path / "empty.h5.parts").mkdir()
    refused(tmp_path / "empty.h5", systems["arm"])


def test_a_chunk_that_is_missing_ends_the_run_there(partial, systems, tmp_path):
    """Like a kill before it; what comes after it is not used."""
    shutil.copytree(folder_of(partial), folder_of(tmp_path / "run.h5"))
    chunk_of(tmp_path / "run.h5", 1).unlink()
    run = ph.read(tmp_path / "run.h5")
    assert run.status.name == "interrupted" and run.status.time == 0.0
    assert ph.resume(tmp_path / "run.h5", systems["arm"], inputs={"tip": lambda t: (0.0, 0.0)}).status.ok


def test_files_that_go_away_while_they_are_read(partial, tmp_path):
    shutil.copytree(folder_of(partial), folder_of(tmp_path / "run.h5"))
    run = ph.read(tmp_path / "run.h5")
    shutil.rmtree(folder_of(tmp_path / "run.h5"))
    with pytest.raises(ResultFileError, match="read it once more"):
        _ = run.t


def test_without_h5py(systems, tmp_path):
    """Asked for in a fresh interpreter that cannot find it; and importing phblocks does not load it."""
    code = (
        "import sys, phblocks as ph; assert 'h5py' not in sys.modules; sys.modules['h5py'] = None\n"
        "from phblocks.errors import ExtraMissingError\n"
        "try: ph.read('run.h5')\n"
        "except ExtraMissingError as error: print(error)"
    )
    env = os.environ | {"PYTHONPATH": str(Path(ph.__file__).parents[1])}
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=env)
    assert "expected the package 'h5py'" in found.stdout and "phblocks[hdf5]" in found.stdout, found.stderr


@pytest.mark.parametrize("suffix", suffixes())
def test_exported_matrices(systems, tmp_path, suffix):
    """Their readers likewise: cut off anywhere, any wrong byte, other files. None of them unpickles."""
    write(systems["beam"].matrices(), tmp_path / f"model{suffix}")
    files = sorted(tmp_path.glob("model*"))
    draw = random.Random(3)
    for file in files:
        good = file.read_bytes()
        cases = [good[: draw.randrange(len(good))] for _ in range(15)]
        for _ in range(40):
            damaged = bytearray(good)
            damaged[draw.randrange(len(good))] ^= draw.randrange(1, 256)
            cases.append(bytes(damaged))
        cases += [b"", b"t,x\n", random.Random(1).randbytes(3000), foreign(good)["other hdf5"], foreign(good)["pickle"]]
        for data in cases:
            file.write_bytes(data)
            try:
                matrices = read_matrices(tmp_path / f"model{suffix}")
            except ExportError as error:
                assert error.fix
            else:  # a byte that means nothing, such as a date in the header
                assert (matrices.E != systems["beam"].matrices().E).nnz == 0
        file.write_bytes(good)
