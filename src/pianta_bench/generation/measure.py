"""Chapter 7: models of real schools, new ones made by them, and how much these differ from real ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from types import MappingProxyType

import networkx as nx
import numpy as np

from pianta.errors import DataError, OptionError
from pianta.generation.area_clusters import AreaKernel, compare_areas
from pianta.generation.buildings import Costs, generate_buildings
from pianta.generation.functional_areas import Segmentation
from pianta.generation.train import train_type
from pianta.generation.type_model import Mixing, TypeModel, learn_type, prepare_room_graph
from pianta.graphs.metrics import find_corridors, measure_graph
from pianta.io._files import short_repr
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.graphs import read_room_graphs
from pianta.labels import SCHOOL
from pianta_bench.data.folders import find_data, list_maps
from pianta_bench.generation import COUNT
from pianta_bench.generation.clusters import add_cluster_scores, keep_finite, score_gram
from pianta_bench.generation.costs import SECONDS, time_sampling
from pianta_bench.generation.scores import Repeats, SetScorer, draw_halves
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.harness.tables import read_published

REAL = "real"
CORR = "corr"
NCUT = "ncut"
PUBLISHED_COSTS = "as printed"
THESIS = "thesis"
REAL_HALF = "real half A"
SEGMENTATIONS = MappingProxyType({CORR: Segmentation.CORR, NCUT: Segmentation.NCUT})
SAMPLED = Path("sampled", "corr_table7_1.json")
TABLE_7_1 = "table_7_1.csv"
METRICS = tuple(dict.fromkeys(record["metric"] for record in read_published(TABLE_7_1)))
REPEATS = Repeats()
MIN_FLOORS = 4  # each half of the real floors is as many as a model needs
MODEL = "model"
TRAINING = "training"
LEARNING = "areas and clusters"
# By field of ModelMixing, what its iterations are called.
ITERATIONS: Mapping[str, str] = MappingProxyType(
    {"sweeps": "step 1: sweeps", "edge_moves": "step 2: moves", "door_moves": "step 4: moves"}
)
CONVERGENCE: Mapping[str, str] = MappingProxyType({name: f"{text[:6]}: R̂" for name, text in ITERATIONS.items()})


def measure(
    data: Path | None = None,
    *,
    count: int = COUNT,
    seed: int = 0,
    repeats: Repeats | None = None,
    track: Track = iter,
) -> Results:
    """Model the floors of data/buildings/school/*.xml by `corr` and `ncut`, and score `count` buildings of each.

    Rooms without a door are left out. A floor that cannot be read, that has unknown labels or that is in several parts
    does not count. The thesis' own buildings, data/sampled/corr_table7_1.json, are scored as well if they are there.
    repeats: REPEATS by default. track: wraps the names of what is measured, to show progress.
    Raises DataError for fewer than four floors, and for fewer of the thesis' samples than floors; OptionError for fewer
    buildings than floors.
    """
    folder, repeats = find_data(data), repeats or REPEATS
    results = Results({"seed": seed, "count": count, "repeats": asdict(repeats)})
    real = read_real(results, folder)
    _check_counts(len(real), count)
    samples = read_samples(results, folder, len(real))
    scorer = SetScorer(results, repeats, seed)
    results.objects |= {"graphs": {REAL: real}, "models": {}, "clusters": {}, "halves": {}}
    results.details["models"] = {}
    for part in track([*SEGMENTATIONS, PUBLISHED_COSTS, *[THESIS] * bool(samples), REAL_HALF]):
        if part == REAL_HALF:
            scorer.score_real_halves(part, results.objects["halves"][CORR])
            continue
        if part == THESIS:
            graphs = samples
        elif part == PUBLISHED_COSTS:
            made = generate_buildings(results.objects["models"][CORR], count, seed=seed, costs=Costs.THESIS)
            graphs = _measure_generated(results, part, made)
        else:
            made = _measure_model(scorer, part, real, count)
            graphs = _measure_generated(results, part, made)
        results.objects["graphs"][part] = graphs
        scorer.score_set(part, graphs, real)
    return results


def read_real(results: Results, data: Path) -> list[nx.Graph]:
    """The floors of data/buildings/school/*.xml as a model needs them."""
    folder = data / "buildings" / "school"
    return _measure_graphs(
        results, REAL, list_maps(folder, ".xml"), lambda name: read_building_xml(folder / f"{name}.xml").graph()
    )


def read_samples(results: Results, data: Path, least: int) -> list[nx.Graph]:
    """The thesis' own samples, none if there is no file; raises DataError if fewer than `least` can be used."""
    file = data / SAMPLED
    if not file.exists():
        return []
    graphs = {graph.graph["source"]: graph for graph in read_room_graphs(file)}
    samples = _measure_graphs(results, THESIS, graphs, graphs.__getitem__)
    if len(samples) < least:
        raise DataError(
            f"{len(samples)} graphs of {short_repr(file)} can be used beside {least} real floors, "
            "give as many at least, or leave the file out"
        )
    return samples


def _measure_model(scorer: SetScorer, part: str, real: Sequence[nx.Graph], count: int) -> list[nx.Graph]:
    """Buildings of a model of the real floors; the records of it and of models of half of the floors are appended."""
    results, repeats, seed, segmentation = scorer.results, scorer.repeats, scorer.seed, SEGMENTATIONS[part]
    start = perf_counter()
    model = train_type(real, schema=SCHOOL, areas=segmentation, seed=seed)
    training = perf_counter() - start
    start = perf_counter()
    learn_type(real, SCHOOL, segmentation=segmentation)
    learning = perf_counter() - start
    made, costs = time_sampling(model, count, seed=seed)

    def make(half: Sequence[nx.Graph], random: np.random.Generator) -> list[nx.Graph]:
        # As many iterations as the chains of the model of all floors need.
        learnt = learn_type(half, SCHOOL, segmentation=segmentation)
        of_half = replace(learnt, sweeps=model.sweeps, edge_moves=model.edge_moves, door_moves=model.door_moves)
        return generate_buildings(of_half, repeats.made * len(half), seed=int(random.integers(2**31)))

    halves = draw_halves(make, real, models=repeats.models, seed=seed)
    scorer.score_held_out(part, halves)
    by_wl = learn_type(real, SCHOOL, segmentation=segmentation, kernel=AreaKernel.WEISFEILER_LEHMAN)
    clusters = score_gram(compare_areas(model.areas), model.clusters)
    add_cluster_scores(results, part, MODEL, clusters, by_wl=by_wl.configurations.shape[1])
    seconds = {(SECONDS, TRAINING): training, (SECONDS, LEARNING): learning}
    results.add(part, MODEL, seconds | costs, names=("metric", "work"))
    for step in ITERATIONS if model.mixing else ():
        mixing: Mixing = getattr(model.mixing, step)
        figures = {ITERATIONS[step]: mixing.iterations, CONVERGENCE[step]: keep_finite(mixing.convergence)}
        results.add(part, MODEL, figures)
    for name, value in (("models", model), ("clusters", clusters), ("halves", halves)):
        results.objects[name][part] = value
    results.details["models"][part] = {"similarity": clusters.similarity.tolist(), "areas": _list_areas(model)}
    return made


def _list_areas(model: TypeModel) -> list[dict[str, object]]:
    """The functional areas of the floors of a model, as JSON."""
    return [
        {"floor": floor.source, "rooms": len(area), "cluster": int(cluster)}
        for floor in model.floors
        for area, cluster in zip(floor.areas, floor.clusters, strict=True)
    ]


def _measure_generated(results: Results, part: str, graphs: Sequence[nx.Graph]) -> list[nx.Graph]:
    named = {f"{part} {number}": graph for number, graph in enumerate(graphs, 1)}
    return _measure_graphs(results, part, named, named.__getitem__)


def _measure_graphs(
    results: Results, part: str, names: Iterable[str], read: Callable[[str], nx.Graph]
) -> list[nx.Graph]:
    """The graphs of the items that a model can use; the metrics of each are appended."""
    graphs = []

    def measure_one(name: str) -> Iterator[Figures]:
        graph = read(name)
        graph.graph["source"] = name
        prepared = prepare_room_graph(graph, SCHOOL)
        measured = measure_graph(prepared, find_corridors(prepared, SCHOOL))
        graphs.append(prepared)
        yield {metric: measured[metric] for metric in METRICS}

    for name in names:
        results.measure(part, name, partial(measure_one, name))
    return graphs


def _check_counts(floors: int, count: int) -> None:
    if floors < MIN_FLOORS:
        raise DataError(
            f"{floors} floor{'s' * (floors != 1)} of schools can be used, give {MIN_FLOORS} at least, better dozens"
        )
    if count < floors:
        raise OptionError(f"{count} buildings are to be generated beside {floors} real ones, give as many at least")
