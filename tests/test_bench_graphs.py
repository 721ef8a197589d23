"""`pianta bench graphs`: Table 5.1 on generated buildings, and against networkx on real ones."""

import json
from math import sqrt
from pathlib import Path
from statistics import fmean, stdev

import networkx as nx
import numpy as np
import pytest

from pianta.errors import BuildingWarning, DataError
from pianta.graphs.centrality import drop_isolated
from pianta.graphs.metrics import measure_graph
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta_bench.graphs.figures import save_figures
from pianta_bench.graphs.measure import measure
from pianta_bench.graphs.tables import LABELS, tabulate
from pianta_bench.harness.records import Results
from pianta_bench.harness.tables import Cell, read_published
from tests.command_line import list_files, run_pianta

SPACE = (
    '<space id="{id}"><labels><label>{label}</label></labels><bounding_polygon>'
    '<point x="{x0}" y="{y0}"/><point x="{x1}" y="{y0}"/><point x="{x1}" y="{y1}"/><point x="{x0}" y="{y1}"/>'
    "</bounding_polygon><space_representation>{segments}</space_representation><portals>{portals}</portals></space>"
)
SEGMENT = '<linesegment id="d{0}"><point x="{1}" y="10"/><point x="{1}" y="10"/><class>PORTAL</class></linesegment>'
PORTAL = "<portal><linesegment>d{0}</linesegment><target><id>0</id><id>{0}</id></target></portal>"


def write_comb(path: Path, *labels: str, corridor: str = "CORRIDOR", building_type: str = "SCHOOL") -> None:
    """A corridor along rooms with these labels, a door to each, and a store room without a door."""
    count = len(labels)
    doors = [(number, 20 * number - 10) for number in range(1, count + 1)]
    spaces = SPACE.format(
        id=0,
        label=corridor,
        x0=0,
        y0=0,
        x1=20 * count,
        y1=10,
        segments="".join(SEGMENT.format(*door) for door in doors),
        portals="".join(PORTAL.format(number) for number, _ in doors),
    )
    for (number, middle), label in zip(doors, labels, strict=True):
        corners = {"x0": middle - 10, "y0": 10, "x1": middle + 10, "y1": 40}
        segment, portal = SEGMENT.format(number, middle), PORTAL.format(number)
        spaces += SPACE.format(id=number, label=label, **corners, segments=segment, portals=portal)
    corners = {"x0": 0, "y0": 60, "x1": 20, "y1": 80}
    spaces += SPACE.format(id=count + 1, label="SMALL SERVICE", **corners, segments="", portals="")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        "<building><scale><represented_distance><value>9</value><um>pixel</um></represented_distance><real_distance>"
        f"<value>90</value><um>cm</um></real_distance></scale><building_type><main_type>{building_type}</main_type>"
        f"</building_type><floor><spaces>{spaces}</spaces></floor></building>"
    )


@pytest.fixture
def combs(tmp_path: Path) -> Path:
    """Schools with 3 and 6 rooms at a corridor, and an office with 2 in an open space, beside isolated rooms."""
    folder = tmp_path / "data" / "buildings"
    write_comb(folder / "school" / "a.xml", *["CLASSROOM"] * 3)
    write_comb(folder / "school" / "b.xml", *["CLASSROOM"] * 4, "STAIRS", "ENTRANCE")
    write_comb(folder / "office" / "c.xml", *["OFFICE"] * 2, corridor="OPENSPACE", building_type="OFFICE")
    return tmp_path / "data"


def figures_of(results: Results, item: str) -> dict[str, float | None]:
    return {record["metric"]: record["value"] for record in results.select(item=item)}


def test_table_5_1_of_combs(combs: Path) -> None:
    results = measure(combs)
    (table,) = tabulate(results)
    assert table.columns == ("schools", "offices")
    assert tuple(table.rows) == tuple(LABELS.values())
    cells = {name: [cells[column] for column in table.columns] for name, cells in table.rows.items()}
    # 4 and 7 rooms without the isolated ones; the entrance of the second is a corridor, its stairs are not.
    assert cells["nodes"] == [Cell(5.5, sqrt(4.5), 35.24, 18.33, 2, 2), Cell(3, None, 45.15, 16.22, 1, 2)]
    assert [cell.mean for cell in cells["nodes R"]] == [4, 2]
    assert [cell.mean for cell in cells["nodes C"]] == [1.5, 1]
    assert [cell.mean for cell in cells["edges"]] == [4.5, 2]
    assert [cell.mean for cell in cells["betw-cen C"]] == pytest.approx([(0.5 + 0.25) / 2, 0.5])
    assert cells["sum of 2^-d"][1].mean == pytest.approx((0.75 + 1 + 0.75) / 3)
    assert [item.item for item in results.items if item.part == "schools"] == ["a", "b"]
    assert figures_of(results, "a")["diameter"] == 2


def test_command(combs: Path, tmp_path: Path) -> None:
    write_comb(combs / "buildings" / "school" / "unknown.xml", "CLASSROOM", "DUNGEON")
    json_file, pictures = tmp_path / "new" / "figures.json", tmp_path / "pictures"
    outcome = run_pianta("bench", "graphs", "--data", combs, "--json", json_file, "--pictures", pictures)
    assert (outcome.code, outcome.err) == (1, "")
    assert "unknown failed (schools): " in outcome.out
    assert "DUNGEON" in outcome.out
    assert "Buildings: schools 2 (thesis 50), offices 1 (thesis 20)." in outcome.out
    row = next(line for line in outcome.out.splitlines() if line.startswith("nodes R"))
    assert " ".join(row.split()) == "nodes R 4.00 ± 1.41 27.84 ± 15.05 2.00 34.25 ± 12.94"
    content = json.loads(json_file.read_text())
    nodes = {record["item"]: record["value"] for record in content["records"] if record["metric"] == "nodes"}
    assert nodes == {"a": 4, "b": 7, "c": 3}
    assert [item["item"] for item in content["items"] if item["failure"]] == ["unknown"]
    assert list(list_files(pictures)) == ["graphs.png"]
    (combs / "buildings" / "school" / "unknown.xml").unlink()
    assert run_pianta("bench", "graphs", "--data", combs).code == 0


@pytest.mark.slow
def test_the_picture_is_the_same_each_time(combs: Path, tmp_path: Path) -> None:
    files = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        save_figures(measure(combs), tmp_path / name)
        files.append((tmp_path / name / "graphs.png").read_bytes())
    assert files[0] == files[1]


def test_without_offices(combs: Path) -> None:
    (combs / "buildings" / "office" / "c.xml").unlink()
    with pytest.raises(DataError, match=r"\boffice\b"):
        measure(combs)


def load_csv(path: Path) -> tuple[nx.Graph, set[int]]:
    """The graph of a building from its matrix in the data, without isolated rooms, and its corridors."""
    matrix = np.loadtxt(path, delimiter=",", dtype=int, ndmin=2)
    codes = np.diag(matrix)
    graph = nx.Graph(matrix - np.diag(codes))
    graph.remove_nodes_from(list(nx.isolates(graph)))
    return graph, {node for node in graph if codes[node] >= 100}


def list_csvs(data: Path) -> list[tuple[str, str]]:
    return [
        (building_type, path.stem)
        for building_type in ("school", "office")
        for path in (data / "adjacency" / building_type).glob("*.csv")
    ]


@pytest.mark.slow
@pytest.mark.filterwarnings(f"ignore::{BuildingWarning.__module__}.{BuildingWarning.__name__}")
def test_the_matrices_are_the_graphs_of_the_layouts(data: Path) -> None:
    compared = 0
    results = measure(data)
    for building_type, name in list_csvs(data):
        layout = data / "buildings" / building_type / f"{name}.xml"
        if not layout.exists():
            continue
        graph, corridors = load_csv(data / "adjacency" / building_type / f"{name}.csv")
        layout_graph = drop_isolated(read_building_xml(layout).graph())
        assert nx.faster_could_be_isomorphic(graph, layout_graph), name
        measured = measure_graph(graph, corridors)
        assert measured == pytest.approx({key: figures_of(results, name)[key] for key in measured}), name
        compared += 1
    assert compared > 40


@pytest.mark.slow
def test_each_row_equals_that_of_networkx(data: Path) -> None:
    """Table 5.1 once more, from the matrices, by networkx alone."""
    results = measure(data)
    (table,) = tabulate(results)
    assert not results.failed
    layouts = {item.item for item in results.items}
    for building_type in ("school", "office"):
        graphs = [
            load_csv(data / "adjacency" / building_type / f"{name}.csv")
            for folder, name in list_csvs(data)
            if folder == building_type and name in layouts
        ]
        measured = [measure_by_networkx(*graph) for graph in graphs]
        for name, cells in table.rows.items():
            if name in measured[0]:
                figures = [building[name] for building in measured if building[name] is not None]
                cell = cells[f"{building_type}s"]
                assert (cell.mean, cell.sd) == pytest.approx((fmean(figures), stdev(figures)), abs=1e-5), name
    published = {record["metric"] for record in read_published("table_5_1.csv")}
    assert set(measured[0]) == {LABELS[metric] for metric in published} | {"edges"}


def measure_by_networkx(graph: nx.Graph, corridors: set[int]) -> dict[str, float]:
    parts = [graph.subgraph(nodes) for nodes in nx.connected_components(graph)]
    lengths = [length for _, ends in nx.all_pairs_shortest_path_length(graph) for length in ends.values() if length]
    measured = {
        "nodes": len(graph),
        "nodes R": len(graph) - len(corridors),
        "nodes C": len(corridors),
        "edges": graph.size(),
        "path-length": fmean(lengths),
        "diameter": max(map(nx.diameter, parts)),
        "art-points": len(list(nx.articulation_points(graph))),
        "assortativity": nx.degree_assortativity_coefficient(graph),
    }
    vector = nx.eigenvector_centrality(graph, max_iter=10**5, tol=1e-9)
    most = max(vector.values())
    central = {
        "betw-cen": {node: value / 2 for node, value in nx.betweenness_centrality(graph).items()},
        "closn-cen": nx.closeness_centrality(graph),
        "eig-cen": {node: value / most for node, value in vector.items()},
        "katz-cen": nx.katz_centrality(graph, alpha=0.1, beta=1, max_iter=10**4),
    }
    for name, values in central.items():
        measured[name] = fmean(values.values())
        measured[f"{name} C"] = fmean(values[node] for node in corridors)
        measured[f"{name} R"] = fmean(values[node] for node in graph if node not in corridors)
    return measured


STRAY = SPACE.format(id=99, label="STAIRS", x0=5, x1=5, y0=0, y1=9, segments="", portals=PORTAL.format(99))


def test_a_building_with_a_stray_room_counts_without_it(tmp_path):
    """As in a drawing in which a click left a room of two points behind."""
    for building_type in ("school", "office"):
        write_comb(tmp_path / "buildings" / building_type / "a.xml", "CLOSET", "CLOSET")
    path = tmp_path / "buildings" / "school" / "a.xml"
    expected = measure(tmp_path)
    path.write_text(path.read_text().replace("</spaces>", f"{STRAY}</spaces>"))
    results = measure(tmp_path)
    assert results.records == expected.records
    assert [item.failure for item in results.items] == [None, None]
    assert (
        "is read without some of its rooms: room 5 (STAIRS) has an outline without area" in results.items[0].warnings[0]
    )
