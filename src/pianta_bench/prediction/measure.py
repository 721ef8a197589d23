"""Section 8.3: schools and offices explored corridor by corridor, and what the others tell of the rest of each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import networkx as nx

from pianta.errors import DataError
from pianta.generation.type_model import MIN_FLOORS, learn_type, prepare_room_graph
from pianta.graphs.metrics import find_corridors
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.labels import SCHEMAS, LabelConvention, LabelSchema
from pianta.prediction.unexplored_part import FloorSampler
from pianta.rooms.training import building_name
from pianta_bench.data.folders import list_maps
from pianta_bench.harness.comparison import Items
from pianta_bench.harness.table import Figures, Row, measure_rows
from pianta_bench.prediction.rivals import Rivals
from pianta_bench.prediction.scores import JudgedFloor, JudgedStage, judge_floor

KINDS = ("school", "office")
COUNT, SEED = 100, 0


@dataclass(frozen=True, eq=False)
class TypeOfFloors:
    """Judged floors of a type. graphs: of them, by their names. rows: of all floors, those that failed as well.

    sampler_seconds: of the processor, to make the sampler of each floor's model; learning_seconds: the model.
    """

    schema: LabelSchema
    graphs: Mapping[str, nx.Graph]
    rows: Sequence[Row]
    floors: Sequence[JudgedFloor]
    learning_seconds: Sequence[float]
    sampler_seconds: Sequence[float]

    @property
    def halves(self) -> list[tuple[JudgedFloor, JudgedStage]]:
        """The floors of which something is unseen with half of the corridors explored, and that stage."""
        return [(floor, floor.half) for floor in self.floors if floor.half]


@dataclass(frozen=True, eq=False)
class PredictionBench:
    """What was measured. count: samples of a prediction. types: by building type."""

    seed: int
    count: int
    types: Mapping[str, TypeOfFloors]

    @property
    def items(self) -> Items:
        """The floors, what failed among them, and the figures of every stage, by type."""
        floors = {f"{kind}s": of.rows for kind, of in self.types.items()}
        stages = {
            f"{kind}s, stages": [_row(floor, stage) for floor in of.floors for stage in floor.stages]
            for kind, of in self.types.items()
        }
        return floors | stages


def measure_prediction(
    data: Path,
    *,
    count: int = COUNT,
    seed: int = SEED,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> PredictionBench:
    """Explore the floors of data/buildings/school/*.xml and office/*.xml, and judge predictions by `corr`.

    Each floor is predicted by a model of the floors of all other buildings of its type. A floor that cannot be read,
    that has unknown labels or that is in several parts does not count. track: wraps the names of the floors, to show
    progress.
    Raises DataError where there are no floors of a type, or too few buildings.
    """
    read = {kind: read_floors(data, kind) for kind in KINDS}
    names = [f"{kind} {name}" for kind, (graphs, _) in read.items() for name in graphs]
    tracked = iter(track(names))
    types = {}
    for kind, (graphs, rows) in read.items():
        judged = []
        for name in graphs:
            next(tracked)
            judged.append(_judge(graphs, name, SCHEMAS[kind], count, seed))
        floors, learning, sampler = zip(*judged, strict=True)
        types[kind] = TypeOfFloors(SCHEMAS[kind], graphs, rows, floors, learning, sampler)
    next(tracked, None)
    return PredictionBench(seed, count, types)


def read_floors(data: Path, kind: str) -> tuple[dict[str, nx.Graph], Sequence[Row]]:
    """The floors of a type as a model takes them, by their names, and a row for each and what a model cannot take."""
    folder = data / "buildings" / kind
    graphs: dict[str, nx.Graph] = {}

    def read(name: str) -> Iterator[Figures]:
        graph = read_building_xml(folder / f"{name}.xml").graph()
        graph.graph["source"] = name
        graphs[name] = prepare_room_graph(graph, SCHEMAS[kind])
        corridors = find_corridors(graphs[name], SCHEMAS[kind], convention=LabelConvention.GRAPHS)
        yield {"rooms": float(len(graphs[name])), "corridors": float(len(corridors))}

    rows = measure_rows(list_maps(folder, ".xml"), read, columns=())
    few = [name for name in graphs if len(list_others(graphs, name)) < MIN_FLOORS]
    if few or not graphs:
        raise DataError(
            f"{len(graphs)} floor{'s' * (len(graphs) != 1)} of {kind}s can be used, "
            f"give those of {MIN_FLOORS + 1} buildings at least, better dozens"
        )
    return graphs, rows


def list_others(graphs: Mapping[str, nx.Graph], name: str) -> list[nx.Graph]:
    """The floors of all other buildings."""
    return [graph for other, graph in graphs.items() if building_name(other) != building_name(name)]


def _judge(
    graphs: Mapping[str, nx.Graph], name: str, schema: LabelSchema, count: int, seed: int
) -> tuple[JudgedFloor, float, float]:
    start = process_time()
    model = learn_type(list_others(graphs, name), schema)
    learned = process_time()
    sampler = FloorSampler(model)
    made = process_time()
    floor = judge_floor(graphs[name], sampler, Rivals(model), count=count, seed=seed)
    return floor, learned - start, made - learned


def _row(floor: JudgedFloor, stage: JudgedStage) -> Row:
    figures = {
        "explored corridors": float(stage.corridors),
        "known rooms": float(stage.known),
        "half": float(stage is floor.half),
        "interval holds": float(stage.interval),
        "seconds": stage.seconds,
        **stage.figures,
    }
    return Row(f"{floor.source} after {stage.corridors} corridors", figures)
