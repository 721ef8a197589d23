"""Section 8.3: schools and offices explored corridor by corridor, and the rest of each predicted by the others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from time import process_time
from typing import Any

import networkx as nx

from pianta.errors import DataError
from pianta.generation.type_model import MIN_FLOORS, learn_type, prepare_room_graph
from pianta.graphs.metrics import find_corridors
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.labels import SCHEMAS, LabelConvention
from pianta.prediction.explored_part import explore_by_corridors
from pianta.prediction.prediction import predict
from pianta.prediction.unexplored_part import FloorSampler
from pianta_bench.data.building_of import building_of
from pianta_bench.data.folders import find_data, list_maps
from pianta_bench.graphs.measure import PARTS
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.prediction import COUNT
from pianta_bench.prediction.baselines import Baselines
from pianta_bench.prediction.scores import describe_stage, predict_doors, score_prediction


def measure(data: Path | None = None, *, count: int = COUNT, seed: int = 0, track: Track = iter) -> Results:
    """Explore the floors of data/buildings/school/*.xml and office/*.xml, and score predictions by `corr`.

    Each floor is predicted by a model of the floors of all other buildings of its type. A floor that cannot be read,
    that has unknown labels or that is in several parts does not count. count: samples of a prediction. track: wraps the
    names of the floors, to show progress.
    Records of a stage have the fields `explored`, its explored corridors, and `half`, whether these are half of all;
    scores also `predictor`. details["doors"] are the predictions of what is behind doors. With half of the corridors
    each floor is predicted by the printed sampler as well, which takes longer.
    Raises DataError if there are no floors of a type, or too few buildings.
    """
    folder = find_data(data)
    results = Results({"seed": seed, "count": count}, details={"doors": []})
    floors = {building_type: read_floors(results, folder, building_type) for building_type in PARTS}
    results.objects["graphs"] = floors
    names = [(building_type, name) for building_type, graphs in floors.items() for name in graphs]
    for (building_type, name), _ in zip(names, track([" ".join(each) for each in names]), strict=True):
        measure_floor(results, building_type, name)
    return results


def read_floors(results: Results, data: Path, building_type: str) -> dict[str, nx.Graph]:
    """The floors of a type as a model needs them, by their names; their numbers of rooms and corridors are appended."""
    folder = data / "buildings" / building_type
    graphs: dict[str, nx.Graph] = {}

    def read(name: str) -> Iterator[Figures]:
        graph = read_building_xml(folder / f"{name}.xml").graph()
        graph.graph["source"] = name
        graphs[name] = prepare_room_graph(graph, SCHEMAS[building_type])
        graphs[name].graph["building"] = building_of(data, f"buildings/{building_type}/{name}.xml")
        corridors = find_corridors(graphs[name], SCHEMAS[building_type], convention=LabelConvention.GRAPHS)
        yield {"rooms": len(graphs[name]), "corridors": len(corridors)}

    for name in list_maps(folder, ".xml"):
        results.measure(PARTS[building_type], name, partial(read, name))
    if not graphs or any(len(list_others(graphs, name)) < MIN_FLOORS for name in graphs):
        raise DataError(
            f"{len(graphs)} floor{'s' * (len(graphs) != 1)} of {PARTS[building_type]} can be used, "
            f"give those of {MIN_FLOORS + 1} buildings at least, better dozens"
        )
    return graphs


def list_others(graphs: Mapping[str, nx.Graph], name: str) -> list[nx.Graph]:
    """The floors of all other buildings."""
    building = graphs[name].graph["building"]
    return [graph for graph in graphs.values() if graph.graph["building"] != building]


def measure_floor(results: Results, building_type: str, name: str) -> None:
    """Explore a floor by corridors, and append the scores of each prediction while something is unseen."""
    part, schema, graphs = PARTS[building_type], SCHEMAS[building_type], results.objects["graphs"][building_type]
    count, seed, graph = results.options["count"], results.options["seed"], graphs[name]
    start = process_time()
    model = learn_type(list_others(graphs, name), schema)
    learned = process_time()
    sampler = FloorSampler(model)
    figures = {"model, once": learned - start, "sampler, once": process_time() - learned}
    results.add(part, name, figures, names=("work",), metric="seconds")
    baselines = Baselines(model)
    explorations = explore_by_corridors(graph, find_corridors(graph, schema, convention=LabelConvention.GRAPHS))
    half = -(-len(explorations) // 2)
    for explored, part_graph in enumerate(explorations, 1):
        if {node for node in part_graph if part_graph.nodes[node]["label"] is not None} == {*graph}:
            continue
        start = process_time()
        prediction = predict(part_graph, sampler, count=count, seed=seed)
        seconds = process_time() - start
        stage: dict[str, Any] = {"explored": explored, "half": explored == half, "building": graph.graph["building"]}
        results.add(part, name, {"seconds": seconds}, work="prediction", **stage)
        printed = None
        if explored == half:
            start = process_time()
            printed = predict(part_graph, sampler, count=count, seed=seed, as_printed=True)
            results.add(part, name, {"seconds": process_time() - start}, work="as printed", **stage)
        scores = score_prediction(graph, prediction, baselines, printed=printed, edited=explored == half, seed=seed)
        results.add(part, name, describe_stage(graph, prediction, baselines), **stage)
        results.add(part, name, scores, names=("metric", "predictor"), **stage)
        results.details["doors"] += [
            {"part": part, "item": name, **stage, **door}
            for door in predict_doors(graph, prediction, baselines, printed)
        ]
