"""ROS maps: every cell as in Nav2, and the files that are refused."""

import warnings
from math import pi
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from pianta.errors import MapError, MapWarning, PiantaError
from pianta.gridmap import GridMap
from pianta.io.maps import read_map
from pianta.io.ros_maps import read_ros_map, save_ros_map
from tests.mutation import mutated, refused_in_one_line
from tests.strategies import finite, grids

KEYS = {
    "image": "map.png",
    "resolution": "0.05",
    "origin": "[-1.5, 2, 0.0]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}
EVERY_GREY = np.arange(256, dtype=np.uint8).reshape(16, 16)


def write_map(folder: Path, pixels=EVERY_GREY, **keys: object) -> Path:
    """map.yaml with KEYS and other keys, without those whose value is None, and map.png."""
    Image.fromarray(np.asarray(pixels, np.uint8)).save(folder / "map.png")
    lines = [f"{key}: {value}\n" for key, value in (KEYS | keys).items() if value is not None]
    (folder / "map.yaml").write_text("".join(lines), encoding="utf-8")
    return folder / "map.yaml"


def cell_by_the_rules(grey: int, mode: str, *, negate: bool) -> int:
    """The rules of Nav2 in integers, for the thresholds 0.65 and 0.196; occupancy in 1/255000."""
    if mode == "raw":
        return grey if grey <= 100 else -1
    occupancy = 1000 * (grey if negate else 255 - grey)
    occupied, free = 650 * 255, 196 * 255
    if occupancy <= free:
        return 0
    if occupancy >= occupied:
        return 100
    return (200 * (occupancy - free) + occupied - free) // (2 * (occupied - free)) if mode == "scale" else -1


@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
@pytest.mark.parametrize("negate", ["0", "1", "false", "true", "False", "no", "yes"])
def test_every_grey_in_every_mode(tmp_path, mode, negate):
    grid = read_map(write_map(tmp_path, mode=mode, negate=negate))
    negated = negate in ("1", "true", "yes")
    assert grid.cells.ravel().tolist() == [cell_by_the_rules(grey, mode, negate=negated) for grey in range(256)]


@pytest.mark.parametrize(
    ("mode", "negate", "cells"),
    [
        ("trinary", 0, {0: 100, 89: 100, 90: -1, 128: -1, 205: -1, 206: 0, 254: 0, 255: 0}),
        ("trinary", 1, {0: 0, 49: 0, 50: -1, 165: -1, 166: 100, 255: 100}),
        ("scale", 0, {0: 100, 89: 100, 90: 99, 147: 50, 148: 49, 204: 1, 205: 0, 206: 0}),
        ("scale", 1, {49: 0, 50: 0, 51: 1, 107: 49, 108: 50, 165: 99, 166: 100}),
        ("raw", 0, {0: 0, 1: 1, 100: 100, 101: -1, 205: -1, 255: -1}),
        ("raw", 1, {0: 0, 1: 1, 100: 100, 101: -1, 205: -1, 255: -1}),
    ],
)
def test_greys_at_the_borders(tmp_path, mode, negate, cells):
    grid = read_ros_map(write_map(tmp_path, mode=mode, negate=negate))
    assert {grey: int(grid.cells.flat[grey]) for grey in cells} == cells


def test_mode_is_trinary_by_default_and_in_any_case(tmp_path):
    assert set(np.unique(read_ros_map(write_map(tmp_path)).cells)) == {-1, 0, 100}
    assert read_ros_map(write_map(tmp_path, mode="Raw")).cells.flat[42] == 42


def test_thresholds_are_compared_in_float32(tmp_path):
    # Grey 153 has occupancy 0.4 exactly; in float32 it is 1 - 0.6 = 0.39999998 and stays below 0.4 = 0.40000001.
    assert read_ros_map(write_map(tmp_path, [[153, 152]], occupied_thresh=0.4)).cells.tolist() == [[-1, 100]]


def test_free_wins_where_thresholds_overlap(tmp_path):
    for mode in ("trinary", "scale"):
        path = write_map(tmp_path, [[255, 128, 0]], mode=mode, free_thresh=0.6, occupied_thresh=0.3)
        assert read_ros_map(path).cells.tolist() == [[0, 0, 100]]


@pytest.mark.parametrize(("mode", "cells"), [("trinary", [0, -1, -1]), ("scale", [0, -1, -1]), ("raw", [-1, -1, 0])])
def test_alpha_below_full_is_unknown_except_in_raw_mode(tmp_path, mode, cells):
    pixels = [[[254, 254, 254, 255], [254, 254, 254, 254], [0, 0, 0, 0]]]
    assert read_ros_map(write_map(tmp_path, pixels, mode=mode)).cells.tolist() == [cells]


def test_row_zero_stays_on_top_and_yaw_turns_the_frame(tmp_path):
    grid = read_ros_map(write_map(tmp_path, [[0, 254, 254], [254] * 3], resolution=0.5, origin=f"[10, 20, {pi / 2!r}]"))
    assert grid.cells.tolist() == [[100, 0, 0], [0, 0, 0]]
    assert grid.origin == (10.0, 20.0, pi / 2)
    x, y = grid.pixel_to_map([2, 2, 0], [0, 3, 0])
    assert x == pytest.approx([10, 10, 9])
    assert y == pytest.approx([20, 21.5, 20])


def test_image_is_relative_to_the_yaml_or_absolute(tmp_path, monkeypatch):
    folder, elsewhere = tmp_path / "maps", tmp_path / "elsewhere"
    for path in (folder, folder / "images", elsewhere):
        path.mkdir()
    Image.new("L", (1, 1), 0).save(folder / "images" / "occupied.png")
    monkeypatch.chdir(elsewhere)
    assert read_ros_map(write_map(folder, image="images/occupied.png")).cells.tolist() == [[100]]
    assert read_ros_map("../maps/map.yaml").cells.tolist() == [[100]]
    assert read_ros_map(write_map(elsewhere, image=folder / "images" / "occupied.png")).cells.tolist() == [[100]]


@pytest.mark.parametrize("image", ["map.png", "map.pgm", "map.bmp"])
def test_image_may_be_png_pgm_or_bmp(tmp_path, image):
    path = write_map(tmp_path, image=image)
    Image.fromarray(EVERY_GREY).save(tmp_path / image)
    assert read_ros_map(path).cells.tolist() == read_ros_map(write_map(tmp_path)).cells.tolist()


@pytest.mark.parametrize(
    "text",
    [
        """free_thresh: 196e-3\r\nnegate: false\r\nimage: map.png\r\norigin: [-10, -10, 0]\r
occupied_thresh: .65\r\nresolution: 5e-2\r\n""",
        """image:\tmap.png\n\t# a comment\nresolution: '0.05'\norigin:\n- -10\n- -10.0\n- 0
negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\nunknown: {a: [1, 2]}\n""",
        """{image: map.png, resolution: 0.05, resolution: 7, origin: [-10, -1e1, 0], negate: 0,
occupied_thresh: 0.65, free_thresh: 0.196}\n---\nsecond: document\n""",
    ],
    ids=["numbers-and-crlf", "tabs-quotes-unknown-keys", "first-of-two-keys-and-documents"],
)
def test_yaml_is_read_as_yaml_cpp_reads_it(tmp_path, text):
    write_map(tmp_path)
    (tmp_path / "map.yaml").write_bytes(text.encode())
    grid = read_ros_map(tmp_path / "map.yaml")
    assert (grid.resolution, grid.origin) == (0.05, (-10.0, -10.0, 0.0))


def saved_with(grey: int) -> list[list[int]]:
    """Two rows of a map with this grey for unknown."""
    return [[grey] * 6, [0, 254, 254, 254, 254, grey]]


SAVED = saved_with(205)
# A grey inside a map with white edges.
GREY_INSIDE = [[254] * 6, [254, 204, 204, 204, 204, 254], [254, 0, 204, 204, 0, 254], [254] * 6]


@pytest.mark.parametrize("mode", ["trinary", "scale"])
@pytest.mark.parametrize("free_thresh", [0.25, 50 / 255])
def test_saved_unknown_stays_unknown_with_one_warning(tmp_path, mode, free_thresh):
    path = write_map(tmp_path, SAVED, mode=mode, free_thresh=free_thresh)
    expected = rf"^[^\n]*map\.yaml[^\n]*{free_thresh} [^\n]*205[^\n]*58%[^\n]*trust_thresholds=[^\n]*$"
    with pytest.warns(MapWarning, match=expected) as caught:
        grid = read_map(path)
    assert len(caught) == 1
    assert grid.cells.tolist() == [[-1] * 6, [100, 0, 0, 0, 0, -1]]


def test_trusted_thresholds_are_used_as_given(tmp_path):
    path = write_map(tmp_path, SAVED, free_thresh=0.25)
    assert read_map(path, trust_thresholds=True).cells.tolist() == [[0] * 6, [100, 0, 0, 0, 0, 0]]


def test_saved_unknown_of_an_inverted_image_stays_unknown(tmp_path):
    path = write_map(tmp_path, 255 - np.array(SAVED), free_thresh=0.25, negate=1)
    with pytest.warns(MapWarning, match="50"):
        assert read_ros_map(path).cells.tolist() == [[-1] * 6, [100, 0, 0, 0, 0, -1]]


@pytest.mark.parametrize(
    ("pixels", "keys"),
    [
        (SAVED, {}),
        (SAVED, {"free_thresh": 0.25, "mode": "raw"}),
        (SAVED, {"free_thresh": 0.25, "negate": 1}),
        ([[205] * 6, [0] * 6], {"free_thresh": 0.25}),
        ([[205] * 100, [0] * 99 + [254]], {"free_thresh": 0.25}),
        (GREY_INSIDE, {"free_thresh": 0.25}),
        ([[254] * 199, [0] * 198 + [205]], {"free_thresh": 0.25}),
        (saved_with(206), {"free_thresh": 0.1}),
        (saved_with(204), {}),
        (saved_with(240), {}),
        (saved_with(100)[:1] * 3, {"occupied_thresh": 0.6}),
    ],
    ids=[
        "threshold",
        "raw",
        "negate",
        "no-white-floor",
        "specks-of-white",
        "other-grey-inside",
        "little-of-it",
        "other-grey-unknown",
        "darker-grey-unknown",
        "nearly-white",
        "grey-walls-alone",
    ],
)
def test_maps_without_saved_unknown_are_read_by_their_thresholds(tmp_path, pixels, keys):
    path = write_map(tmp_path, pixels, **keys)
    literal = read_ros_map(path, trust_thresholds=True)
    assert read_ros_map(path).cells.tolist() == literal.cells.tolist()


@pytest.mark.parametrize(
    ("grey", "keys", "state"),
    [
        (206, {"free_thresh": 0.196}, "free_thresh 0.196 makes grey 206 free"),
        (204, {"free_thresh": 0.25}, "free_thresh 0.25 makes grey 204 free"),
        (128, {"free_thresh": 0.5, "occupied_thresh": 0.65}, "free_thresh 0.5 makes grey 128 free"),
        (128, {"free_thresh": 0.1, "occupied_thresh": 0.45}, "occupied_thresh 0.45 makes grey 128 occupied"),
    ],
)
def test_another_grey_that_fills_the_edge_is_unknown(tmp_path, grey, keys, state):
    """Both rows are the edge of this map, of which the grey has 7 cells of 12."""
    path = write_map(tmp_path, saved_with(grey), **keys)
    with pytest.warns(MapWarning, match=state) as caught:
        grid = read_map(path)
    assert len(caught) == 1
    assert "58%" in str(caught[0].message)
    assert grid.cells.tolist() == [[-1] * 6, [100, 0, 0, 0, 0, -1]]
    assert -1 not in read_map(path, trust_thresholds=True).cells


def test_another_grey_of_an_inverted_image_is_unknown(tmp_path):
    path = write_map(tmp_path, 255 - np.array(saved_with(206)), free_thresh=0.196, negate=1)
    with pytest.warns(MapWarning, match="makes grey 49 free"):
        assert read_ros_map(path).cells.tolist() == [[-1] * 6, [100, 0, 0, 0, 0, -1]]


@pytest.mark.parametrize("folder", ["/home/robot/maps/", "C:\\maps\\", "\\\\server\\maps\\"])
def test_an_image_of_another_machine_is_searched_beside_the_map(tmp_path, folder):
    path = write_map(tmp_path, SAVED)
    plain = read_map(path).cells
    name = next(file.name for file in tmp_path.iterdir() if file != path)
    keys = yaml.safe_load(path.read_text()) | {"image": f"{folder}{name}"}
    path.write_text(yaml.safe_dump(keys))
    with pytest.warns(MapWarning, match=f"'{name}' beside the map is read instead") as caught:
        assert read_map(path).cells.tolist() == plain.tolist()
    assert len(caught) == 1


def test_an_image_of_another_machine_that_is_nowhere_is_an_error(tmp_path):
    path = write_map(tmp_path, SAVED)
    path.write_text(yaml.safe_dump(yaml.safe_load(path.read_text()) | {"image": "/home/robot/none.pgm"}))
    with pytest.raises(MapError, match=r"its image '/home/robot/none\.pgm' does not exist"):
        read_map(path)


def test_all_faults_of_a_yaml_are_listed_at_once(tmp_path):
    path = write_map(
        tmp_path,
        image="''",
        resolution=0,
        origin="[0, .nan]",
        negate=2,
        mode="foo",
        occupied_thresh=None,
        free_thresh=65,
    )
    with pytest.raises(MapError) as caught:
        read_ros_map(path)
    start, _, faults = str(caught.value).partition(": ")
    assert start == f"map '{path}'"
    values = {
        "image": "''",
        "resolution": "'0'",
        "origin": "['0', '.nan']",
        "occupied_thresh": "missing",
        "free_thresh": "'65'",
        "negate": "'2'",
        "mode": "'foo'",
    }
    assert [fault.split()[0] for fault in faults.split("; ")] == [*values]
    assert all(value in fault for value, fault in zip(values.values(), faults.split("; "), strict=True))


@pytest.mark.parametrize("key", KEYS)
def test_every_key_is_needed(tmp_path, key):
    with pytest.raises(MapError, match=f"map.yaml': {key} [^;]*$"):
        read_ros_map(write_map(tmp_path, **{key: None}))


@pytest.mark.parametrize("number", [".nan", "nan", ".inf", "-inf", "x", "''", "[1]", "{a: 1}", "~"])
def test_every_number_must_be_finite(tmp_path, number):
    keys = dict.fromkeys(["resolution", "occupied_thresh", "free_thresh"], number)
    expected = "resolution.*origin.*occupied_thresh.*free_thresh"
    with pytest.raises(MapError, match=expected):
        read_ros_map(write_map(tmp_path, origin=f"[0, {number}, 0]", **keys))


@pytest.mark.parametrize("origin", ["[0, 0]", "[0, 0, 0, 0]", "0", "'0 0 0'", "{x: 0, y: 0, yaw: 0}"])
def test_origin_has_three_numbers(tmp_path, origin):
    with pytest.raises(MapError, match=r"origin.*three"):
        read_ros_map(write_map(tmp_path, origin=origin))


@pytest.mark.parametrize(
    ("image", "fault"),
    [
        ("gone.png", r"gone\.png"),
        (".", "folder"),
        ("https://example.org/map.png", r"https://example\.org/map\.png"),
        ("map.yaml", r"\bimage\b"),
        ("empty.png", "empty"),
        ('"two\\nlines"', "exist"),
        ("/dev/zero", "device"),
    ],
)
def test_unusable_image_is_refused_in_one_line(tmp_path, image, fault):
    (tmp_path / "empty.png").touch()
    with pytest.raises(MapError, match=rf"^[^\n]*{fault}[^\n]*$"):
        read_ros_map(write_map(tmp_path, image=image))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (b"", "empty"),
        (b"# nothing\n", "keys"),
        (b"- 1\n", "keys"),
        (b"map\n", "keys"),
        (b"image: [\n", "YAML"),
        (bytes(range(256)), "YAML"),
        (b"a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n", "aliases"),
        (b"[" * 40_000, "YAML"),
        (b"a: " + b"x" * 50_000, "50000"),
        (b"image: !!python/object/apply:os.getcwd []\n", "image"),
    ],
)
def test_other_yaml_files_are_refused_in_one_line(tmp_path, content, fault):
    (tmp_path / "map.yaml").write_bytes(content)
    with pytest.raises(MapError, match=rf"^[^\n]*map.yaml'[^\n]*{fault}[^\n]*$"):
        read_map(tmp_path / "map.yaml")


def test_giant_image_is_refused(tmp_path):
    path = write_map(tmp_path, image="giant.pgm")
    (tmp_path / "giant.pgm").write_bytes(b"P5 30000 30000 255\n")
    with pytest.raises(MapError, match=r"900000000.*max_cells="):
        read_map(path)


def test_limit_of_cells_can_be_set(tmp_path):
    path = write_map(tmp_path)
    assert read_map(path, max_cells=256).shape == (16, 16)
    with pytest.raises(MapError, match="256"):
        read_map(path, max_cells=255)


def test_a_resolution_for_a_yaml_map_is_refused(tmp_path):
    path = write_map(tmp_path)
    with pytest.raises(MapError, match=r"\bresolution\b"):
        read_map(path, resolution=0.05)
    with pytest.raises(MapError, match=r"\bresolution\b"):
        read_map(path, origin=(0, 0, 0))


WAYS = [("trinary", "png"), ("trinary", "pgm"), ("trinary", "bmp"), ("scale", "png"), ("raw", "png"), ("raw", "pgm")]


@pytest.mark.slow
@pytest.mark.parametrize(("mode", "image_format"), WAYS)
@settings(max_examples=50)
@given(grid=grids)
def test_saved_map_reads_back(tmp_path_factory, mode, image_format, grid):
    path = tmp_path_factory.getbasetemp() / "saved.yaml"
    save_ros_map(grid, path, mode=mode, image_format=image_format)
    again = read_ros_map(path)
    assert (again.resolution, again.origin) == (grid.resolution, grid.origin)
    expected_cells = np.where(grid.free, 0, np.where(grid.occupied, 100, -1)) if mode == "trinary" else grid.cells
    assert again.cells.tolist() == expected_cells.tolist()


def test_trinary_map_is_written_as_nav2_writes_it(tmp_path):
    grid = GridMap(np.array([[-1, 0, 25, 26, 64, 65, 100]], np.int8), 0.0254, (-1.23456789, 2.0, 0.1))
    save_ros_map(grid, tmp_path / "my map.yaml", image_format="pgm")
    assert (tmp_path / "my map.pgm").read_bytes().endswith(bytes([205, 254, 254, 205, 205, 0, 0]))
    assert yaml.safe_load((tmp_path / "my map.yaml").read_text()) == {
        "image": "my map.pgm",
        "mode": "trinary",
        "resolution": 0.0254,
        "origin": [-1.23456789, 2.0, 0.1],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }


@pytest.mark.parametrize(
    ("name", "mode", "image_format", "fault"),
    [
        ("map.png", "foo", "gif", r"map\.png.*foo.*gif"),
        ("map.yaml", "scale", "pgm", "transparency"),
        ("map.yaml", "scale", "bmp", "transparency"),
    ],
)
def test_faulty_options_of_saving_are_listed_at_once(tmp_path, name, mode, image_format, fault):
    grid = GridMap(np.zeros((1, 1), np.int8), 1)
    with pytest.raises(MapError, match=fault):
        save_ros_map(grid, tmp_path / name, mode=mode, image_format=image_format)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("blocked", ["map.yaml", "map.png"])
def test_both_files_are_written_or_neither(tmp_path, blocked):
    (tmp_path / blocked).mkdir()
    with pytest.raises(PiantaError, match=f"{blocked}.*folder"):
        save_ros_map(GridMap(np.zeros((1, 1), np.int8), 1), tmp_path / "map.yaml")
    assert [path.name for path in tmp_path.iterdir()] == [blocked]


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["priors", "clutter"])
def test_real_maps_have_floor_walls_and_unknown(data, folder):
    files = sorted((data / folder).glob("*.yaml"))
    assert files
    for file in files:
        grid = read_map(file)
        assert grid.resolution in (0.02, 0.05, 0.1), file
        with Image.open(file.with_suffix(".png")) as image:
            assert grid.shape == (image.height, image.width), file
        shares = [np.mean(grid.cells == value) for value in (-1, 0, 100)]
        assert sum(shares) == pytest.approx(1), file
        assert min(shares) > 0.001, file


@given(st.sampled_from([b"", b"image: map.png\n", b"{", b"%YAML ", b"\xff\xfe"]), st.binary())
def test_random_yaml_raises_only_errors_of_pianta(tmp_path_factory, start, rest):
    path = tmp_path_factory.getbasetemp() / "random.yaml"
    path.write_bytes(start + rest)
    read_or_refuse(path)


@pytest.mark.slow
@settings(max_examples=200)
@given(data=st.data())
def test_mutated_yaml_raises_only_errors_of_pianta(tmp_path_factory, data):
    path = write_map(tmp_path_factory.getbasetemp())
    path.write_bytes(data.draw(mutated(path.read_bytes())))
    read_or_refuse(path)


@pytest.mark.slow
@given(keys=st.fixed_dictionaries({}, optional=dict.fromkeys(KEYS, st.one_of(st.text(), finite, st.none()))))
def test_odd_values_raise_only_errors_of_pianta(tmp_path_factory, keys):
    path = tmp_path_factory.getbasetemp() / "odd.yaml"
    path.write_text(yaml.safe_dump(KEYS | keys), encoding="utf-8")
    read_or_refuse(path)


def read_or_refuse(path: Path) -> None:
    with warnings.catch_warnings(), refused_in_one_line():
        warnings.simplefilter("ignore", MapWarning)
        assert read_ros_map(path, max_cells=10_000).cells.size <= 10_000
