"""Maps from the points of a floor: PCD and PLY."""

import struct
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pianta
from pianta.errors import MapError
from pianta.io.point_clouds import unpack_lzf


def make_points(floor: float = 1.0) -> Any:
    """A room of 2 × 1 m with walls of 2.4 m on all sides, a ceiling, and a table; every 2 cm."""
    steps = 0.01 + np.arange(0, 2, 0.02)
    x, y = map(np.ravel, np.meshgrid(steps, steps[:50]))
    z = np.arange(0, 2.4, 0.02)
    planes = [np.column_stack([x, y, np.full(len(x), height)]) for height in (0.0, 2.4)]
    for across in (-0.03, 1.03):
        along, up = map(np.ravel, np.meshgrid(steps, z))
        planes.append(np.column_stack([along, np.full(len(along), across), up]))
    for across in (-0.03, 2.03):
        along, up = map(np.ravel, np.meshgrid(steps[:50], z))
        planes.append(np.column_stack([np.full(len(along), across), along, up]))
    table = (x > 0.5) & (x < 0.8) & (y > 0.3) & (y < 0.6)
    planes.append(np.column_stack([x[table], y[table], np.full(table.sum(), 0.75)]))
    points = np.concatenate(planes)
    points[:, 2] += floor
    return points


POINTS = make_points()


def pack_lzf(content: bytes) -> bytes:
    """LZF without references: runs of up to 32 bytes."""
    return b"".join(
        bytes([len(content[at : at + 32]) - 1]) + content[at : at + 32] for at in range(0, len(content), 32)
    )


def write_pcd(path: Path, points=POINTS, *, data="binary", count=None) -> Path:
    head = (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
        f"WIDTH {count or len(points)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count or len(points)}\nDATA {data}\n"
    )
    table = np.column_stack([points, np.zeros(len(points))]).astype("<f4")
    if data == "ascii":
        body = "".join(f"{x:.3f} {y:.3f} {z:.3f} 0\n" for x, y, z in points).encode()
    elif data == "binary":
        body = table.tobytes()
    else:
        content = table.T.tobytes()
        packed = pack_lzf(content)
        body = struct.pack("<II", len(packed), len(content)) + packed
    path.write_bytes(head.encode() + body)
    return path


def write_ply(path: Path, points=POINTS, *, encoding="binary_little_endian", dtype_name="float") -> Path:
    head = (
        f"ply\nformat {encoding} 1.0\ncomment made\nelement vertex {len(points)}\nproperty {dtype_name} x\n"
        f"property {dtype_name} y\nproperty {dtype_name} z\nproperty uchar red\nelement face 0\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    if encoding == "ascii":
        body = "".join(f"{x:.3f} {y:.3f} {z:.3f} 9\n" for x, y, z in points).encode()
    else:
        order = "<" if "little" in encoding else ">"
        number = "f4" if dtype_name == "float" else "f8"
        table = np.zeros(len(points), [*((name, order + number) for name in "xyz"), ("red", "u1")])
        for name, column in zip("xyz", points.T, strict=True):
            table[name] = column
        body = table.tobytes()
    path.write_bytes(head.encode() + body)
    return path


WRITERS: dict[str, Callable[[Path], Path]] = {
    "ascii.pcd": partial(write_pcd, data="ascii"),
    "binary.pcd": write_pcd,
    "packed.pcd": partial(write_pcd, data="binary_compressed"),
    "ascii.ply": partial(write_ply, encoding="ascii"),
    "little.ply": write_ply,
    "big.ply": partial(write_ply, encoding="binary_big_endian", dtype_name="double"),
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_room_is_free_between_its_walls(tmp_path, name):
    grid = pianta.read_map(WRITERS[name](tmp_path / name))
    # 2 × 1 m of 5 cm, with a cell of wall on each side; corners have no points
    expected = np.full((22, 42), 100)
    expected[1:-1, 1:-1] = 0
    expected[[0, 0, -1, -1], [0, -1, 0, -1]] = -1
    assert (grid.cells == expected).all()
    assert grid.origin == pytest.approx((-0.05, -0.05, 0))
    assert (grid.resolution, grid.source) == (0.05, name)


@pytest.mark.parametrize("floor", [-3.2, 0.0, 10.0])
def test_the_floor_can_be_at_any_height(tmp_path, floor):
    grid = pianta.read_map(write_pcd(tmp_path / "a.pcd", make_points(floor)), resolution=0.1)
    assert np.count_nonzero(grid.free) == 20 * 10


def test_a_few_points_below_are_not_the_floor(tmp_path):
    points = np.concatenate([POINTS, [[1.0, 0.5, -2.0], [1.0, 0.6, -1.0], [np.nan, 0, 0]]])
    assert np.count_nonzero(pianta.read_map(write_pcd(tmp_path / "a.pcd", points)).free) == 40 * 20


def test_many_points_are_read_in_blocks(tmp_path, monkeypatch):
    monkeypatch.setattr("pianta.io.point_clouds.BLOCK", 1000)
    grids = [pianta.read_map(WRITERS[name](tmp_path / name)) for name in ("binary.pcd", "ascii.ply")]
    assert [np.count_nonzero(grid.free) for grid in grids] == [800, 800]


class TestFaults:
    @pytest.mark.parametrize("name", WRITERS)
    def test_a_file_that_was_cut_off(self, tmp_path, name):
        path = WRITERS[name](tmp_path / name)
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
        with pytest.raises(MapError, match=r"ends after \d+ of \d+ points|unpack to|is damaged") as error:
            pianta.read_map(path)
        assert "\n" not in str(error.value)

    def test_a_count_that_no_file_can_hold(self, tmp_path):
        with pytest.raises(MapError, match="ends after"):
            pianta.read_map(write_pcd(tmp_path / "a.pcd", count=10**15))

    @pytest.mark.parametrize(
        ("text", "fault"),
        [
            ("no points at all", "no PCD or PLY file that pianta reads"),
            (
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
                "has no y and z of its points",
            ),
            ("ply\nformat ascii 1.0\nelement face 1\nelement vertex 1\n", "come after the element face"),
            ("ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int x\n", "its points have lists"),
            ("ply\nformat ascii 1.0\nelement vertex 1\n" + "comment\n" * 2000, "its header has no end"),
            ("ply\nformat text 1.0\n", "format is 'text', give ascii, binary_little_endian"),
        ],
    )
    def test_headers(self, tmp_path, text, fault):
        path = tmp_path / "a.ply"
        path.write_text(text)
        with pytest.raises(MapError, match=fault):
            pianta.read_map(path)

    @pytest.mark.parametrize(
        ("points", "fault"),
        [
            (POINTS[:5000], "has no walls above its floor, at z = 1.0"),
            (POINTS + 1e5, "has points farther than 10000 m from 0"),
            (POINTS * np.nan, "has no point with finite coordinates"),
        ],
    )
    def test_points_that_are_no_floor(self, tmp_path, points, fault):
        with pytest.raises(MapError, match=fault):
            pianta.read_map(write_pcd(tmp_path / "a.pcd", points))

    def test_a_map_above_the_limit(self, tmp_path):
        with pytest.raises(MapError, match="the limit is 100"):
            pianta.read_map(write_pcd(tmp_path / "a.pcd"), max_cells=100)


def test_lzf_with_references():
    # "abc", then 6 bytes from 3 back, which overlap what they make; then a long reference: 7 + 1 + 2 bytes from 1 back
    packed = bytes([2]) + b"abc" + bytes([(4 << 5), 2]) + bytes([7 << 5, 1, 0])
    assert unpack_lzf(packed, 19) == b"abcabcabc" + b"c" * 10


@pytest.mark.parametrize("packed", [bytes([2]) + b"ab", bytes([(1 << 5), 5]), bytes([7 << 5])])
def test_damaged_lzf(packed):
    with pytest.raises(MapError):
        unpack_lzf(packed, 3)


@pytest.mark.parametrize(
    ("header", "message"),
    [
        (
            "SIZE 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 1\nDATA ascii",
            "FIELDS, SIZE, TYPE and COUNT are not of one length",
        ),
        ("SIZE 4 4 4\nTYPE F F F\nCOUNT 1 0 1\nPOINTS 1\nDATA ascii", "field 'y' has 0 values, give 1 to 1000"),
        ("SIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA zip", "DATA is 'zip', give ascii, binary, binary_compressed"),
    ],
)
def test_wrong_headers_are_refused_with_the_reason(tmp_path, header, message):
    path = tmp_path / "scan.pcd"
    path.write_text(f"VERSION 0.7\nFIELDS x y z\n{header}\n0 0 0\n")
    with pytest.raises(MapError, match=message):
        pianta.read_map(path)


def test_compressed_points_of_another_size_are_not_unpacked(tmp_path):
    header = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 2\nDATA binary_compressed\n"
    # Half a gigabyte, of which nothing follows
    (tmp_path / "scan.pcd").write_bytes(header.encode() + struct.pack("<II", 0, 2**29))
    with pytest.raises(MapError, match=r"has 536870912 bytes of points and not 24, copy it again$"):
        pianta.read_map(tmp_path / "scan.pcd")
