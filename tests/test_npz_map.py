"""Maps as NumPy archives."""

import zipfile
from io import BytesIO

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.lib import format as npy

from pianta.errors import MapError, PiantaError
from pianta.gridmap import GridMap
from pianta.io.maps import read_map, read_npz_map, save_npz_map
from tests.mutation import mutated, refused_in_one_line
from tests.strategies import grids


@pytest.mark.slow
@given(grid=grids)
def test_saved_map_reads_back_exactly(tmp_path_factory, grid):
    path = tmp_path_factory.getbasetemp() / "map.npz"
    save_npz_map(grid, path)
    again = read_map(path)
    assert again.cells.dtype == np.int8
    assert again.cells.tolist() == grid.cells.tolist()
    assert (again.resolution, again.origin) == (grid.resolution, grid.origin)


def test_equal_maps_give_equal_bytes(tmp_path):
    for name in ("a.npz", "b.npz"):
        save_npz_map(GridMap(np.zeros((2, 3), np.int8), 0.05), tmp_path / name)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_archive_of_plain_numpy_is_read(tmp_path):
    np.savez(tmp_path / "a.npz", cells=[[-1, 0], [100, 42]], resolution=[1], origin=[1, 2, 0], other="ignored")
    grid = read_npz_map(tmp_path / "a.npz")
    assert grid.cells.tolist() == [[-1, 0], [100, 42]]
    assert (grid.resolution, grid.origin) == (1.0, (1.0, 2.0, 0.0))


def test_map_is_only_saved_as_npz(tmp_path):
    with pytest.raises(MapError, match=r"\.npz"):
        save_npz_map(GridMap(np.zeros((1, 1), np.int8), 1), tmp_path / "map.npy")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("members", "faults"),
    [
        ({}, ["cells", "resolution", "origin"]),
        (
            {"cells": np.zeros((2, 2)), "resolution": 0.0},
            ["origin", "cells.*float64", "resolution"],
        ),
        (
            {"cells": [[101]], "resolution": [1, 2], "origin": [0, 0]},
            ["resolution", "origin", "101"],
        ),
        ({"cells": [1], "resolution": np.nan, "origin": [0, 0, np.nan]}, [r"\(1,\)", "nan", "nan"]),
        (
            {"cells": "abc", "resolution": "0.05", "origin": [True] * 3},
            ["cells", "resolution", "origin"],
        ),
    ],
)
def test_all_faults_are_listed_at_once(tmp_path, members, faults):
    np.savez(tmp_path / "a.npz", **members)
    with pytest.raises(MapError, match=rf"^[^\n]*a\.npz[^\n]*{'.*; .*'.join(faults)}[^\n]*$"):
        read_npz_map(tmp_path / "a.npz")


def test_pickles_stay_unopened(tmp_path):
    np.savez(tmp_path / "a.npz", cells=np.array([{}], object), resolution=1, origin=[0, 0, 0])
    with pytest.raises(MapError, match="object"):
        read_npz_map(tmp_path / "a.npz")


def test_giant_is_refused_by_its_header(tmp_path):
    header = BytesIO()
    npy.write_array_header_1_0(header, {"descr": "|i1", "fortran_order": False, "shape": (30_000, 30_000)})
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("cells.npy", header.getvalue())
    with pytest.raises(MapError, match=r"900000000.*max_cells="):
        read_map(tmp_path / "a.npz")


def test_resolution_is_not_to_be_given(tmp_path):
    save_npz_map(GridMap(np.zeros((1, 1), np.int8), 1), tmp_path / "a.npz")
    with pytest.raises(MapError, match=r"\bresolution\b"):
        read_map(tmp_path / "a.npz", resolution=0.05)


@given(st.sampled_from([b"", b"PK\x03\x04", b"\x93NUMPY\x01\x00", b"PK\x05\x06"]), st.binary())
def test_only_our_errors_escape_from_random_bytes(tmp_path_factory, start, rest):
    path = tmp_path_factory.getbasetemp() / "random.npz"
    path.write_bytes(start + rest)
    with pytest.raises(PiantaError, match=r"^[^\n]+$"):
        read_npz_map(path)


@pytest.mark.slow
@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
@settings(max_examples=200)
@given(data=st.data())
def test_only_our_errors_escape_from_mutated_archives(tmp_path_factory, save, data):
    path = tmp_path_factory.getbasetemp() / "mutated.npz"
    save(path, cells=np.zeros((3, 4), np.int8), resolution=0.05, origin=[0.0, 0.0, 0.0])
    path.write_bytes(data.draw(mutated(path.read_bytes())))
    with refused_in_one_line():
        assert read_npz_map(path, max_cells=10_000).cells.size <= 10_000
