"""`pianta bench generation`: on tiny schools, whose models forget where they started after a few moves."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from io import StringIO
from math import inf
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from matplotlib.axes import Axes
from rich.console import Console

from pianta.errors import DataError, OptionError
from pianta.evaluation.graph_sets import STATISTICS, DiscrepancyRatio, Trial
from pianta.generation.buildings import generate_buildings
from pianta.generation.functional_areas import Segmentation
from pianta.generation.type_model import Mixing, ModelMixing, TypeModel, learn_type
from pianta.labels import SCHOOL, LabelSchema
from pianta_bench.generation import measure as generation
from pianta_bench.generation import tables as generation_tables
from pianta_bench.generation.clusters import score_gram
from pianta_bench.generation.costs import STEPS, Clock, time_sampling
from pianta_bench.generation.figures import draw_areas, draw_buildings, draw_clusters, place_in_plane
from pianta_bench.generation.file import save_generation
from pianta_bench.generation.measure import (
    CORR,
    METRICS,
    NCUT,
    PRINTED_COSTS,
    REAL,
    SAMPLED,
    THESIS,
    GenerationBench,
    measure_generation,
    read_real,
    read_samples,
)
from pianta_bench.generation.scores import (
    CLASSIFIERS,
    Effort,
    draw_halves,
    measure_ratio_error,
    pool_ratios,
    score_halves,
    score_held_out,
)
from pianta_bench.generation.tables import (
    PRINTED_MADE,
    compare_figures,
    compare_metrics,
    tabulate_clusters,
    tabulate_costs,
    tabulate_gaps,
    tabulate_generation,
    tabulate_held_out,
    tabulate_mixing,
    tabulate_scores,
)
from pianta_bench.harness.comparison import ComparisonTable, show_comparisons
from tests.command_line import list_files, run_pianta
from tests.tiny_data import write_schools

pytestmark = pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")

SCHOOLS = "KKKW-KKC-LLW", "KKKC-KKW", "LLW-KKKK-KKS", "KKKW-LLS-KKC", "KKC-KKKK", "LLC-KKKW-KKK"
EFFORT = Effort(trials=3, draws=1, forest_draws=1, trees=3, models=2, made=2, subsamples=3)
MIXING = ModelMixing(Mixing(5, 1.0), Mixing(20, inf), Mixing(5, 1.25))
PARTS = [REAL, CORR, NCUT, PRINTED_COSTS, THESIS]


def train_quickly(graphs: Sequence[nx.Graph], *, schema: LabelSchema, areas: Segmentation, seed: int) -> TypeModel:
    """A stand-in for `train_type`, whose search for enough iterations takes most of the time."""
    model = learn_type(graphs, schema, segmentation=areas)
    return replace(model, sweeps=5, edge_moves=20, door_moves=5, mixing=MIXING)


def write_samples(data: Path, graphs: Sequence[nx.Graph]) -> None:
    """data/sampled/corr_table7_1.json with these graphs."""
    content = {
        "building_type": "SCHOOL",
        "source": "test",
        "graphs": [
            {
                "id": f"sample{number}",
                "nodes": [{"id": node, "label": label} for node, label in graph.nodes(data="label")],
                "edges": [*map(list, graph.edges)],
            }
            for number, graph in enumerate(graphs)
        ],
    }
    (data / SAMPLED).parent.mkdir()
    (data / SAMPLED).write_text(json.dumps(content))


@pytest.fixture(autouse=True, scope="module")
def quick() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(generation, "train_type", train_quickly)
        yield


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six schools, one that cannot be read, one in two parts, and eight samples."""
    data = tmp_path_factory.mktemp("data")
    write_schools(data, *SCHOOLS)
    graphs = read_real(data).graphs
    write_samples(data, [*graphs, *graphs[:2]])
    (data / "buildings" / "school" / "strange.xml").write_text("<building/>")
    return data


@pytest.fixture(scope="module")
def measured(tiny) -> GenerationBench:
    return measure_generation(tiny, count=8, effort=EFFORT)


def cells_of(table: ComparisonTable) -> dict[str, list[float | None]]:
    return {row.name: [cell.mean for cell in row.cells] for row in table.rows}


def test_nearer_than_the_thesis():
    """Means of 2 and 4 beside printed ones that are 5.33 apart; of 0 and 6 the gap is larger."""
    printed = 35.24, 40.57
    gap = compare_figures("nodes", [1, 2, 3], [3, 4, 5], printed)
    assert (gap.gap, gap.printed_gap, gap.is_nearer) == (2, 5.33, True)
    assert not compare_figures("nodes", [0, 0], [6, 6], printed).is_nearer
    assert not compare_figures("nodes", [0, 0], [-6, -6], printed).is_nearer
    # Where print has the same means nothing is nearer, not even the same mean.
    assert not compare_figures("betweenness_r", [1, 1], [1, 1], (0.005, 0.005)).is_nearer
    nothing = compare_figures("katz", [], [1], printed)
    assert (nothing.gap, nothing.p_value, nothing.is_nearer, nothing.is_alike) == (None, None, False, False)


def test_kolmogorov_smirnov():
    """Of all ways to order two sets of n, two leave them apart: 2 of 20 for n = 3, 2 of 70 for n = 4."""
    few, many = (compare_figures("nodes", range(count), range(10, 10 + count), (0.0, 1.0)) for count in (3, 4))
    assert few.is_alike
    assert few.p_value == pytest.approx(0.1)
    assert not many.is_alike
    assert many.p_value == pytest.approx(2 / 70)


@pytest.mark.slow
def test_counts_of_rows(measured, monkeypatch):
    far = ((1e6, 1.0), (1e6, 1.0))
    monkeypatch.setattr(generation_tables, "PRINTED_MADE", {**PRINTED_MADE, "nodes": far, "katz_c": far})
    gaps = {gap.key: gap for gap in compare_metrics(measured, THESIS)}
    assert list(gaps) == list(METRICS)
    assert gaps["nodes"].is_nearer
    table = tabulate_gaps(measured)
    nearer, alike = table.rows
    assert [cell.mean for cell in nearer.cells] == [
        sum(gap.is_nearer for gap in compare_metrics(measured, part)) for part in PARTS[1:]
    ]
    # The samples are the real ones, two of them twice.
    assert alike.cells[-1].mean == 19
    assert "thesis' own, p too small: none." in table.notes
    assert any("corr, not nearer: " in note and "betw-cen R" in note for note in table.notes)


def test_similarity_of_clusters():
    """Areas 0, 1 and 2, 3 are clusters, 4 is alone; 2 and 3 are less alike to each other than 3 to 4."""
    gram = np.array(
        [
            [1.0, 0.8, 0.1, 0.2, 0.0],
            [0.8, 1.0, 0.3, 0.2, 0.1],
            [0.1, 0.3, 1.0, 0.5, 0.3],
            [0.2, 0.2, 0.5, 1.0, 0.9],
            [0.0, 0.1, 0.3, 0.9, 1.0],
        ]
    )
    found = score_gram(gram, np.array([0, 0, 1, 1, 2]))
    assert found.sizes.tolist() == [2, 2, 1]
    assert found.intra == pytest.approx([0.8, 0.5, np.nan], nan_ok=True)
    assert found.inter == pytest.approx([0.9 / 6, (0.8 + 1.2) / 6, 1.3 / 4])
    assert found.similarity[0] == pytest.approx([0.9, 0.2, 0.05])
    # To all others cluster 1 is less alike than to itself, to cluster 2 alone more.
    assert (found.loose, found.mixed) == (0, 1)
    # 2 and 4 are 0.3 alike, and 1.9 / 6 to the others on average, which are 1.2 / 3 among themselves.
    assert score_gram(gram, np.array([0, 0, 1, 0, 1])).loose == 1
    assert np.isnan(score_gram(gram, np.zeros(5, int)).inter).all()


def test_halves():
    real = [nx.path_graph(2 + number) for number in range(9)]
    asked = []

    def make(half, random):
        asked.append(half)
        return [nx.path_graph(50)] * 7

    halves = draw_halves(make, real, models=3, seed=0)
    assert [half for _, half, _ in halves] == asked
    assert all(len(made) == 7 and len(a) == len(b) == 4 for made, a, b in halves)
    assert all(not {map(id, a)} & {map(id, b)} for _, a, b in halves)


def test_held_out_scores():
    """What a model makes is either half A again, or graphs of another kind."""

    def label(graph: nx.Graph, name: str) -> nx.Graph:
        nx.set_node_attributes(graph, name, "label")
        return graph

    paths = [label(nx.path_graph(3 + number), "CLASSROOM") for number in range(8)]
    cycles = [label(nx.cycle_graph(3 + number), "CORRIDOR") for number in range(8)]
    same, other = (
        score_held_out([Trial(made, paths[::2], paths[1::2])], SCHOOL, seed=0, effort=EFFORT)
        for made in (paths[::2], cycles)
    )
    assert {name: ratios[0].ratio for name, ratios in same.discrepancies.items()} == dict.fromkeys(STATISTICS, 1)
    assert min(other.discrepancies[name][0].ratio for name in ("degree", "labels")) > 10
    assert [*other.told] == [*CLASSIFIERS]
    assert [shares[0] for shares in other.told.values()] == [1, 1, 1]


def test_ratios_are_pooled():
    """A split whose halves are alike by chance has a large ratio of its own, and little weight."""
    ratios = [DiscrepancyRatio(0.3, 0.1), DiscrepancyRatio(0.2, 0.0), DiscrepancyRatio(0.1, 0.2)]
    assert pool_ratios(ratios).ratio == pytest.approx(2)
    # Without one of them: 3 / 2, 4 / 3, 5 / 1.
    left_out = [1.5, 4 / 3, 5.0]
    mean = sum(left_out) / 3
    error = sum(2 / 3 * (ratio - mean) ** 2 for ratio in left_out) ** 0.5
    assert measure_ratio_error(ratios) == pytest.approx(error)
    assert measure_ratio_error(ratios[:1]) is None
    assert measure_ratio_error(ratios[:2]) is None


def test_all_parts(measured):
    assert [*measured.sets] == [REAL, CORR, NCUT, PRINTED_COSTS, THESIS]
    assert [*measured.scores] == PARTS[1:]
    assert [len(measured.sets[part].graphs) for part in PARTS] == [6, 8, 8, 8, 8]
    assert {key for row in measured.sets[CORR].rows for key in row.figures} == {*METRICS}
    # Corridors without rooms around them are rooms of the type all the same.
    assert measured.sets[REAL].list_figures("nodes_c") == [3, 2, 3, 3, 2, 3]
    assert [row.item for row in measured.sets[REAL].rows if row.failure] == ["strange"]
    # All samples are real schools, the last two are there already.
    assert (measured.scores[THESIS].novel, measured.scores[THESIS].unique) == (0, 0.75)
    assert measured.scores[THESIS].validity.connected == 1
    for judged in measured.models.values():
        assert len(judged.halves) == 2
        assert all(len(made) == 6 and len(a) == len(b) == 3 for made, a, b in judged.halves)
        assert all(len(judged.held_out.told[name]) == 2 for name in CLASSIFIERS)


@pytest.mark.slow
def test_timed_buildings_are_those_of_generate_buildings(measured, monkeypatch):
    monkeypatch.setattr(
        "pianta_bench.generation.costs.split_batches", lambda count, _: [range(3), range(3, 6), range(6, count)]
    )
    for part in (CORR, NCUT):
        model = measured.models[part].model
        made, costs = time_sampling(model, 8, seed=0)
        for graph, timed, kept in zip(generate_buildings(model, 8), made, measured.sets[part].graphs, strict=True):
            assert nx.utils.graphs_equal(graph, timed)
            assert [*kept.edges] == [*timed.edges]
        assert [*costs.steps] == [*costs.iterations] == [*STEPS]
        assert costs.batch == 3
        assert sum(costs.steps.values()) < costs.total


def test_clock():
    clock = Clock()
    assert clock.list_seconds() == []
    clock.times = [1.0, 1.5, 3.5]
    assert clock.list_seconds() == [0.5, 2.0]
    clock.append(np.zeros(1))
    assert len(clock.times) == 4


def test_tables(measured):
    clusters = cells_of(tabulate_clusters(measured))
    assert clusters["functional areas"][0] == 16
    assert clusters["clusters of one area"] == [sum(judged.clusters.sizes == 1) for judged in measured.models.values()]
    assert clusters["clusters by WL"] == [judged.clusters_by_wl for judged in measured.models.values()]
    (by_wl,) = (row for row in tabulate_clusters(measured).rows if row.name == "clusters by WL")
    assert [cell.printed_mean for cell in by_wl.cells] == [27, None]
    scores = cells_of(tabulate_scores(measured))
    assert scores["novel, % (≥ 95)"][-1] == 0
    assert scores["unique, % (≥ 95)"][-1] == 75
    told = measured.scores[CORR].told["WL SVM"]
    assert scores["WL SVM, pair out, % (≤ 55)"][0] == 100 * told.pair_out[0]
    assert scores["WL SVM, one out, % (≤ 55)"][0] == 100 * told.one_out[0]
    held_out = cells_of(tabulate_held_out(measured))
    shares = measured.real_halves.told["NSPDK SVM"]
    assert held_out["NSPDK SVM, pair out, % (≤ 55)"][-1] == pytest.approx(100 * sum(shares) / 2)
    costs = measured.models[NCUT].sampling
    told_costs = cells_of(tabulate_costs(measured))
    proposal = costs.iterations["step 4"]
    assert proposal is not None
    assert told_costs["proposal of step 4 / row of floors"][1] == pytest.approx(proposal / costs.full_row)
    assert told_costs["proposal of step 4 / row, 8 at once"][1] == pytest.approx(proposal / costs.batch_row)
    proposal = costs.iterations["step 2"]
    assert proposal is not None
    functional = told_costs["proposal of step 2 / functional row, 8 at once"]
    assert functional[1] == pytest.approx(proposal / costs.functional_batch_row)
    mixing = cells_of(tabulate_mixing(measured))
    assert mixing["step 2: moves"] == [20, 20]
    assert mixing["step 2: R̂"] == [None, None]
    assert mixing["step 4: R̂"] == [1.25, 1.25]


def test_half_a_by_heart_is_no_nearer_than_half_a():
    graphs = [nx.path_graph(size) for size in range(3, 11)]
    for number, graph in enumerate(graphs):
        nx.set_node_attributes(graph, ("CLASSROOM", "CORRIDOR")[number % 2], "label")
    scores = score_halves([Trial([], graphs[::2], graphs[1::2])], SCHOOL, seed=0, effort=Effort(draws=1, trees=5))
    assert scores.discrepancies.keys() == set(STATISTICS)
    # All graphs of half A have another number of nodes; drawn again, some are missing and some are there twice.
    (of_degrees,) = scores.discrepancies["degree"]
    assert of_degrees.ratio > 1
    assert {len(shares) for shares in scores.told.values()} == {1}


def show(bench: GenerationBench, *, width: int) -> str:
    """What a terminal of a width shows."""
    console = Console(file=StringIO(), width=width)
    console.print(show_comparisons(tabulate_generation(bench), bench.items))
    assert isinstance(console.file, StringIO)
    return console.file.getvalue()


def test_nothing_is_cut_in_80_columns(measured):
    told = show(measured, width=80)
    assert "…" not in told
    assert "Extra-Trees, pair out, % (≤ 55)" in told
    notes = [note for table in tabulate_generation(measured) for note in table.notes]
    assert [note for note in notes if len(note) > 80 and "nearer: " not in note] == []


@pytest.mark.slow
def test_without_the_samples_of_the_thesis(tmp_path):
    write_schools(tmp_path, *SCHOOLS)
    bench = measure_generation(tmp_path, count=6, effort=EFFORT)
    assert [*bench.sets] == PARTS[:-1]
    told = show(bench, width=80)
    assert "The thesis' own samples are not in the data and have no column." in told
    assert "thesis' own, " not in told


@pytest.mark.slow
def test_the_same_seed_gives_the_same_figures(tiny, measured, tmp_path):
    benches = measured, measure_generation(tiny, count=8, effort=EFFORT)
    contents = []
    for place, bench in enumerate(benches):
        save_generation(bench, tmp_path / f"{place}.json")
        content = json.loads((tmp_path / f"{place}.json").read_text())
        for model in content["models"].values():
            for timed in ("sampling", "training_seconds", "learning_seconds"):
                del model[timed]
        content["tables"] = [
            table for table in content["tables"] if not table["title"].startswith(("Table 7.2", "Time on this machine"))
        ]
        contents.append(content)
    assert contents[0] == contents[1]
    assert len(contents[0]["tables"]) == 7


def test_what_cannot_be_measured(tmp_path):
    with pytest.raises(DataError, match="school"):
        measure_generation(tmp_path)
    write_schools(tmp_path, *SCHOOLS[:3])
    with pytest.raises(DataError, match="schools"):
        measure_generation(tmp_path)
    graphs = read_real(tmp_path).graphs
    write_samples(tmp_path, graphs)
    with pytest.raises(DataError, match=r"corr_table7_1\.json"):
        read_samples(tmp_path, 4)
    samples = read_samples(tmp_path, 3)
    assert samples is not None
    assert [row.item for row in samples.rows] == ["sample0", "sample1", "sample2"]


def test_too_few_buildings(tiny):
    with pytest.raises(OptionError, match="buildings"):
        measure_generation(tiny, count=5)


def list_counts(ax: Axes) -> list[int]:
    """How many marks of each kind there are."""
    return [np.shape(marks.get_offsets())[0] for marks in ax.collections]


@pytest.mark.slow
def test_pictures(measured):
    found = {part: judged.clusters for part, judged in measured.models.items()}
    heatmaps, areas, buildings = draw_clusters(found), draw_areas(found, seed=0), draw_buildings(measured)
    counts = [len(clusters.sizes) for clusters in found.values()]
    assert [np.asarray(ax.get_images()[0].get_array()).shape for ax in heatmaps.axes[:2]] == [
        (count, count) for count in counts
    ]
    for ax, clusters in zip(areas.axes, found.values(), strict=True):
        assert list_counts(ax) == clusters.sizes.tolist()
    assert [list_counts(ax) for ax in buildings.axes] == [[8, 6], [8, 6]]


def test_places_of_groups_are_apart():
    gram = np.kron(np.eye(2), np.random.default_rng(0).uniform(0.5, 0.9, (8, 8)))
    gram = (gram + gram.T) / 2
    xy = place_in_plane(gram, perplexity=20, seed=0)
    assert (xy.min(), xy.max()) == (0, 1)
    middles = xy[:8].mean(axis=0), xy[8:].mean(axis=0)
    assert np.linalg.norm(middles[0] - middles[1]) > 2 * np.linalg.norm(xy[:8] - middles[0], axis=1).mean()


def test_command(tiny, tmp_path, monkeypatch):
    monkeypatch.setattr(generation, "EFFORT", EFFORT)
    file, pictures = tmp_path / "new" / "generation.json", tmp_path / "pictures"
    arguments = "--data", tiny, "-n", 7, "--seed", 3, "--json", file, "--pictures", pictures
    outcome = run_pianta("bench", "generation", *arguments)
    assert (outcome.code, outcome.err) == (1, "")
    assert "Table 7.1, metrics of schools: real, and generated by corr" in outcome.out
    assert "strange failed (real), not counted: " in outcome.out
    names = {"heatmap.png", "areas.png", "buildings.png", "real.png", "corr.png", "ncut.png"}
    assert {*list_files(pictures)} == names
    content = json.loads(file.read_text())
    assert (content["bench"], content["seed"], content["count"]) == ("generation", 3, 7)
    parts = [item["part"] for item in content["items"]]
    assert [parts.count(part) for part in PARTS] == [7, 7, 7, 7, 8]
    assert {*content["items"][0]["figures"]} == {*METRICS}
    assert {*content["scores"]} == {*content["gaps"]} == {*PARTS[1:]}
    assert {*content["gaps"][CORR][0]} == {"key", "gap", "printed_gap", "p_value", "nearer", "alike"}
    model = content["models"][CORR]
    assert len(model["areas"]) == 16
    assert sum(cluster["areas"] for cluster in model["clusters"]) == 16
    assert len(model["held_out"]["discrepancies"]["degree"]) == 2


def test_an_option_without_meaning(tiny):
    outcome = run_pianta("bench", "generation", "--data", tiny, "-n", 2)
    assert (outcome.code, outcome.out) == (2, "")
    (line,) = outcome.err.splitlines()
    assert line.startswith("error: 2 buildings")


@pytest.mark.slow
def test_the_samples_of_the_thesis_have_the_printed_metrics(data):
    real = read_real(data)
    if not (data / SAMPLED).exists():
        pytest.skip(f"no {SAMPLED} in {data}")
    samples = read_samples(data, len(real.graphs))
    assert samples is not None
    assert not any(row.failure for row in (*real.rows, *samples.rows))
    for key in METRICS[:6]:
        assert np.mean(samples.list_figures(key)) == pytest.approx(PRINTED_MADE[key][0][0], rel=0.04)
