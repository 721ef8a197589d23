"""Methods of floors and maps: rooms by id, drawing, notebooks, saving, and tables."""

import sys
from collections import Counter
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from PIL import Image
from shapely import LineString, box

import pianta
from pianta import Door, Floor, Furniture, GridMap, Room
from pianta.errors import FloorError, MapError, OptionError, PiantaError
from pianta.plot.floor import plot_legend
from pianta.plot.floor_parts import DOOR_COLOR, FURNITURE_COLOR, FURNITURE_OPACITY
from pianta.reading.reading import Reading, StoreyReading
from tests.hidden_figures import hiding_figures

ROOMS = (
    Room(3, box(0, 0, 4, 3), "OFFICE", {"type": "OFFICE"}, {"type": {"OFFICE": 0.75, "LAB": 0.25}}, name="204"),
    Room(7, box(4, 0, 8, 3), partial=True, probability=0.5),
)
DOORS = (
    Door((3, 7), LineString([(4, 1), (4, 2)]), 1.0, probability=0.25),
    Door((7, None), LineString([(8, 0.5), (8, 2.5)]), 2.0, "opening"),
)
WALLS = (LineString([(0, 0), (8, 0)]),)
FURNITURE = (Furniture(box(1, 1, 2, 1.5)), Furniture(box(5, 1, 6, 3), 0.75))
POSSIBLE_DOORS = (Door((3, 7), LineString([(4, 2.25), (4, 2.75)]), 0.5, probability=0.75),)
FLOOR = Floor(ROOMS, DOORS, WALLS, {"office": 1}, "house.yaml", 9, FURNITURE, POSSIBLE_DOORS)
GRID = GridMap(np.array([[0, 100, -1], [0, 0, 50]]), 0.5, (1.0, 2.0, 0.0), "house.yaml")


@pytest.fixture
def _hidden():
    with hiding_figures():
        yield


def decode(content: bytes | None) -> np.ndarray:
    assert content is not None
    with Image.open(BytesIO(content)) as image:
        assert image.format == "PNG"
        return np.asarray(image)


class TestRooms:
    def test_are_found_by_id(self):
        assert FLOOR[7] is ROOMS[1]

    @pytest.mark.parametrize("other", [0, 1, -1, "3", None])
    def test_an_id_that_no_room_has(self, other):
        with pytest.raises(KeyError, match=str(other)):
            _ = FLOOR[other]

    def test_are_counted_and_iterated(self):
        assert len(FLOOR) == 2
        assert [*FLOOR] == [*ROOMS]

    def test_are_in_the_floor_by_id_or_as_rooms(self):
        assert 3 in FLOOR
        assert ROOMS[0] in FLOOR
        assert 4 not in FLOOR
        assert Room(3, box(0, 0, 4, 9)) not in FLOOR
        assert all(room in FLOOR for room in FLOOR)

    def test_a_floor_without_rooms_is_a_floor(self):
        assert Floor(())
        assert len(Floor(())) == 0
        assert 0 not in Floor(())


class TestFloorFiles:
    def test_round_trip(self, tmp_path):
        FLOOR.save(tmp_path / "floor.geojson")
        assert pianta.read_floor(tmp_path / "floor.geojson") == FLOOR
        assert pianta.read_building(tmp_path / "floor.geojson") == FLOOR

    def test_what_cannot_be_written(self, tmp_path):
        with pytest.raises(PiantaError, match="it is a folder"):
            FLOOR.save(tmp_path)
        solid = Floor((), walls=(LineString([(0, 0, 1), (8, 0, 1)]),))
        with pytest.raises(FloorError, match="three dimensions"):
            solid.save(tmp_path / "floor.geojson")
        assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("_hidden")
class TestFloorPictures:
    def test_is_drawn_on_a_new_figure(self):
        from matplotlib import pyplot

        ax = FLOOR.plot()
        assert [pyplot.figure(number) for number in pyplot.get_fignums()] == [ax.figure]
        assert ax.get_aspect() == 1
        assert len(ax.images) == 0
        left, right = ax.get_xlim()
        assert left < 0
        assert right > 8

    def test_a_map_is_shown_completely_in_its_frame(self):
        from matplotlib.figure import Figure

        # 2 × 1 m, turned by a quarter about its corner at (10, 20)
        grid = pianta.GridMap(np.zeros((10, 20), np.int8), 0.1, (10, 20, np.pi / 2))
        ax = grid.plot(ax=Figure().subplots())
        assert (*ax.get_xlim(), *ax.get_ylim()) == pytest.approx((9, 10, 20, 22))

    def test_a_given_ax_gets_equal_scales(self):
        from matplotlib.figure import Figure

        (left, _) = Figure().subplots(1, 2)
        assert FLOOR.plot(ax=left).get_aspect() == 1

    def test_is_drawn_on_its_map_and_where_it_is_reported(self):
        from matplotlib.figure import Figure

        ax = Figure().add_subplot()
        assert FLOOR.plot(GRID, ax=ax) is ax
        assert len(ax.images) == 1

    def test_walls_and_graph_are_drawn_on_demand(self):
        plain, walls, graph = FLOOR.plot(), FLOOR.plot(walls=True), FLOOR.plot(graph=True)
        assert len(walls.lines) == len(plain.lines) + len(WALLS)
        # One edge joins the two rooms; the entrance leads to no room.
        assert len(graph.lines) == len(plain.lines) + 1

    def test_furniture_is_drawn_unless_it_is_left_out(self):
        complete, without = FLOOR.plot(), FLOOR.plot(furniture=False)
        colors = Counter(patch.get_facecolor() for patch in complete.patches)
        colors.subtract(patch.get_facecolor() for patch in without.patches)
        ((color, count),) = (+colors).items()
        assert count == len(FURNITURE)
        assert color == to_rgba(FURNITURE_COLOR, FURNITURE_OPACITY)

    def test_possible_doors_are_thin_dashed_lines_in_the_colour_of_doors(self):
        complete, without = (replace(FLOOR, possible_doors=doors).plot() for doors in (POSSIBLE_DOORS, ()))
        assert len(complete.lines) == len(without.lines) + 1
        (line,) = (line for line in complete.lines if np.array_equal(line.get_ydata(), [2.25, 2.75]))
        assert line.get_color() == DOOR_COLOR
        assert line.is_dashed()
        assert line.get_linewidth() < min(line.get_linewidth() for line in without.lines if line.get_marker() == "None")

    def test_the_legend_has_possible_doors_if_there_are_any(self):
        def list_entries(floor: Floor) -> list[str]:
            legend = plot_legend(floor).get_legend()
            assert legend is not None
            return [text.get_text() for text in legend.get_texts()]

        without = list_entries(replace(FLOOR, possible_doors=()))
        assert list_entries(FLOOR) == [*without, "possible door, shut"]

    def test_a_floor_without_rooms_is_drawn(self):
        assert not Floor(()).plot(walls=True, graph=True).lines

    def test_a_notebook_shows_it(self):
        height, width, _ = decode(FLOOR._repr_png_()).shape
        assert width > height > 100

    def test_a_notebook_shows_no_picture_without_rooms(self):
        assert Floor(())._repr_png_() is None


class TestTables:
    def test_rooms(self):
        table = FLOOR.to_geodataframe()
        assert [*table.index] == [3, 7]
        assert table.index.name == "id"
        certain = ["label_probability", "partial", "area", "probability"]
        assert [*table.columns] == ["number", "name", "label", *certain, "geometry"]
        assert table.loc[3].drop(["geometry", "number", "probability"]).to_dict() == {
            "name": "204",
            "label": "OFFICE",
            "label_probability": 0.75,
            "partial": False,
            "area": 12.0,
        }
        assert table.loc[7, ["number", "name", "label", "label_probability"]].isna().all()
        assert table["probability"].isna().tolist() == [True, False]
        assert table.loc[7, "probability"] == 0.5
        assert [*table.geometry] == [room.polygon for room in ROOMS]
        assert table.crs is None

    def test_doors(self):
        table = FLOOR.to_geodataframe("doors")
        assert [*table.columns] == ["room", "other_room", "width", "kind", "probability", "geometry"]
        assert [*table["room"]] == [3, 7]
        assert table["other_room"][0] == 7
        assert table["other_room"].isna().tolist() == [False, True]
        assert [*table["width"]] == [1.0, 2.0]
        assert [*table["kind"]] == ["door", "opening"]
        assert table["probability"].isna().tolist() == [False, True]
        assert table["probability"][0] == 0.25
        assert [*table.geometry] == [door.line for door in DOORS]

    def test_walls(self):
        table = FLOOR.to_geodataframe("walls")
        assert [*table.columns] == ["geometry"]
        assert [*table.geometry] == [*WALLS]

    def test_furniture(self):
        table = FLOOR.to_geodataframe("furniture")
        assert [*table.columns] == ["area", "probability", "geometry"]
        assert [*table["area"]] == [0.5, 2.0]
        assert table["probability"].isna().tolist() == [True, False]
        assert table["probability"][1] == 0.75
        assert [*table.geometry] == [piece.polygon for piece in FURNITURE]

    def test_possible_doors(self):
        table = FLOOR.to_geodataframe("possible_doors")
        assert [*table.columns] == [*FLOOR.to_geodataframe("doors").columns]
        assert table.loc[0].drop("geometry").to_dict() == {
            "room": 3,
            "other_room": 7,
            "width": 0.5,
            "kind": "door",
            "probability": 0.75,
        }
        assert [*table.geometry] == [door.line for door in POSSIBLE_DOORS]

    @pytest.mark.parametrize("layer", ["rooms", "doors", "walls", "furniture", "possible_doors"])
    def test_a_layer_without_rows_has_its_columns(self, layer):
        empty, full = Floor(()).to_geodataframe(layer), FLOOR.to_geodataframe(layer)
        assert len(empty) == 0
        assert [*empty.columns] == [*full.columns]
        assert empty.index.dtype == full.index.dtype

    def test_geometry_counts_in_metres(self):
        assert [*FLOOR.to_geodataframe().area] == [12.0, 12.0]
        assert [*FLOOR.to_geodataframe("doors").length] == [1.0, 2.0]

    @pytest.mark.parametrize("layer", ["windows", "", None, ["rooms"]])
    def test_another_layer(self, layer):
        with pytest.raises(OptionError, match="give one of rooms, doors, walls, furniture, possible_doors"):
            FLOOR.to_geodataframe(layer)

    def test_without_geopandas(self, monkeypatch):
        monkeypatch.setitem(sys.modules, "geopandas", None)
        with pytest.raises(OptionError) as caught:
            FLOOR.to_geodataframe()
        assert str(caught.value) == "geopandas is not installed, install it with: pip install 'pianta[geo]'"


class TestMaps:
    @pytest.mark.parametrize("name", ["map.yaml", "map.yml", "map.npz", "map.YAML"])
    def test_round_trip(self, tmp_path, name):
        GRID.save(tmp_path / name)
        read = pianta.read_map(tmp_path / name)
        assert (read.cells == GRID.cells).all()
        assert (read.resolution, read.origin, read.source) == (0.5, (1.0, 2.0, 0.0), name)

    @pytest.mark.parametrize("name", ["map.png", "map", "map.geojson"])
    def test_another_suffix(self, tmp_path, name):
        with pytest.raises(MapError, match=r"give .yaml or .npz"):
            GRID.save(tmp_path / name)
        assert list(tmp_path.iterdir()) == []

    def test_its_source_becomes_that_of_its_floor(self):
        grid = GridMap(np.pad(np.zeros((60, 60), int), 5, constant_values=100), 0.1, source="square.yaml")
        assert pianta.reconstruct(grid).source == "square.yaml"
        assert GridMap(np.zeros((1, 1), int), 0.1).source == ""

    @pytest.mark.usefixtures("_hidden")
    def test_is_drawn_in_metres(self):
        ax = GRID.plot()
        (image,) = ax.images
        assert [*image.get_extent()] == [0, 1.5, 0, 1]
        assert GRID.plot(ax=ax) is ax

    def test_a_notebook_shows_one_pixel_per_cell(self):
        assert decode(GRID._repr_png_()).tolist() == [[255, 110, 228], [255, 255, 228]]

    def test_a_notebook_shows_a_large_map_smaller(self):
        large = GridMap(np.zeros((1500, 2001), np.int8), 0.05)
        assert decode(large._repr_png_()).shape == (500, 667)


def test_results_are_short_in_a_console() -> None:
    floor = Floor((Room(1, box(0, 0, 4, 3)), Room(2, box(4, 0, 6, 3))), source="map.yaml")
    assert repr(floor) == "<Floor 'map.yaml': 2 rooms, 0 doors, 18.0 m²>"
    grid = GridMap(np.zeros((2, 3), np.int8), 0.05, source="map.yaml")
    assert repr(grid) == "<GridMap 'map.yaml': 2 × 3 cells of 0.05 m>"
    assert repr(Reading(Path("map.yaml"), (StoreyReading(floor, grid),), {})) == f"<Reading 'map.yaml': {floor!r}>"
