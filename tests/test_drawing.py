"""Pictures of floors: marks, colours and positions, in the map frame."""

from dataclasses import replace
from io import BytesIO
from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Circle, PathPatch, Rectangle
from PIL import Image
from shapely import LineString, Point, box, unary_union

from pianta.errors import PiantaError
from pianta.floor import Door, Floor, Furniture, Room
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.plot.figure import save_figure
from pianta.plot.floor import draw_floor, plot_floor, plot_legend
from pianta.plot.floor_parts import (
    DOOR_COLOR,
    ENTRANCE_COLOR,
    PARTIAL_COLOR,
    plot_doors,
    plot_rooms,
    plot_walls,
)
from pianta.plot.grid import FREE_GREY, OCCUPIED_GREY, UNKNOWN_GREY, plot_grid
from pianta.plot.picture import plot_scale_bar
from pianta.plot.room_marks import plot_graph
from pianta.plot.strokes import DoorStroke
from pianta.plot.styles import DARK_INK, LIGHT_INK, ROOM_COLORS, style_rooms
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from pianta.worlds.scan import simulate_map

TWO_ROOMS = Floor(
    rooms=(Room(1, box(0, 0, 4, 3)), Room(2, box(4.1, 0, 8, 3), partial=True)),
    doors=(Door((1, 2), LineString([(4.05, 1), (4.05, 2)]), 1),),
    walls=(LineString([(0, 0), (8, 0)]), LineString([(4.05, 0), (4.05, 3)])),
)
AROUND_TWO_ROOMS = GridMap(np.full((100, 200), UNKNOWN, np.int8), 0.05, (-1.0, -1.0, 0.0))


LABELLED = replace(
    TWO_ROOMS,
    rooms=(
        Room(1, box(0, 0, 4, 3), "LIBRARY", label_probabilities={"school": {"LIBRARY": 0.5}}),
        Room(2, box(4.1, 0, 8, 3), "CORRIDOR", label_probabilities={"school": {"CORRIDOR": 0.9}}, partial=True),
    ),
    building_type={"school": 1.0},
)


@pytest.fixture
def ax():
    return Figure().add_axes((0, 0, 1, 1))


def color_at(ax: Axes, x: float, y: float) -> tuple[int, ...]:
    """Red, green and blue of the pixel at a position of the map frame."""
    content, figure = BytesIO(), ax.get_figure(root=True)
    assert figure
    figure.savefig(content, format="png")
    pixels = np.asarray(Image.open(content))
    right, up = ax.transData.transform((x, y))
    return tuple(pixels[-1 - int(up), int(right), :3].tolist())


def room_patches(ax: Axes):
    return [patch for patch in ax.patches if isinstance(patch, PathPatch) and patch.get_linewidth() > 0]


def id_patches(ax: Axes):
    return [patch for patch in ax.patches if isinstance(patch, PathPatch) and patch.get_linewidth() == 0]


@pytest.mark.slow
@pytest.mark.parametrize("origin", [(0, 0, 0), (-3, 70, 0.5), (10, 10, pi / 2), (4.5e6, 5e5, -2)])
@pytest.mark.parametrize("resolution", [0.05, 2])
def test_each_cell_has_its_grey_at_its_position_in_the_map_frame(ax, origin, resolution):
    cells = np.array([[UNKNOWN, FREE, 50], [OCCUPIED, FREE, FREE]], np.int8)
    grid = GridMap(cells, resolution, origin)
    assert plot_grid(grid, ax=ax) is ax
    corners = grid.pixel_to_map([0, 0, 2, 2], [0, 3, 0, 3])
    ax.set(xlim=(corners[0].min(), corners[0].max()), ylim=(corners[1].min(), corners[1].max()))
    for (row, col), cell in np.ndenumerate(cells):
        grey = {FREE: FREE_GREY, OCCUPIED: OCCUPIED_GREY}.get(int(cell), UNKNOWN_GREY)
        x, y = grid.pixel_to_map(row + 0.5, col + 0.5)
        assert color_at(ax, float(x), float(y)) == (grey, grey, grey)


def test_a_map_larger_than_any_picture_is_averaged_down_in_place(ax):
    cells = np.full((3, 5001), FREE, np.int8)
    cells[:, 5000] = OCCUPIED
    plot_grid(GridMap(cells, 1), ax=ax)
    (image,) = ax.images
    assert image.get_size() == (2, 2501)
    assert image.get_extent() == [0, 5002, -1, 3]


@pytest.mark.slow
@given(st.sampled_from(sorted(FLOOR_MAKERS)), st.integers(0, 1000))
@settings(max_examples=10)
def test_rooms_with_a_wall_in_common_differ_in_colour(floor_type, seed):
    floor = make_floor(floor_type, seed=seed)
    ax = plot_rooms(floor, ax=Figure().add_axes((0, 0, 1, 1)))
    colors = [to_hex(patch.get_facecolor()) for patch in room_patches(ax)]
    assert set(colors) <= set(ROOM_COLORS)
    for i, one in enumerate(floor.rooms):
        for j, other in enumerate(floor.rooms[:i]):
            assert colors[i] != colors[j] or one.polygon.distance(other.polygon) > 0.3


@pytest.mark.slow
@given(st.sampled_from(sorted(FLOOR_MAKERS)), st.integers(0, 1000))
@settings(max_examples=10)
def test_ids_stand_inside_their_rooms(floor_type, seed):
    floor = make_floor(floor_type, seed=seed)
    ax = plot_rooms(floor, ax=Figure().add_axes((0, 0, 1, 1)))
    for room, digits in zip(floor.rooms, id_patches(ax), strict=True):
        left, bottom, right, top = digits.get_path().get_extents().extents
        assert room.polygon.contains(box(left, bottom, right, top))


def test_an_id_is_never_too_small_to_read(ax):
    closet_in_a_palace = Floor((Room(1, box(0, 0, 100, 50)), Room(88, box(100, 0, 100.1, 0.1))))
    plot_rooms(closet_in_a_palace, ax=ax)
    assert [digits.get_path().get_extents().height for digits in id_patches(ax)] == pytest.approx([1.9, 0.88], rel=0.05)


@pytest.mark.slow
def test_a_room_with_a_hole_is_not_filled_there():
    courtyard = Floor((Room(1, box(0, 0, 8, 8).difference(box(3, 3, 5, 5))),))
    (ax,) = draw_floor(courtyard, GridMap(np.full((10, 10), UNKNOWN, np.int8), 1)).axes
    assert color_at(ax, 4, 4) == (UNKNOWN_GREY,) * 3
    assert color_at(ax, 7, 7) != (UNKNOWN_GREY,) * 3


def test_partial_rooms_are_grey_and_hatched(ax):
    full, partial = room_patches(plot_rooms(TWO_ROOMS, ax=ax))
    assert to_hex(partial.get_facecolor()) == PARTIAL_COLOR
    assert partial.get_hatch()
    assert to_hex(full.get_facecolor()) in ROOM_COLORS
    assert not full.get_hatch()


def test_a_prediction_is_hatched_beside_the_explored_part_in_a_dashed_outline(ax):
    predicted = box(4.1, 0, 12, 3)
    rooms = TWO_ROOMS.rooms[0], replace(TWO_ROOMS.rooms[1], predicted=predicted, confidence=0.5)
    plot_rooms(replace(TWO_ROOMS, rooms=rooms), ax=ax)
    added = [patch for patch in ax.patches if patch.get_zorder() < 1]
    unseen, outline = added
    assert unseen.get_hatch()
    assert unseen.get_path().get_extents().bounds == pytest.approx((8, 0, 4, 3))
    assert outline.get_linestyle() not in ("-", "solid")
    assert outline.get_path().get_extents().bounds == pytest.approx((4.1, 0, 7.9, 3))
    labelled = tuple(replace(room, label="LAB") for room in rooms)
    assert legend_of(Floor(labelled))[-2:] == ["predicted", "seen in part"]


def test_a_prediction_does_not_widen_the_picture():
    predicted = box(4.1, 0, 50, 30)
    rooms = TWO_ROOMS.rooms[0], replace(TWO_ROOMS.rooms[1], predicted=predicted, confidence=0.5)
    grids = AROUND_TWO_ROOMS, None
    plain, wide = (
        [plot_floor(floor, grid, ax=Figure().add_subplot()).axis() for grid in grids]
        for floor in (TWO_ROOMS, replace(TWO_ROOMS, rooms=rooms))
    )
    assert plain == wide
    pictures = [draw_floor(floor, AROUND_TWO_ROOMS) for floor in (TWO_ROOMS, replace(TWO_ROOMS, rooms=rooms))]
    assert pictures[0].axes[0].axis() == pictures[1].axes[0].axis()


def test_labelled_rooms_have_the_colours_of_their_labels_and_partial_ones_are_lighter_and_hatched(ax):
    library, corridor = room_patches(plot_rooms(LABELLED, ax=ax, labels=True))
    assert [to_hex(patch.get_facecolor()) for patch in (library, corridor)] == ["#3c3c3c", "#f28705"]
    assert library.get_facecolor()[3] > corridor.get_facecolor()[3]
    assert not library.get_hatch()
    assert corridor.get_hatch()


def test_labels_are_drawn_on_request_only(ax):
    plot_rooms(LABELLED, ax=ax)
    plain = plot_rooms(TWO_ROOMS, ax=Figure().add_axes((0, 0, 1, 1)))
    for patch, expected in zip(ax.patches, plain.patches, strict=True):
        assert patch.get_facecolor() == expected.get_facecolor()
        assert patch.get_path().vertices == pytest.approx(expected.get_path().vertices)
    assert len(draw_floor(TWO_ROOMS, AROUND_TWO_ROOMS).axes) == 1


def test_ids_are_white_on_dark_labels_and_uncertain_ones_have_a_question_mark(ax):
    uncertain, certain = id_patches(plot_rooms(LABELLED, ax=ax, labels=True))
    assert (to_hex(uncertain.get_facecolor()), to_hex(certain.get_facecolor())) == (LIGHT_INK, DARK_INK)
    widths = [patch.get_path().get_extents().width for patch in (uncertain, certain)]
    assert widths[0] > 1.5 * widths[1]


@pytest.mark.slow
@given(st.sampled_from(sorted(FLOOR_MAKERS)), st.integers(0, 1000))
@settings(max_examples=10)
def test_uncertain_ids_stand_inside_their_rooms_and_nodes(floor_type, seed):
    floor = make_floor(floor_type, seed=seed)
    probabilities = {"type": {"ROOM": 0.5, "CORRIDOR": 0.5, "HALL": 0.5}}
    floor = replace(floor, rooms=tuple(replace(room, label_probabilities=probabilities) for room in floor.rooms))
    ids = id_patches(plot_rooms(floor, ax=Figure().add_axes((0, 0, 1, 1)), labels=True))
    nodes = plot_graph(floor, ax=Figure().add_axes((0, 0, 1, 1)), labels=True).patches
    assert style_rooms(floor)[1].is_uncertain
    for room, digits, node in zip(floor.rooms, ids, nodes, strict=True):
        text = box(*digits.get_path().get_extents().extents)
        shape = node.get_patch_transform().transform_path(node.get_path())
        assert room.polygon.contains(text)
        assert shape.contains_points(text.exterior.coords).all()


def test_doors_are_strokes_from_jamb_to_jamb_and_openings_are_dashed(ax):
    opening = replace(TWO_ROOMS.doors[0], kind="opening", line=LineString([(5, 1), (5, 2)]))
    plot_doors(replace(TWO_ROOMS, doors=(*TWO_ROOMS.doors, opening)), ax=ax)
    solid, dashed = ax.lines
    assert solid.get_xydata().tolist() == [[4.05, 1], [4.05, 2]]
    assert solid.get_solid_capstyle() == "butt"
    assert (solid.is_dashed(), dashed.is_dashed()) == (False, True)


@pytest.mark.parametrize(("door_kind", "dashed"), [("door", False), ("opening", True)])
def test_an_entrance_has_another_colour_and_a_diamond_in_its_middle(ax, door_kind, dashed):
    entrance = Door((1, None), LineString([(0, 1), (0, 2)]), 1, door_kind)
    plot_doors(replace(TWO_ROOMS, doors=(*TWO_ROOMS.doors, entrance)), ax=ax)
    door, stroke, diamond = ax.lines
    assert (door.get_color(), stroke.get_color(), diamond.get_color()) == (DOOR_COLOR, ENTRANCE_COLOR, ENTRANCE_COLOR)
    assert stroke.get_xydata().tolist() == [[0, 1], [0, 2]]
    assert stroke.is_dashed() == dashed
    assert (diamond.get_marker(), diamond.get_xydata().tolist()) == ("D", [[0, 1.5]])


@pytest.mark.parametrize(("metres", "width", "diamond"), [(1, 3.0, 7.0), (15, 0.45 * 72 / 15, 7.0), (60, 1.4, 3.5)])
def test_strokes_of_doors_are_as_wide_as_the_scale_allows(metres, width, diamond):
    """An inch, 72 points, is as many metres long on the floor; a stroke is 0.45 m wide, but 1.4 to 3 points."""
    figure = Figure(figsize=(1, 1))
    ax = figure.add_axes((0, 0, 1, 1))
    plot_doors(replace(TWO_ROOMS, doors=(Door((1, None), LineString([(0, 1), (0, 2)]), 1),)), ax=ax)
    ax.set(xlim=(0, metres), ylim=(0, metres))
    figure.draw_without_rendering()
    strokes = [line for line in ax.lines if isinstance(line, DoorStroke)]
    renderer = RendererAgg(100, 100, figure.dpi)  # type: ignore[no-untyped-call]
    assert [line.fit_sizes(renderer) for line in strokes] == [pytest.approx((width, diamond))] * 2
    # Legends copy lines after they were drawn
    assert [(line.get_linewidth(), line.get_markersize()) for line in strokes] == [(3.0, 7.0)] * 2


def test_an_entrance_is_drawn_in_the_picture_and_is_no_edge_of_the_graph():
    entrance = Door((1, None), LineString([(0, 1), (0, 2)]), 1)
    (ax,) = draw_floor(replace(TWO_ROOMS, doors=(entrance,)), AROUND_TWO_ROOMS, graph=True).axes
    assert color_at(ax, 0, 1.5) == pytest.approx([255 * part for part in to_rgb(ENTRANCE_COLOR)])
    plain = Figure().add_axes((0, 0, 1, 1))
    plot_graph(replace(TWO_ROOMS, doors=(entrance,)), ax=plain)
    assert not plain.lines


def test_a_door_changes_pixels_of_the_picture():
    (ax,) = draw_floor(TWO_ROOMS, AROUND_TWO_ROOMS).axes
    assert color_at(ax, 4.05, 1.5) == pytest.approx([255 * part for part in to_rgb(DOOR_COLOR)])


def test_walls_are_the_representative_lines(ax):
    plot_walls(TWO_ROOMS, ax=ax)
    assert [LineString(line.get_xydata()) for line in ax.lines] == list(TWO_ROOMS.walls)


def test_graph_has_a_node_per_room_and_edges_through_the_doors(ax):
    plot_graph(TWO_ROOMS, ax=ax)
    nodes = [patch.center for patch in ax.patches if isinstance(patch, Circle)]
    assert nodes == [pytest.approx((2, 1.5)), pytest.approx((6.05, 1.5))]
    (edge,) = ax.lines
    assert edge.get_xydata() == pytest.approx(np.array([(2, 1.5), (4.05, 1.5), (6.05, 1.5)]))


def test_a_node_of_a_winding_room_is_inside_it(ax):
    corridor = box(0, 0, 30, 2).union(box(0, 0, 2, 30))
    plot_graph(Floor((Room(1, corridor),)), ax=ax)
    (node,) = ax.patches
    assert corridor.contains(Point(node.center))


def test_nodes_are_squares_for_corridors_and_circles_for_rooms_in_the_colours_of_labels(ax):
    library, corridor = plot_graph(LABELLED, ax=ax, labels=True).patches
    assert isinstance(library, Circle)
    assert library.center == pytest.approx((2, 1.5))
    assert isinstance(corridor, Rectangle)
    assert corridor.get_center() == pytest.approx((6.05, 1.5))
    fills = [style.fill for style in style_rooms(LABELLED).values()]
    assert [to_hex(node.get_facecolor()) for node in (library, corridor)] == fills


def legend_of(floor: Floor, *, graph: bool = False) -> list[str]:
    (ax,) = draw_floor(floor, AROUND_TWO_ROOMS, graph=graph).axes[1:]
    legend = ax.get_legend()
    assert legend
    return [text.get_text() for text in legend.get_texts()]


def test_the_legend_lists_the_rooms_of_each_label():
    labels = "LAB", "GYM", "LAB", None, "LAB", "LAB", "GYM"
    rooms = tuple(Room(id_, box(id_, 0, id_ + 0.9, 3), label) for id_, label in enumerate(labels, start=1))
    floor = Floor(rooms, building_type={"school": 1.0})
    assert legend_of(floor) == ["4 × LAB", "2 × GYM (2 7)", "1 × no label (4)"]


def test_the_legend_explains_marks_that_occur():
    labels = ["1 × LIBRARY (1)", "1 × CORRIDOR (2)"]
    assert legend_of(LABELLED) == [*labels, "probability below 0.6", "seen in part", "door"]
    assert legend_of(LABELLED, graph=True)[-2:] == ["corridor", "room"]
    certain = tuple(replace(room, label_probabilities={}, partial=False) for room in LABELLED.rooms)
    plain = replace(LABELLED, rooms=certain)
    assert legend_of(plain) == [*labels, "door"]
    assert legend_of(replace(plain, doors=())) == labels
    passages = (
        Door((1, 2), LineString([(4, 1), (4, 2)]), 1, "opening"),
        Door((1, None), LineString([(0, 1), (0, 2)]), 1),
    )
    furnished = replace(plain, doors=passages, furniture=(Furniture(box(1, 1, 2, 2)),))
    assert legend_of(furnished) == [*labels, "opening", "entrance", "furniture"]
    (ax,) = draw_floor(furnished, AROUND_TWO_ROOMS).axes[1:]
    legend = ax.get_legend()
    assert legend
    assert [line.get_marker() for line in legend.get_lines()] == ["None", "D"]
    # A prediction that adds only the walls of a room is not drawn as a part of it
    for width, marks in ((4.01, ["seen in part"]), (6, ["predicted", "seen in part"])):
        partial = replace(certain[0], partial=True, predicted=box(0, 0, width, 3), confidence=0.9)
        assert legend_of(replace(plain, rooms=(partial, certain[1]), doors=())) == [*labels, *marks]


def test_the_legend_can_have_any_label(ax):
    unusual = "$x_{$" + " \n" + "_" * 50
    plot_legend(Floor((Room(1, box(0, 0, 1, 1), unusual),)), ax=ax)
    legend = ax.get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["1 × $x_{$ " + "_" * 23 + "… (1)"]
    ax.get_figure().savefig(BytesIO(), format="png")


@pytest.mark.slow
@pytest.mark.parametrize("size", [(30, 10), (20, 20), (10, 30), (2, 90)])
@pytest.mark.parametrize("count", [1, 60])
def test_the_legend_stands_beside_the_building_and_inside_the_picture(size, count):
    width, height = size
    rooms = [
        Room(i + 1, box(0, i * height / count, width, (i + 1) * height / count), f"ROOM {i}") for i in range(count)
    ]
    figure = draw_floor(Floor(tuple(rooms)), GridMap(np.zeros((1, 1), np.int8), 0.05))
    building, strip = figure.axes
    strip_legend = strip.get_legend()
    assert strip_legend
    legend = strip_legend.get_window_extent()
    extent = building.get_window_extent()
    assert max(extent.width, extent.height) == pytest.approx(1600)
    assert not extent.overlaps(legend.padded(-1))
    assert figure.bbox.containsx(legend.x0)
    assert figure.bbox.containsx(legend.x1)
    assert figure.bbox.containsy(legend.y0)
    assert figure.bbox.containsy(legend.y1)


@pytest.mark.slow
@given(st.floats(1e-4, 1e6))
def test_scale_bar_is_a_round_length_that_fits(width):
    ax = Figure().add_axes((0, 0, 1, 1), xlim=(7, 7 + width), ylim=(0, width))
    plot_scale_bar(ax=ax)
    (text,) = ax.texts
    number, unit = text.get_text().split()
    assert unit == "m"
    assert f"{float(number):e}"[0] in "125"
    assert width / 10 <= float(number) <= width / 4
    assert np.ptp(ax.lines[0].get_xydata(), axis=0) == pytest.approx([float(number), 0])


def test_walls_and_graph_are_drawn_on_request_only():
    artists = [
        len(draw_floor(TWO_ROOMS, AROUND_TWO_ROOMS, walls=walls, graph=graph).axes[0].get_children())
        for walls, graph in ((False, False), (True, False), (False, True))
    ]
    assert np.diff(artists[:2]) == [2]
    assert artists[2] - artists[0] == 3


@pytest.mark.slow
@pytest.mark.parametrize("glass_spray", [False, True])
@pytest.mark.parametrize("yaw", [0, 0.5])
def test_picture_is_cropped_to_the_building_with_little_of_the_ray_leaks(glass_spray, yaw):
    floor = make_floor("ring", seed=0)
    ax = draw_floor(floor, simulate_map(floor, margin=40, glass_spray=glass_spray, yaw=yaw)).axes[0]
    view = box(ax.get_xlim()[0], ax.get_ylim()[0], ax.get_xlim()[1], ax.get_ylim()[1])
    building = unary_union([room.polygon for room in floor.rooms])
    assert view.contains(building.buffer(0.5))
    assert view.area < (1.4 if glass_spray else 1.2) * building.envelope.area


def test_free_cells_in_no_room_stay_in_the_picture():
    cells = np.full((100, 200), UNKNOWN, np.int8)
    cells[20:80, 100:180] = FREE
    figure = draw_floor(Floor((Room(1, box(0, 0, 2, 3)),)), GridMap(cells, 0.05))
    left, right = figure.axes[0].get_xlim()
    assert left < 0
    assert right > 8.9


@pytest.mark.slow
@pytest.mark.parametrize("cell", [UNKNOWN, FREE, OCCUPIED])
@pytest.mark.parametrize("resolution", [1e-6, 0.05, 1e5])
def test_a_floor_without_rooms_is_a_picture_of_the_map(cell, resolution):
    (ax,) = draw_floor(Floor(()), GridMap(np.array([[cell]], np.int8), resolution), walls=True, graph=True).axes
    grey = {UNKNOWN: UNKNOWN_GREY, FREE: FREE_GREY, OCCUPIED: OCCUPIED_GREY}[cell]
    assert color_at(ax, resolution / 2, resolution / 2) == (grey,) * 3


@pytest.mark.slow
@pytest.mark.parametrize("size", [(1, 1), (300, 1), (1, 300), (30, 20)])
def test_the_long_side_has_1600_pixels_and_the_short_one_a_quarter_at_least(tmp_path, size):
    floor = Floor((Room(1, box(0, 0, *size)),))
    save_figure(draw_floor(floor, GridMap(np.zeros((1, 1), np.int8), 0.05)), tmp_path / "picture.png")
    with Image.open(tmp_path / "picture.png") as picture:
        short, long = sorted(picture.size)
        assert 1599 <= long <= 1600
        assert short >= 400
        assert picture.info.keys() <= {"dpi"}


@pytest.mark.slow
@pytest.mark.parametrize("floor", [TWO_ROOMS, LABELLED])
def test_the_same_floor_gives_the_same_bytes(tmp_path, floor):
    for name in ("one.png", "two.png"):
        save_figure(draw_floor(floor, AROUND_TWO_ROOMS, walls=True, graph=True), tmp_path / name)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()


def test_a_picture_that_cannot_be_written_leaves_nothing(tmp_path, monkeypatch):
    def fail(path: Path, content: bytes) -> None:
        with path.open("wb") as file:
            file.write(content[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", fail)
    fault = r"^cannot write .*picture\.png': No space left on device; free space where the output goes$"
    with pytest.raises(PiantaError, match=fault):
        save_figure(draw_floor(TWO_ROOMS, AROUND_TWO_ROOMS), tmp_path / "picture.png")
    assert not list(tmp_path.iterdir())
