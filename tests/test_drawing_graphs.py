"""Pictures of buildings as graphs: marks, colours, and sheets."""

import os
import subprocess
import sys
from collections import Counter
from itertools import combinations
from math import dist

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from PIL import Image

from pianta.errors import OptionError, PiantaError
from pianta.graphs.centrality import drop_isolated
from pianta.graphs.metrics import find_corridors
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.labels import OFFICE, SCHOOL
from pianta.plot.figure import save_figure
from pianta.plot.graphs import (
    MAX_SHEET,
    RADIUS,
    SPINE,
    THICK_OUTLINE,
    draw_contact_sheet,
    place_nodes,
    plot_room_graph,
)
from pianta.plot.styles import RoomStyle


def building(edges, **labels: str | None) -> nx.Graph:
    graph = nx.Graph(edges)
    graph.add_nodes_from((node, {"label": label}) for node, label in labels.items())
    return graph


# Two corridors and rooms; one room has a label that no schema has, and one has no label.
SMALL_SCHOOL = building(
    [("a", "b"), ("a", "c"), ("a", "d"), ("b", "e"), ("b", "f"), ("a", "x"), ("b", "y")],
    a="CORRIDOR",
    b="ENTRANCE",
    c="CLASSROOM",
    d="classroom ",
    e="STAIRS",
    f="GYM",
    x="AQUARIUM",
    y=None,
)


@pytest.fixture
def ax():
    return Figure().add_axes((0, 0, 1, 1))


def count_marks(ax: Axes):
    return Counter((type(patch).__name__, to_hex(patch.get_facecolor())) for patch in ax.patches)


def fill(label: str) -> str:
    return RoomStyle(SCHOOL.by_name[label].color).fill


def legend_of(figure: Figure) -> list[str]:
    (legend,) = figure.legends
    return [text.get_text() for text in legend.get_texts()]


def texts_of(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.texts if text.get_text()]


def test_corridors_are_squares_rooms_circles_in_the_colours_of_their_labels(ax):
    assert plot_room_graph(SMALL_SCHOOL, ax=ax, schema=SCHOOL) is ax
    assert count_marks(ax) == {
        ("Rectangle", fill("CORRIDOR")): 1,
        ("Rectangle", fill("ENTRANCE")): 1,
        ("Circle", fill("CLASSROOM")): 2,
        ("Circle", fill("STAIRS")): 1,
        ("Circle", fill("GYM")): 1,
        ("Circle", "#ffffff"): 2,
    }


def test_labels_are_those_of_the_schema_that_is_given(ax):
    """An office has open spaces, which are corridors, and no classrooms."""
    graph = building([("a", "b")], a="OPENSPACE", b="CLASSROOM")
    plot_room_graph(graph, ax=ax, schema=OFFICE)
    color = RoomStyle(OFFICE.by_name["OPENSPACE"].color).fill
    assert count_marks(ax) == {("Rectangle", color): 1, ("Circle", "#ffffff"): 1}


def test_edges_join_the_middles_of_nodes_and_are_thick_between_corridors(ax):
    plot_room_graph(SMALL_SCHOOL, ax=ax, schema=SCHOOL)
    positions = place_nodes(SMALL_SCHOOL)
    (lines,) = (part for part in ax.collections if isinstance(part, LineCollection))
    ends = [tuple(map(tuple, segment)) for segment in lines.get_segments()]
    assert ends == [(positions[first], positions[second]) for first, second in SMALL_SCHOOL.edges]
    is_thick = np.equal(lines.get_linewidth(), SPINE)
    thick = [edge for edge, thick in zip(SMALL_SCHOOL.edges, is_thick, strict=True) if thick]
    assert thick == [("a", "b")]


def test_each_node_is_drawn_at_its_position_and_visible(ax):
    plot_room_graph(SMALL_SCHOOL, ax=ax, schema=SCHOOL)
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    for patch, (x, y) in zip(ax.patches, place_nodes(SMALL_SCHOOL).values(), strict=True):
        assert isinstance(patch, Circle | Rectangle)
        assert patch.get_center() == pytest.approx((x, y))
        assert left < x - RADIUS < x + RADIUS < right
        assert bottom < y - RADIUS < y + RADIUS < top


def test_fixed_rooms_have_a_thick_outline(ax):
    plot_room_graph(SMALL_SCHOOL, ax=ax, schema=SCHOOL, fixed={"a", "f"})
    thick = [
        node for node, patch in zip(SMALL_SCHOOL, ax.patches, strict=True) if patch.get_linewidth() == THICK_OUTLINE
    ]
    assert thick == ["a", "f"]


@pytest.mark.parametrize("count", [0, 1, 2, 7])
def test_graphs_without_edges_are_drawn(ax, count):
    graph: nx.Graph = nx.empty_graph(count)
    plot_room_graph(graph, ax=ax, schema=SCHOOL)
    assert len(ax.patches) == count
    assert np.isfinite([*ax.get_xlim(), *ax.get_ylim()]).all()


def test_an_edge_of_a_node_to_itself_is_not_drawn(ax):
    plot_room_graph(nx.Graph([(0, 0), (0, 1)]), ax=ax, schema=SCHOOL)
    (lines,) = ax.collections
    assert isinstance(lines, LineCollection)
    assert len(lines.get_segments()) == 1


@pytest.mark.slow
@given(st.integers(2, 40), st.floats(0, 1), st.integers(0, 1000))
@settings(max_examples=25, deadline=None)
def test_nodes_of_no_graph_overlap(count, density, seed):
    positions = place_nodes(nx.gnp_random_graph(count, density**2, seed=seed))
    assert min(dist(one, other) for one, other in combinations(positions.values(), 2)) > 2 * RADIUS


def test_rooms_lie_closest_to_their_own_corridor():
    """Two stars of six rooms, joined in their middles."""
    graph = nx.Graph([(0, 1), *((corridor, (corridor, room)) for corridor in (0, 1) for room in range(6))])
    positions = place_nodes(graph)
    for corridor, other in ((0, 1), (1, 0)):
        for room in range(6):
            position = positions[corridor, room]
            assert dist(position, positions[corridor]) < dist(position, positions[other])


def test_a_ring_of_corridors_with_rooms_has_no_crossings():
    """Each corridor lies on a convex ring, its rooms outside or inside of it but never across an edge."""
    ring = nx.cycle_graph(6)
    ring.add_edges_from((corridor, (corridor, room)) for corridor in range(6) for room in range(3))
    positions = place_nodes(ring)

    def left(a, b, c) -> bool:
        return bool((b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0]))

    for one, other in combinations(ring.edges, 2):
        if not {*one} & {*other}:
            (a, b), (c, d) = ([positions[node] for node in edge] for edge in (one, other))
            assert left(a, b, c) == left(a, b, d) or left(c, d, a) == left(c, d, b)


def test_a_long_building_is_drawn_horizontally():
    xy = np.array([*place_nodes(nx.path_graph(20)).values()])
    width, height = np.ptp(xy, axis=0)
    assert width > 2 * height


def test_parts_of_a_building_are_drawn_apart():
    """The bounding boxes of the parts do not overlap."""
    graph: nx.Graph = nx.disjoint_union_all([nx.star_graph(5), nx.cycle_graph(4), nx.empty_graph(1), nx.path_graph(3)])
    positions = place_nodes(graph)
    boxes = []
    for part in nx.connected_components(graph):
        xy = np.array([positions[node] for node in part])
        boxes.append((xy.min(axis=0) - RADIUS, xy.max(axis=0) + RADIUS))
    for (low, high), (other_low, other_high) in combinations(boxes, 2):
        assert (high < other_low).any() or (other_high < low).any()


def test_a_sheet_has_its_buildings_row_by_row():
    graphs = [SMALL_SCHOOL, nx.empty_graph(1), nx.path_graph(3)]
    figure = draw_contact_sheet(graphs, schema=SCHOOL, columns=2)
    assert [ax.get_title() for ax in figure.axes] == ["1: 8 rooms", "2: 1 room", "3: 3 rooms"]
    assert [len(ax.patches) for ax in figure.axes] == [8, 1, 3]
    first, second, third = (ax.get_position() for ax in figure.axes)
    assert first.x1 < second.x0
    assert first.y0 == pytest.approx(second.y0)
    assert first.y0 > third.y1
    assert first.x0 == pytest.approx(third.x0)
    assert texts_of(figure) == []


def test_a_sheet_has_titles_and_a_heading_as_given():
    """Dollar signs start no formula; long titles are cut."""
    figure = draw_contact_sheet([SMALL_SCHOOL] * 2, schema=SCHOOL, titles=["$1$", "a" * 31], heading="Schools")
    assert [ax.get_title() for ax in figure.axes] == ["$1$", "a" * 29 + "…"]
    assert texts_of(figure) == ["Schools"]


def test_the_legend_has_the_labels_of_all_buildings_in_the_order_of_the_schema():
    other = building([("a", "b")], a="HALL", b="LAB")
    figure = draw_contact_sheet([SMALL_SCHOOL, other], schema=SCHOOL)
    assert legend_of(figure) == [
        *("CLASSROOM", "LAB", "GYM", "CORRIDOR", "HALL", "ENTRANCE", "STAIRS"),
        "other or no label",
    ]
    (legend,) = figure.legends
    marks = [(line.get_marker(), to_hex(line.get_markerfacecolor())) for line in legend.get_lines()]
    assert marks[0] == ("o", fill("CLASSROOM"))
    assert marks[3] == ("s", fill("CORRIDOR"))
    assert marks[-1] == ("o", "#ffffff")


def test_the_legend_explains_fixed_rooms_only_if_there_are_any():
    graphs = [building([("a", "b")], a="CORRIDOR", b="LAB")] * 2
    assert legend_of(draw_contact_sheet(graphs, schema=SCHOOL, fixed=[set(), set()])) == ["LAB", "CORRIDOR"]
    figure = draw_contact_sheet(graphs, schema=SCHOOL, fixed=[set(), {"b"}])
    assert legend_of(figure) == ["LAB", "CORRIDOR", "kept"]
    widths = [[patch.get_linewidth() == THICK_OUTLINE for patch in ax.patches] for ax in figure.axes]
    assert widths == [[False, False], [False, True]]


@pytest.mark.slow
def test_the_legend_is_in_the_sheet_and_below_the_buildings():
    """All labels of a schema, in a sheet of one building and one of several."""
    graph: nx.Graph = nx.path_graph(len(SCHOOL.labels))
    nx.set_node_attributes(graph, dict(enumerate(SCHOOL.by_name)), "label")
    for count in (1, 3, 7):
        figure = draw_contact_sheet([graph] * count, schema=SCHOOL)
        figure.draw_without_rendering()
        (legend,) = figure.legends
        extent = legend.get_window_extent()
        assert legend_of(figure) == [*SCHOOL.by_name]
        assert 0 <= extent.x0 < extent.x1 <= figure.bbox.width
        assert 0 <= extent.y0 < extent.y1 <= min(ax.bbox.y0 for ax in figure.axes)


@pytest.mark.slow
@pytest.mark.parametrize(("heading", "drawn_heading"), [(None, "24 of 26"), ("Schools", "Schools: 24 of 26")])
def test_with_too_many_buildings_the_first_are_drawn_and_the_heading_is_extended(heading, drawn_heading):
    graphs = [nx.empty_graph(1)] * MAX_SHEET + [SMALL_SCHOOL] * 2
    titles = [str(number) for number in range(26)]
    figure = draw_contact_sheet(graphs, schema=SCHOOL, heading=heading, titles=titles)
    assert [ax.get_title() for ax in figure.axes] == titles[:MAX_SHEET]
    assert texts_of(figure) == [drawn_heading]
    assert legend_of(figure) == ["other or no label"]


@pytest.mark.parametrize(
    ("count", "options", "message"),
    [
        (0, {}, "there is no building to draw, give one at least"),
        (1, {"columns": 0}, "a sheet of 0 columns has no space for a building, give 1 at least"),
        (2, {"titles": ["a"]}, "there are 1 titles for 2 buildings, give one for each"),
        (1, {"fixed": []}, "there are 0 sets of fixed rooms for 1 buildings, give one for each"),
    ],
)
def test_invalid_sheets_are_refused(count, options, message):
    with pytest.raises(OptionError) as refusal:
        draw_contact_sheet([SMALL_SCHOOL] * count, schema=SCHOOL, **options)
    assert str(refusal.value) == message


WRITE = """
import sys, networkx as nx
from pianta.plot.figure import save_figure
from pianta.plot.graphs import draw_contact_sheet
from pianta.labels import SCHOOL
graph = nx.Graph([("hall", f"room {number}") for number in range(9)] + [("hall", "b"), ("b", "c"), ("c", "room 1")])
nx.set_node_attributes(graph, {"hall": "HALL", "b": "CORRIDOR", "c": "LAB", "room 1": "GYM"}, "label")
save_figure(draw_contact_sheet([graph], schema=SCHOOL), sys.argv[1])
"""


@pytest.mark.slow
def test_the_same_graphs_have_the_same_bytes_under_every_hash_seed(tmp_path):
    for seed in ("1", "2"):
        command = [sys.executable, "-c", WRITE, str(tmp_path / seed)]
        subprocess.run(command, check=True, env=os.environ | {"PYTHONHASHSEED": seed})
    assert (tmp_path / "1").read_bytes() == (tmp_path / "2").read_bytes()
    with Image.open(tmp_path / "1") as image:
        assert image.format == "PNG"
        assert not image.text  # type: ignore[attr-defined]


def test_a_sheet_that_cannot_be_written_is_an_error_in_one_line(tmp_path):
    sheet, path = draw_contact_sheet([SMALL_SCHOOL], schema=SCHOOL), tmp_path / "missing" / "sheet.png"
    with pytest.raises(PiantaError, match=r"^cannot write '.*sheet\.png': .*$"):
        save_figure(sheet, path)
    with pytest.raises(PiantaError, match="it is a folder"):
        save_figure(sheet, tmp_path)
    assert [*tmp_path.iterdir()] == []


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_no_room_of_real_schools_is_on_an_edge_of_other_rooms_and_squares_are_corridors(data, ax):
    for file in sorted((data / "buildings" / "school").glob("*.xml"))[:8]:
        graph = drop_isolated(read_building_xml(file).graph())
        positions = place_nodes(graph)
        for first, second in graph.edges:
            a, b = np.array(positions[first]), np.array(positions[second])
            for node in graph.nodes - {first, second}:
                share = np.clip((positions[node] - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
                assert dist(positions[node], a + share * (b - a)) > RADIUS
        ax.clear()
        plot_room_graph(graph, ax=ax, schema=SCHOOL)
        squares = {node for node, patch in zip(graph, ax.patches, strict=True) if isinstance(patch, Rectangle)}
        assert squares == find_corridors(graph, SCHOOL)
