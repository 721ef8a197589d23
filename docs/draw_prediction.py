"""Draw the pictures of docs/methods/prediction.md: python docs/draw_prediction.py."""

from __future__ import annotations

from pathlib import Path

import networkx as nx
import numpy as np
from draw_generation import FLOORS, make_school
from draw_pictures import IMAGES
from PIL import Image

from pianta.errors import DataError
from pianta.generation.type_model import learn_type
from pianta.io.buildings.read import list_buildings, read_building
from pianta.labels import SCHOOL
from pianta.plot.figure import save_figure
from pianta.plot.prediction import draw_prediction
from pianta.prediction.prediction import predict
from pianta.prediction.whole_floor import explore_floor
from pianta_bench.data.folders import find_data

SEED, WIDTH = 4, 1300
# The real school and how many of its corridors are explored; of the made one two are.
NAME, CORRIDORS, MADE_CORRIDORS = "cunningham2f.xml", 3, 2


def main() -> None:
    """Draw a made school and a real one, each predicted from a few corridors; without data, the latter stays."""
    random = np.random.default_rng(SEED)
    *training_floors, last = (make_school(random) for _ in range(FLOORS + 1))
    draw_explored(last, training_floors, corridors=MADE_CORRIDORS, path=IMAGES / "prediction.png")
    try:
        files = list_buildings([find_data() / "buildings" / "school"])
    except DataError:
        return
    graphs = {Path(file).name: read_building(file).graph() for file in files}
    school = graphs.pop(NAME)
    draw_explored(school, [*graphs.values()], corridors=CORRIDORS, path=IMAGES / "prediction_school.png")


def draw_explored(school: nx.Graph, others: list[nx.Graph], *, corridors: int, path: Path) -> None:
    """Predict a floor from its first corridors by a model of other floors, and draw it with the truth."""
    truth = explore_floor(school, SCHOOL, corridors=corridors)
    prediction = predict(truth.part, learn_type(others, SCHOOL), seed=SEED)
    save_figure(draw_prediction(prediction, truth=truth), path)
    with Image.open(path) as picture:
        smaller = picture.convert("RGB").resize(
            (WIDTH, picture.height * WIDTH // picture.width), Image.Resampling.LANCZOS
        )
    smaller.quantize(256, Image.Quantize.MAXCOVERAGE).save(path, optimize=True)


if __name__ == "__main__":
    main()
