"""``.mat`` of version 7.3, read with a reader of such files and with h5py alone."""

import sys
from unittest.mock import patch

import numpy as np
import pytest

from phblocks.errors import ExportError, ExtraMissingError
from phblocks.export import matlab, read, write
from phblocks.export.record import ALL_LABELS, ALL_MATRICES, ALL_VECTORS, TEXTS, record_of

h5py = pytest.importorskip("h5py")


@pytest.fixture
def large(monkeypatch):
    """Every matrix with entries is too large for version 5."""
    monkeypatch.setattr(matlab, "LARGEST", 0)


@pytest.mark.parametrize("which", ["full", "closed", "beam"])
def test_comes_back_to_the_bit(request, tmp_path, large, identical, which):
    matrices = request.getfixturevalue(which)
    (file,) = write(matrices, tmp_path / "model.mat")
    identical(read(file), matrices)


def test_header_of_matlab(tmp_path, large, beam):
    (file,) = write(beam, tmp_path / "model.mat")
    content = file.read_bytes()
    assert content.startswith(b"MATLAB 7.3 MAT-file, Platform: ") and content[124:128] == b"\x00\x02IM"
    assert content[512:520] == b"\x89HDF\r\n\x1a\n"
    with h5py.File(file) as f:
        assert f.userblock_size == 512
        assert f["E"].attrs["MATLAB_class"] == b"double" and f["E"].attrs["MATLAB_sparse"] == beam.E.shape[0]
        assert f["E"]["jc"].shape == (beam.E.shape[1] + 1,) and f["E"]["ir"].dtype == np.uint64
        assert f["x0"].shape == (1, beam.x0.size) and f["state_names"].attrs["MATLAB_class"] == b"cell"
        assert f["name"].dtype == np.uint16 and f["name"].attrs["MATLAB_int_decode"] == 2
        first = f[f["state_names"][0, 0]]
        assert "".join(map(chr, first[:, 0])) == beam.state_names[0] and first.attrs["MATLAB_class"] == b"char"


@pytest.mark.filterwarnings("ignore")  # of the reader's own making
def test_mat73(tmp_path, large, system):
    """Another's reader of version 7.3 finds all matrices, names and units, the nonlinear model with them."""
    mat73 = pytest.importorskip("mat73")
    (file,) = system.export(tmp_path / "model.mat")
    m, expected = mat73.loadmat(str(file)), record_of(read(file))
    for key in ALL_MATRICES:
        found = m[key].toarray() if hasattr(m[key], "toarray") else m[key]
        np.testing.assert_array_equal(found, expected.matrices[key].toarray(), err_msg=key)
    for key in ALL_VECTORS:
        np.testing.assert_array_equal(np.ravel(m[key]) if m[key] is not None else [], expected.vectors[key])
    for key in ALL_LABELS:
        assert tuple(np.ravel(m[key]).tolist()) == expected.labels[key], key
    for key in TEXTS:
        assert m[key] == expected.texts[key], key


def test_large_is_what_does_not_fit(tmp_path, monkeypatch, beam):
    size = 16 * max(m.nnz for m in record_of(beam).matrices.values()) + 8 * 1000
    for limit, start in ((size, b"MATLAB 5.0"), (100, b"MATLAB 7.3")):
        monkeypatch.setattr(matlab, "LARGEST", limit)
        (file,) = write(beam, tmp_path / "model.mat")
        assert file.read_bytes().startswith(start)


def test_without_h5py(tmp_path, large, beam):
    (file,) = write(beam, tmp_path / "model.mat")
    with patch.dict(sys.modules, h5py=None):
        with pytest.raises(ExtraMissingError, match=r"phblocks\[hdf5\]"):
            write(beam, tmp_path / "other.mat")
        with pytest.raises(ExtraMissingError):
            read(file)


def test_damaged(tmp_path, large, beam):
    """Cut short, with bytes changed, and with a link to another file."""
    (file,) = write(beam, tmp_path / "model.mat")
    content = file.read_bytes()
    for end in (520, 600, len(content) // 3, len(content) - 100):
        file.write_bytes(content[:end])
        with pytest.raises(ExportError):
            read(file)
    file.write_bytes(content)
    with h5py.File(file, "a") as f:
        del f["E"]
        f["E"] = h5py.ExternalLink("other.mat", "E")
    with pytest.raises(ExportError, match="none named E"):
        read(file)
    file.write_bytes(content)
    with h5py.File(file, "a") as f:
        f["E"]["ir"][:] = 10**6
    with pytest.raises(ExportError, match="undamaged"):
        read(file)
