"""Draw the pictures of docs/methods/prediction.md: python docs/draw_prediction.py."""

from __future__ import annotations

from pathlib import Path

import networkx as nx
import numpy as np
from draw_generation import FLOORS, make_school
from draw_pictures import IMAGES
from PIL import Image

from pianta.errors import DataError
from pianta.floor import Floor
from pianta.generation.type_model import learn_type
from pianta.io.buildings.read import list_buildings, read_building
from pianta.labels import SCHOOL
from pianta.plot.continuations import draw_continuations_picture
from pianta.plot.figure import save_figure
from pianta.plot.prediction import draw_prediction
from pianta.prediction.continuation.continuations import draw_continuations
from pianta.prediction.prediction import predict
from pianta.prediction.revealed_floor import reveal_corridors
from pianta_bench.data.folders import find_data

SEED, WIDTH = 4, 1300
# The real school; explored corridors of it, and of the synthetic school.
NAME, CORRIDORS, SYNTHETIC_CORRIDORS = "cunningham2f.xml", 3, 2
# That of which samples are drawn.
DRAWN_NAME, DRAWN_CORRIDORS = "plans2.xml", 2


def main() -> None:
    """Draw a synthetic and a real school, each predicted from a few corridors; without data, the latter stays."""
    random = np.random.default_rng(SEED)
    *training_schools, last = (make_school(random) for _ in range(FLOORS + 1))
    draw_explored(last, training_schools, corridors=SYNTHETIC_CORRIDORS, path=IMAGES / "prediction.png")
    try:
        files = list_buildings([find_data() / "buildings" / "school"])
    except DataError:
        return
    floors = {Path(file).name: read_building(file) for file in files}
    graphs = {name: floor.graph() for name, floor in floors.items()}
    others = [graph for name, graph in graphs.items() if name != NAME]
    draw_explored(graphs[NAME], others, corridors=CORRIDORS, path=IMAGES / "prediction_school.png")
    others = [graph for name, graph in graphs.items() if not name.startswith(DRAWN_NAME[:5])]
    draw_plans(floors[DRAWN_NAME], others, corridors=DRAWN_CORRIDORS, path=IMAGES / "prediction_plans.png")


def draw_explored(floor: nx.Graph, others: list[nx.Graph], *, corridors: int, path: Path) -> None:
    """Predict a floor from its first corridors by a model of other floors, and draw it beside the truth."""
    truth = reveal_corridors(floor, SCHOOL, corridors=corridors)
    prediction = predict(truth.part, learn_type(others, SCHOOL), seed=SEED)
    save_figure(draw_prediction(prediction, truth=truth), path)
    reduce_picture(path)


def draw_plans(floor: Floor, others: list[nx.Graph], *, corridors: int, path: Path) -> None:
    """Predict a floor from its first corridors by a model of other floors, and draw samples as plans."""
    truth, model = reveal_corridors(floor.graph(), SCHOOL, corridors=corridors), learn_type(others, SCHOOL)
    prediction = predict(truth.part, model, seed=SEED)
    continuations = draw_continuations(prediction, floor, model=model, truth=truth, seed=SEED)
    save_figure(draw_continuations_picture(continuations, schema=SCHOOL, samples=len(prediction.samples)), path)
    reduce_picture(path)


def reduce_picture(path: Path) -> None:
    """Make a picture narrower, in 256 colours."""
    with Image.open(path) as picture:
        smaller = picture.convert("RGB").resize(
            (WIDTH, picture.height * WIDTH // picture.width), Image.Resampling.LANCZOS
        )
    smaller.quantize(256, Image.Quantize.MAXCOVERAGE).save(path, optimize=True)


if __name__ == "__main__":
    main()
