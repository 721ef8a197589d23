"""Clean maps: without furniture, spray and people, by `pianta read --clean` and from Python."""

from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest
from PIL import Image
from shapely import LinearRing, LineString, Polygon, box
from shapely.affinity import rotate

import pianta
from pianta.errors import OptionError, PiantaError
from pianta.floor import Door, Floor, Furniture, Room
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.plan.sheets.sheet import PlanScale
from pianta.reading.reading import StoreyReading
from tests.command_line import list_files, run_pianta
from tests.drawn_maps import Rectangle, carve

# Two rooms of 3 × 3 m with walls of 2 cells, cells of 0.05 m, and a doorway of 1 m between them.
SHAPE = (80, 150)
ROOMS: list[Rectangle] = [(10, 70, 10, 70), (10, 70, 72, 132)]
DOORWAY: Rectangle = (30, 50, 70, 72)
WALLS: Rectangle = (8, 72, 8, 134)
FLOOR = Floor(
    (Room(1, box(0.5, 0.5, 3.5, 3.5)), Room(2, box(3.6, 0.5, 6.6, 3.5))),
    (Door((1, 2), LineString([(3.55, 1.5), (3.55, 2.5)]), 1.0),),
)


def draw_map(
    *occupied: Rectangle, free: tuple[Rectangle, ...] = (), unknown: tuple[Rectangle, ...] = (), yaw: float = 0.0
) -> GridMap:
    cells = np.where(carve(SHAPE, WALLS), OCCUPIED, UNKNOWN)
    cells[carve(SHAPE, *ROOMS, DOORWAY, *free)] = FREE
    cells[carve(SHAPE, *occupied)] = OCCUPIED
    cells[carve(SHAPE, *unknown)] = UNKNOWN
    return GridMap(cells, 0.05, (0.0, 0.0, yaw), "map.yaml")


EMPTY = draw_map()


def find_changes(clean: GridMap, expected: GridMap = EMPTY) -> list[tuple[int, int, int]]:
    """Row, column and value of the cells that are not as expected."""
    rows, cols = np.nonzero(clean.cells != expected.cells)
    return [(row, col, int(clean.cells[row, col])) for row, col in zip(rows.tolist(), cols.tolist(), strict=True)]


class TestDrawnMaps:
    def test_an_empty_map_stays_as_it_is(self):
        clean = pianta.clean_map(EMPTY, FLOOR)
        assert find_changes(clean) == []
        assert (clean.resolution, clean.origin, clean.source) == (0.05, (0.0, 0.0, 0.0), "map.yaml")

    @pytest.mark.parametrize(
        "thing",
        [
            pytest.param(draw_map((30, 42, 30, 50)), id="table"),
            pytest.param(draw_map((30, 42, 30, 50), unknown=((31, 41, 31, 49),)), id="table, not seen inside"),
            pytest.param(draw_map((30, 31, 30, 31)), id="speck"),
            pytest.param(draw_map((60, 62, 20, 22), (60, 62, 27, 29)), id="legs of a person"),
            pytest.param(draw_map(unknown=((30, 42, 30, 50),)), id="shadow"),
            pytest.param(draw_map((10, 18, 20, 44)), id="shelf at a wall"),
        ],
    )
    def test_what_is_no_wall_goes(self, thing):
        assert find_changes(thing) != []
        assert find_changes(pianta.clean_map(thing, FLOOR)) == []

    def test_a_wall_that_a_shelf_hid_is_drawn(self):
        """The shelf has no back: behind it nothing was seen, neither its inside nor the wall."""
        shelf = draw_map((10, 18, 20, 44), unknown=((8, 17, 21, 43),))
        clean = pianta.clean_map(shelf, FLOOR)
        # The outer one of the two rows of the wall remains unknown.
        assert find_changes(clean) == [(8, col, UNKNOWN) for col in range(21, 43)]

    def test_rays_through_a_window_and_what_they_hit_become_unknown(self):
        window: tuple[Rectangle, ...] = ((8, 10, 40, 42), (0, 8, 38, 44))
        spray: Rectangle = (30, 33, 146, 147)
        clean = pianta.clean_map(draw_map(spray, free=window), FLOOR)
        # The window itself stays: 0.1 m from the room.
        assert find_changes(clean) == [(row, col, FREE) for row in (8, 9) for col in (40, 41)]

    def test_spray_near_a_wall_stays(self):
        """0.4 m from the room, it may be the outer side of a wall."""
        spray: Rectangle = (3, 4, 60, 62)
        clean = pianta.clean_map(draw_map(spray), FLOOR)
        assert find_changes(clean) == [(3, col, OCCUPIED) for col in (60, 61)]

    def test_a_stub_of_a_wall_stays(self):
        stub = draw_map((50, 70, 40, 44), unknown=((51, 70, 41, 43),))
        assert find_changes(pianta.clean_map(stub, FLOOR), stub) == []

    def test_the_floors_furniture_decides(self):
        """A model has found the stub to be furniture, and the table to be none."""
        grid = draw_map((50, 70, 40, 42), (30, 42, 30, 50))
        stub = Furniture(box(2.0, 0.5, 2.1, 1.5), 0.9)
        clean = pianta.clean_map(grid, Floor(FLOOR.rooms, FLOOR.doors, furniture=(stub,)))
        assert find_changes(clean) == [(row, col, OCCUPIED) for row in range(30, 42) for col in range(30, 50)]

    def test_a_map_may_be_turned_and_have_other_values(self):
        grid = draw_map((30, 42, 30, 50), yaw=0.3)
        grey = GridMap(np.where(grid.free, 20, np.where(grid.occupied, 80, 40)), 0.05, grid.origin)
        rooms = tuple(Room(room.id, turn(room.polygon)) for room in FLOOR.rooms)
        doors = (Door((1, 2), turn(FLOOR.doors[0].line), 1.0),)
        clean = pianta.clean_map(grey, Floor(rooms, doors))
        assert find_changes(clean) == []
        assert clean.origin == (0.0, 0.0, 0.3)

    @pytest.mark.parametrize("arguments", [(None, FLOOR), (EMPTY, EMPTY)])
    def test_arguments_of_other_types(self, arguments):
        with pytest.raises(PiantaError, match="give a"):
            pianta.clean_map(*arguments)


Shape = TypeVar("Shape", Polygon, LineString)


def turn(shape: Shape) -> Shape:
    """The shape turned by 0.3 rad about the origin."""
    turned: Shape = rotate(shape, 0.3, origin=(0, 0), use_radians=True)
    return turned


@pytest.fixture(scope="module")
def furnished(tmp_path_factory) -> Path:
    """The map.yaml of a corridor with furnished rooms."""
    folder = Path(tmp_path_factory.mktemp("furnished"))
    run_pianta("world", "corridor", "-o", folder, "--furniture", 0.7)
    return folder / "map.yaml"


def shares(clean: GridMap, furnished: GridMap, empty: GridMap) -> tuple[float, float]:
    """Of the free cells that furniture hides the share that is free again, and of the walls that which stays."""

    hidden = empty.free & ~furnished.free
    return float(clean.free[hidden].mean()), float(clean.occupied[empty.occupied].mean())


class TestCommand:
    def test_a_furnished_world_becomes_the_empty_one(self, furnished, tmp_path):
        out, target = tmp_path / "building", tmp_path / "clean.yaml"
        outcome = run_pianta("read", furnished, "-o", out, "--clean", target, "--no-labels")
        assert (outcome.code, outcome.err) == (0, "")
        assert f"clean map in {target}" in outcome.out
        clean, grid = pianta.read_map(target), pianta.read_map(furnished)
        assert (clean.resolution, clean.origin, clean.shape) == (grid.resolution, grid.origin, grid.shape)
        _, empty = pianta.make_world("corridor")
        assert np.count_nonzero(empty.free & ~grid.free) > 3000
        freed_share, wall_share = shares(clean, grid, empty)
        assert freed_share > 0.95
        assert wall_share > 0.99

    def test_a_clean_map_has_the_same_rooms_and_stays_as_it_is(self, furnished, tmp_path):
        run_pianta("read", furnished, "-o", tmp_path / "one", "--clean", tmp_path / "clean.yaml", "--no-labels")
        again = pianta.read(tmp_path / "clean.yaml", labels=False)
        assert len(again.floor) == len(pianta.read_floor(tmp_path / "one" / "floor.geojson"))
        assert again.floor.furniture == ()
        assert find_changes(again.clean_map(), again.grid) == []

    def test_the_image_has_the_greys_of_the_map_saver(self, furnished, tmp_path):
        run_pianta("read", furnished, "-o", tmp_path / "one", "--clean", tmp_path / "clean.yaml", "--no-labels", "-q")
        with Image.open(tmp_path / "clean.png") as image:
            assert {*np.unique(np.asarray(image)).tolist()} == {0, 205, 254}
        assert "free_thresh: 0.196" in (tmp_path / "clean.yaml").read_text()

    def test_an_archive(self, furnished, tmp_path):
        target = tmp_path / "clean.npz"
        outcome = run_pianta("read", furnished, "-o", tmp_path / "out", "--clean", target, "--no-labels", "-q")
        assert outcome == (0, "", "")
        assert pianta.read_map(target).shape == pianta.read_map(furnished).shape

    @pytest.mark.parametrize(
        ("clean", "message"),
        [
            ("map.yaml", "would replace the map that is read, give another name"),
            ("./sub/../map.yaml", "would replace the map that is read, give another name"),
            ("picture.yml", "would replace the map that is read, give another name"),
            ("out/rooms.yaml", "would replace a result, give another name"),
            ("clean.png", "cannot be saved as 'clean.png', give .yaml or .npz"),
            ("folder.npz", "is a folder, give the name of a file"),
            ("map.yaml/clean.yaml", "is a file, give another folder"),
        ],
    )
    def test_what_it_would_replace_is_refused(self, tmp_path, monkeypatch, clean, message):
        """The image of the map is picture.png."""
        monkeypatch.chdir(tmp_path)
        for folder in ("sub", "folder.npz", "out"):
            Path(folder).mkdir()
        EMPTY.save("picture.yaml")
        Path("map.yaml").write_text(Path("picture.yaml").read_text())
        Path("picture.yaml").unlink()
        before = list_files(tmp_path)
        outcome = run_pianta("read", "map.yaml", "-o", "out", "--clean", clean)
        assert outcome.code == 2
        assert message in outcome.err
        assert outcome.err.count("\n") == 1
        assert list_files(tmp_path) == before

    def test_several_files_are_refused(self, furnished, tmp_path):
        outcome = run_pianta("read", furnished, furnished, "-o", tmp_path / "out", "--clean", tmp_path / "clean.yaml")
        assert (outcome.code, outcome.out) == (2, "")
        assert "--clean is for one map and 2 files are given, read each file on its own" in outcome.err
        assert list_files(tmp_path) == {}

    def test_a_plan_has_no_map(self):
        storey = StoreyReading(FLOOR, EMPTY, scale=PlanScale(0.05, "a guess", 1.0))
        with pytest.raises(OptionError, match=r"plan 'house.dxf' has no map to clean, give a robot's map"):
            pianta.Reading(Path("house.dxf"), (storey,), {}).clean_map()


REAL_MAPS = [
    "robotmaps/aws_small_house/aws_small_house.yaml",
    "robotmaps/pepper_apartment/pepper_apartment.yaml",
    "clutter/g4sy2.yaml",
    "clutter/vimantichouse20.yaml",
]


def holes_above(polygon: Polygon, area: float) -> list[LinearRing]:
    return [hole for hole in polygon.interiors if Polygon(hole).area > area]


@pytest.mark.parametrize("name", REAL_MAPS)
def test_real_maps_have_more_free_floor_and_keep_their_walls(data, name):
    path = data / name
    if not path.exists():
        pytest.skip(f"no {name} in the data")
    grid = pianta.read_map(path)
    floor = pianta.reconstruct(grid, predict_partial=False)
    clean = pianta.clean_map(grid, floor)
    in_rooms = floor.label_image(grid) > 0
    assert not (grid.free & in_rooms & ~clean.free).any()
    assert np.count_nonzero(clean.free & in_rooms) > np.count_nonzero(grid.free & in_rooms)
    # Islands of up to 8 m² in one room count as standing in it; the rest of what is occupied outside are mostly walls
    outlines = [Polygon(room.polygon.exterior, holes_above(room.polygon, 8.0)) for room in floor]
    filled = Floor(tuple(replace(room, polygon=outline) for room, outline in zip(floor, outlines, strict=True)))
    walls = grid.occupied & ~in_rooms & (filled.label_image(grid) == 0)
    assert clean.occupied[walls].mean() > 0.99
