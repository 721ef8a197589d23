"""Pictures of predictions of a few floors as they are explored, in the style of Figs. 8.9 to 8.12."""

from __future__ import annotations

from pathlib import Path

from pianta.generation.type_model import learn_type
from pianta.labels import SCHEMAS
from pianta.plot.figure import save_figure
from pianta.plot.prediction import draw_prediction
from pianta.prediction.prediction import predict
from pianta.prediction.revealed_floor import reveal_corridors
from pianta.prediction.unexplored_part import FloorSampler
from pianta_bench.graphs.measure import PARTS
from pianta_bench.harness.records import Results
from pianta_bench.prediction.measure import list_others

FLOORS = 3  # of each type, the first with a suitable number of predictions
MIN_STAGES = 3
MAX_STAGES = 6


def save_figures(results: Results, folder: Path) -> None:
    """Write TYPE_NAME_CORRIDORS.png of a few floors after each corridor; raises PiantaError if one cannot be."""
    for building_type, graphs in results.objects["graphs"].items():
        schema = SCHEMAS[building_type]
        for name, stages in choose_floors(results, building_type).items():
            sampler = FloorSampler(learn_type(list_others(graphs, name), schema))
            for corridors in stages:
                floor = reveal_corridors(graphs[name], schema, corridors=corridors)
                prediction = predict(floor.part, sampler, count=results.options["count"], seed=results.options["seed"])
                figure = draw_prediction(prediction, truth=floor)
                save_figure(figure, folder / f"{building_type}_{name}_{corridors}.png")


def choose_floors(results: Results, building_type: str) -> dict[str, list[int]]:
    """The floors that are drawn, with the number of explored corridors of each prediction."""
    stages: dict[str, list[int]] = {}
    for record in results.select(part=PARTS[building_type], work="prediction"):
        stages.setdefault(record["item"], []).append(record["explored"])
    suitable = {name: numbers for name, numbers in stages.items() if MIN_STAGES <= len(numbers) <= MAX_STAGES}
    return dict([*(suitable or stages).items()][:FLOORS])
