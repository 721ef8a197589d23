"""Chapter 7: models of real schools, new ones made by them, and how far these are from real ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from types import MappingProxyType

import networkx as nx
import numpy as np

from pianta.errors import DataError, OptionError
from pianta.evaluation.graph_sets import Trial
from pianta.generation.area_clusters import AreaKernel
from pianta.generation.buildings import Costs, generate_buildings
from pianta.generation.functional_areas import Segmentation
from pianta.generation.train import train_type
from pianta.generation.type_model import ModelMixing, TypeModel, learn_type, prepare_room_graph
from pianta.graphs.metrics import find_corridors, measure_graph
from pianta.io._files import short_repr
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.graphs import read_room_graphs
from pianta.labels import SCHOOL
from pianta_bench.data.folders import list_maps
from pianta_bench.generation.clusters import ClusterScores, score_clusters
from pianta_bench.generation.costs import SamplingCosts, time_sampling
from pianta_bench.generation.scores import (
    Effort,
    HeldOutScores,
    SetScores,
    draw_halves,
    score_halves,
    score_held_out,
    score_set,
)
from pianta_bench.graphs.tables import NAMES, PRINTED
from pianta_bench.harness.comparison import Items
from pianta_bench.harness.table import Column, Figures, Row, measure_rows

REAL, CORR, NCUT, PRINTED_COSTS, THESIS = "real", "corr", "ncut", "as printed", "thesis"
SEGMENTATIONS = MappingProxyType({CORR: Segmentation.CORR, NCUT: Segmentation.NCUT})
SAMPLED = Path("sampled", "corr_table7_1.json")
METRICS = tuple(PRINTED)
COUNT, SEED = 200, 0
EFFORT = Effort()
# Each half of the real floors is as many as a model takes.
MIN_FLOORS = 4
_COLUMNS = tuple(Column(key, NAMES[key], "") for key in METRICS)


@dataclass(frozen=True, eq=False)
class RoomGraphs:
    """A set of room graphs, and a row of 19 metrics for each item; a row that failed has no graph."""

    graphs: Sequence[nx.Graph]
    rows: tuple[Row, ...]

    def list_figures(self, key: str) -> list[float]:
        """A metric of all graphs that have it."""
        return [figure for row in self.rows if (figure := row.figures[key]) is not None]


@dataclass(frozen=True, eq=False)
class JudgedModel:
    """A model of all real floors.

    training: seconds that it took; learning: those for its areas and clusters alone. clusters_by_wl: how many there are
    by the Weisfeiler-Lehman kernel. halves: pairs of halves of the real floors, with what models of
    the first have made.
    """

    model: TypeModel
    mixing: ModelMixing | None
    training: float
    learning: float
    sampling: SamplingCosts
    clusters: ClusterScores
    clusters_by_wl: int
    halves: Sequence[Trial]
    held_out: HeldOutScores


@dataclass(frozen=True, eq=False)
class GenerationBench:
    """What was measured.

    sets: by part, REAL first; PRINTED_COSTS by the model of CORR with Costs.THESIS; THESIS only where its samples are
    in the data. scores: by part but REAL. models: CORR and NCUT. real_halves: of half A of the real floors itself, for
    each pair of halves of the models.
    """

    seed: int
    count: int
    effort: Effort
    sets: Mapping[str, RoomGraphs]
    scores: Mapping[str, SetScores]
    models: Mapping[str, JudgedModel]
    real_halves: HeldOutScores

    @property
    def items(self) -> Items:
        """The metrics of every graph, and what failed, by part."""
        return {part: graphs.rows for part, graphs in self.sets.items()}


def measure_generation(
    data: Path,
    *,
    seed: int = SEED,
    count: int = COUNT,
    effort: Effort | None = None,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> GenerationBench:
    """Model the floors of data/buildings/school/*.xml by `corr` and `ncut`, and judge so many buildings of each.

    Rooms without a door are left out. A floor that cannot be read, that has unknown labels or that is in several parts
    does not count. Beside the buildings stand the thesis' own, data/sampled/corr_table7_1.json, when they are there.
    effort: EFFORT unless given. track: wraps the names of what is measured, to show progress.
    Raises DataError for fewer than four floors, and for fewer of the thesis' samples than floors; OptionError for fewer
    buildings than floors.
    """
    real = read_real(data)
    _check_counts(len(real.graphs), count)
    samples = read_samples(data, len(real.graphs))
    return _judge_all(real=real, samples=samples, count=count, seed=seed, effort=effort or EFFORT, track=track)


def read_real(data: Path) -> RoomGraphs:
    """The floors of data/buildings/school/*.xml as a model takes them."""
    folder = data / "buildings" / "school"
    return _measure_items(list_maps(folder, ".xml"), lambda name: read_building_xml(folder / f"{name}.xml").graph())


def read_samples(data: Path, least: int) -> RoomGraphs | None:
    """The thesis' own samples, None where there are none; raises DataError where fewer than `least` can be used."""
    file = data / SAMPLED
    if not file.exists():
        return None
    graphs = {graph.graph["source"]: graph for graph in read_room_graphs(file)}
    samples = _measure_items(graphs, graphs.__getitem__)
    if len(samples.graphs) < least:
        raise DataError(
            f"{len(samples.graphs)} graphs of {short_repr(file)} can be used beside {least} real floors, "
            "give as many at least, or leave the file out"
        )
    return samples


def _judge_all(
    *,
    real: RoomGraphs,
    samples: RoomGraphs | None,
    count: int,
    seed: int,
    effort: Effort,
    track: Callable[[Sequence[str]], Iterable[str]],
) -> GenerationBench:
    sets = {REAL: real}
    scores: dict[str, SetScores] = {}
    models: dict[str, JudgedModel] = {}
    real_halves = HeldOutScores({}, {})
    for part in track([*SEGMENTATIONS, PRINTED_COSTS, *[THESIS] * (samples is not None), REAL]):
        if part == REAL:
            real_halves = score_halves(models[CORR].halves, SCHOOL, seed=seed, effort=effort)
            continue
        if part in SEGMENTATIONS:
            made, models[part] = _judge_model(real.graphs, SEGMENTATIONS[part], count, seed, effort)
            sets[part] = _measure_set(made, part)
        elif part == PRINTED_COSTS:
            made = generate_buildings(models[CORR].model, count, seed=seed, costs=Costs.THESIS)
            sets[part] = _measure_set(made, part)
        elif samples is not None:
            sets[part] = samples
        scores[part] = score_set(sets[part].graphs, real.graphs, SCHOOL, seed=seed, effort=effort)
    return GenerationBench(seed, count, effort, sets, scores, models, real_halves)


def _judge_model(
    real: Sequence[nx.Graph], segmentation: Segmentation, count: int, seed: int, effort: Effort
) -> tuple[list[nx.Graph], JudgedModel]:
    """Buildings of a model of the real floors, and what is said of it and of models of half of them."""
    start = perf_counter()
    model = train_type(real, schema=SCHOOL, areas=segmentation, seed=seed)
    training = perf_counter() - start
    start = perf_counter()
    learn_type(real, SCHOOL, segmentation=segmentation)
    learning = perf_counter() - start
    made, sampling = time_sampling(model, count, seed=seed)

    def make(half: Sequence[nx.Graph], random: np.random.Generator) -> list[nx.Graph]:
        # Iterations are those that chains of the model of all floors take.
        learnt = learn_type(half, SCHOOL, segmentation=segmentation)
        of_half = replace(learnt, sweeps=model.sweeps, edge_moves=model.edge_moves, door_moves=model.door_moves)
        return generate_buildings(of_half, effort.made * len(half), seed=int(random.integers(2**31)))

    halves = draw_halves(make, real, models=effort.models, seed=seed)
    held_out = score_held_out(halves, SCHOOL, seed=seed, effort=effort)
    by_wl = learn_type(real, SCHOOL, segmentation=segmentation, kernel=AreaKernel.WEISFEILER_LEHMAN)
    return made, JudgedModel(
        model,
        model.mixing,
        training,
        learning,
        sampling,
        score_clusters(model),
        by_wl.configurations.shape[1],
        halves,
        held_out,
    )


def _measure_set(graphs: Sequence[nx.Graph], part: str) -> RoomGraphs:
    named = {f"{part} {number}": graph for number, graph in enumerate(graphs, 1)}
    return _measure_items(named, named.__getitem__)


def _measure_items(names: Iterable[str], read: Callable[[str], nx.Graph]) -> RoomGraphs:
    """The graphs of the items that a model can take, and the metrics of all."""
    graphs: dict[str, nx.Graph] = {}

    def measure(name: str) -> Iterator[Figures]:
        graph = read(name)
        graph.graph["source"] = name
        prepared = prepare_room_graph(graph, SCHOOL)
        measured = measure_graph(prepared, find_corridors(prepared, SCHOOL))
        graphs[name] = prepared
        yield {key: measured[key] for key in METRICS}

    rows = measure_rows(names, measure, columns=_COLUMNS)
    return RoomGraphs([*graphs.values()], rows)


def _check_counts(floors: int, count: int) -> None:
    if floors < MIN_FLOORS:
        raise DataError(
            f"{floors} floor{'s' * (floors != 1)} of schools can be used, give {MIN_FLOORS} at least, better dozens"
        )
    if count < floors:
        raise OptionError(f"{count} buildings are to be generated beside {floors} real ones, give as many at least")
