"""Pictures of predictions of a few floors as they are explored, in the style of Figs. 8.9 to 8.12."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pianta.generation.type_model import learn_type
from pianta.plot.figure import save_figure
from pianta.plot.prediction import draw_prediction
from pianta.prediction.prediction import Prediction, predict
from pianta.prediction.revealed_floor import RevealedFloor, reveal_corridors
from pianta.prediction.unexplored_part import FloorSampler
from pianta_bench.prediction.measure import PredictionBench, TypeOfFloors, list_others

# Floors of each type, the first that are predicted so often.
FLOORS, LEAST_STAGES, MOST_STAGES = 3, 3, 6


def save_prediction_pictures(bench: PredictionBench, folder: Path) -> None:
    """Write KIND_NAME_CORRIDORS.png of a few floors after each corridor; raises PiantaError when one cannot be."""
    for kind, of in bench.types.items():
        for name in choose_floors(of):
            for corridors, whole, prediction in predict_again(of, name, bench):
                figure = draw_prediction(prediction, truth=whole)
                save_figure(figure, folder / f"{kind}_{name}_{corridors}.png")


def choose_floors(of: TypeOfFloors) -> list[str]:
    """The names of the floors that are drawn."""
    few = [floor for floor in of.floors if LEAST_STAGES <= len(floor.stages) <= MOST_STAGES]
    return [floor.source for floor in (few or [floor for floor in of.floors if floor.stages])[:FLOORS]]


def predict_again(
    of: TypeOfFloors, name: str, bench: PredictionBench
) -> Iterator[tuple[int, RevealedFloor, Prediction]]:
    """The number of explored corridors, the floor explored so far, and the prediction that was judged."""
    sampler = FloorSampler(learn_type(list_others(of.graphs, name), of.schema))
    for floor in of.floors:
        for corridors in [stage.corridors for stage in floor.stages if floor.source == name]:
            whole = reveal_corridors(of.graphs[name], of.schema, corridors=corridors)
            yield corridors, whole, predict(whole.part, sampler, count=bench.count, seed=bench.seed)
