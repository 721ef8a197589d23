"""Chapter 7: models of real buildings of a type, new ones by them, and how much these differ from real ones."""

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
from pianta.generation.buildings import BuildingSampler, Costs, generate_buildings
from pianta.generation.functional_areas import Segmentation
from pianta.generation.train import train_type
from pianta.generation.type_model import TypeModel, learn_type, prepare_room_graph
from pianta.graphs.metrics import find_corridors, measure_graph
from pianta.io._files import short_repr
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.graphs import read_room_graphs
from pianta.labels import OFFICE, SCHOOL, LabelSchema
from pianta_bench.data.building_of import building_of
from pianta_bench.data.folders import find_data, list_maps
from pianta_bench.generation import COUNT
from pianta_bench.generation.clusters import add_cluster_scores, score_gram
from pianta_bench.generation.convergence import add_mixing
from pianta_bench.generation.costs import SECONDS, time_hopper_sampling, time_sampling
from pianta_bench.generation.distances import add_distances
from pianta_bench.generation.scores import BUILDING, Repeats, SetScorer, draw_halves
from pianta_bench.generation.stability import add_stability
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.harness.tables import read_published

REAL = "real"
CORR = "corr"
NCUT = "ncut"
REAL_AREAS = "real areas"
PUBLISHED_COSTS = "as printed"
THESIS = "thesis"
REAL_HALF = "real half A"
REAL_COPIES = "copies of half A"
SEGMENTATIONS = MappingProxyType({CORR: Segmentation.CORR, NCUT: Segmentation.NCUT})
TYPES: Mapping[str, LabelSchema] = MappingProxyType({"school": SCHOOL, "office": OFFICE})
SAMPLED = Path("sampled", "corr_table7_1.json")
TABLE_7_1 = "table_7_1.csv"
METRICS = tuple(dict.fromkeys(record["metric"] for record in read_published(TABLE_7_1)))
REPEATS = Repeats()
MIN_FLOORS = 4  # each half of the real floors is as many as a model needs
MIN_BUILDINGS = 2  # one in each half
MODEL = "model"
TRAINING = "training"
LEARNING = "areas and clusters"


def measure(
    data: Path | None = None,
    *,
    type: str = "school",  # noqa: A002 - the option --type
    count: int = COUNT,
    seed: int = 0,
    repeats: Repeats | None = None,
    track: Track = iter,
) -> Results:
    """Model the floors of data/buildings/TYPE/*.xml by `corr` and `ncut`, and score `count` buildings of each.

    Rooms without a door are left out. A floor that cannot be read, that has unknown labels or that is in several parts
    does not count. The thesis' own buildings, data/sampled/corr_table7_1.json, are scored beside schools if they are
    there. repeats: REPEATS by default. track: wraps the names of what is measured, to show progress.
    Raises DataError for fewer than four floors, for floors of one building, and for fewer of the thesis' samples than
    floors; OptionError for another type, and for fewer buildings than floors.
    """
    if type not in TYPES:
        raise OptionError(f"type is {short_repr(type)}, give one of {', '.join(TYPES)}")
    folder, repeats = find_data(data), repeats or REPEATS
    results = Results({"type": type, "seed": seed, "count": count, "repeats": asdict(repeats)})
    real = read_real(results, folder, type)
    buildings = [building_of(folder, f"buildings/{type}/{graph.graph['source']}.xml") for graph in real]
    _check_counts(type, buildings, count)
    for graph, building in zip(real, buildings, strict=True):
        graph.graph[BUILDING] = building
    samples = read_samples(results, folder, len(real)) if type == "school" else []
    scorer = SetScorer(results, repeats, TYPES[type], seed)
    results.objects |= {"graphs": {REAL: real}, "buildings": buildings, "models": {}, "clusters": {}, "halves": {}}
    results.details["models"] = {}
    names = [*SEGMENTATIONS, REAL_AREAS, PUBLISHED_COSTS, *[THESIS] * bool(samples)]
    for part in track([*names, REAL_HALF, REAL_COPIES]):
        if part in {REAL_HALF, REAL_COPIES}:
            copies = repeats.multiple if part == REAL_COPIES else 1
            scorer.score_real_halves(part, results.objects["halves"][CORR], copies=copies)
            continue
        graphs = samples if part == THESIS else _generate(scorer, part, count)
        results.objects["graphs"][part] = graphs
        scorer.score_set(part, graphs, real)
    add_distances(results, REAL, real, results.objects["models"][CORR], buildings=buildings)
    for part in names:
        add_distances(results, part, results.objects["graphs"][part], results.objects["models"][CORR])
    return results


def read_real(results: Results, data: Path, type: str = "school") -> list[nx.Graph]:  # noqa: A002
    """The floors of data/buildings/TYPE/*.xml as a model needs them."""
    folder = data / "buildings" / type
    return _measure_graphs(
        results,
        REAL,
        list_maps(folder, ".xml"),
        lambda name: read_building_xml(folder / f"{name}.xml").graph(),
        TYPES[type],
    )


def read_samples(results: Results, data: Path, least: int) -> list[nx.Graph]:
    """The thesis' own samples, none if there is no file; raises DataError if fewer than `least` can be used."""
    file = data / SAMPLED
    if not file.exists():
        return []
    graphs = {graph.graph["source"]: graph for graph in read_room_graphs(file)}
    samples = _measure_graphs(results, THESIS, graphs, graphs.__getitem__, SCHOOL)
    if len(samples) < least:
        raise DataError(
            f"{len(samples)} graphs of {short_repr(file)} can be used beside {least} real floors, "
            "give as many at least, or leave the file out"
        )
    return samples


def _generate(scorer: SetScorer, part: str, count: int) -> list[nx.Graph]:
    """Buildings of a part, of a model of all real floors; the records of it and of models of halves are appended."""
    results, seed = scorer.results, scorer.seed
    if part in SEGMENTATIONS:
        buildings = _measure_model(scorer, part, count)
        recombines = True
    else:
        model, recombines = results.objects["models"][CORR], False
        costs = Costs.THESIS if part == PUBLISHED_COSTS else Costs.DENSITY
        buildings = generate_buildings(model, count, seed=seed, costs=costs, recombines=False)
    if part != PUBLISHED_COSTS:
        _measure_halves(scorer, part, recombines=recombines)
    named = {f"{part} {number}": graph for number, graph in enumerate(buildings, 1)}
    return _measure_graphs(results, part, named, named.__getitem__, scorer.schema)


def _measure_model(scorer: SetScorer, part: str, count: int) -> list[nx.Graph]:
    """Buildings of a model of the real floors; its records are appended."""
    results, seed, segmentation, schema = scorer.results, scorer.seed, SEGMENTATIONS[part], scorer.schema
    real = results.objects["graphs"][REAL]
    start = perf_counter()
    model = train_type(real, schema=schema, areas=segmentation, seed=seed)
    training = perf_counter() - start
    start = perf_counter()
    learn_type(real, schema, segmentation=segmentation)
    learning = perf_counter() - start
    buildings, costs = time_sampling(model, count, seed=seed)
    by_wl = learn_type(real, schema, segmentation=segmentation, kernel=AreaKernel.WEISFEILER_LEHMAN)
    clusters = score_gram(compare_areas(model.areas), model.clusters)
    add_cluster_scores(results, part, MODEL, clusters, by_wl=by_wl.configurations.shape[1])
    add_stability(results, part, model, seed=seed)
    seconds = {(SECONDS, TRAINING): training, (SECONDS, LEARNING): learning}
    hopper = time_hopper_sampling(model, seed=seed)
    results.add(part, MODEL, seconds | costs | hopper, names=("metric", "work"))
    if model.mixing:
        add_mixing(results, part, MODEL, model.mixing)
    for name, value in (("models", model), ("clusters", clusters)):
        results.objects[name][part] = value
    results.details["models"][part] = {"similarity": clusters.similarity.tolist(), "areas": _list_areas(model)}
    return buildings


def _measure_halves(scorer: SetScorer, part: str, *, recombines: bool) -> None:
    """Append the scores of models of halves of the real floors; no building has floors in both halves."""
    results, repeats = scorer.results, scorer.repeats
    model = results.objects["models"][part if part in SEGMENTATIONS else CORR]

    def make(half: Sequence[nx.Graph], random: np.random.Generator) -> list[nx.Graph]:
        # As many iterations as the chains of the model of all floors need.
        learnt = learn_type(half, scorer.schema, segmentation=model.segmentation)
        half_model = replace(learnt, sweeps=model.sweeps, edge_moves=model.edge_moves, door_moves=model.door_moves)
        count, seed = repeats.multiple * len(half), int(random.integers(2**31))
        graphs = generate_buildings(half_model, count, seed=seed, recombines=recombines)
        if recombines:
            floors = BuildingSampler(half_model).choose_floors(range(count), seed)
            for graph, floor in zip(graphs, floors, strict=True):
                graph.graph[BUILDING] = half[floor].graph[BUILDING]
        return graphs

    real, buildings = results.objects["graphs"][REAL], results.objects["buildings"]
    halves = draw_halves(make, real, models=repeats.models, seed=scorer.seed, buildings=buildings)
    scorer.score_held_out(part, halves)
    results.objects["halves"][part] = halves


def _list_areas(model: TypeModel) -> list[dict[str, object]]:
    """The functional areas of the floors of a model, as JSON."""
    return [
        {"floor": floor.source, "rooms": len(area), "cluster": int(cluster)}
        for floor in model.floors
        for area, cluster in zip(floor.areas, floor.clusters, strict=True)
    ]


def _measure_graphs(
    results: Results, part: str, names: Iterable[str], read: Callable[[str], nx.Graph], schema: LabelSchema
) -> list[nx.Graph]:
    """The graphs of the items that a model can use; the metrics of each are appended."""
    graphs = []

    def measure_one(name: str) -> Iterator[Figures]:
        graph = read(name)
        graph.graph["source"] = name
        prepared = prepare_room_graph(graph, schema)
        measured = measure_graph(prepared, find_corridors(prepared, schema))
        graphs.append(prepared)
        yield {metric: measured[metric] for metric in METRICS}

    for name in names:
        results.measure(part, name, partial(measure_one, name))
    return graphs


def _check_counts(type: str, buildings: Sequence[str], count: int) -> None:  # noqa: A002
    """Raise DataError for too few floors or buildings, OptionError for fewer generated buildings than floors.

    buildings: of each real floor. count: of the generated ones.
    """
    floors = len(buildings)
    if floors < MIN_FLOORS:
        raise DataError(
            f"{floors} floor{'s' * (floors != 1)} of {type}s can be used, give {MIN_FLOORS} at least, better dozens"
        )
    if len(set(buildings)) < MIN_BUILDINGS:
        raise DataError(
            f"all {floors} floors of {type}s are of building {short_repr(buildings[0])}, give floors of two buildings "
            "at least"
        )
    if count < floors:
        raise OptionError(f"{count} buildings are to be generated beside {floors} real ones, give as many at least")
