"""Fit the model that predicts the IoU of a hypothesis for a partial room, with cross-validation by floor.

Run: python training/fit_partial_rooms.py [--data DIR] [--rounds N].

The model learns from simulated robots that have explored a part of drawn schools and offices, and of synthetic floors:
from every hypothesis for each partial room, and its IoU with the true room. Schools of data/partial are left out, so
that `pianta bench partial` measures the model on unknown buildings. The folds are by floor: the floors of one building
can be in different folds.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import Pool
from pathlib import Path
from statistics import fmean
from zlib import crc32

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon, intersection
from shapely import area as area_of
from sklearn.neural_network import MLPRegressor

from pianta.errors import PiantaError
from pianta.floor import Floor
from pianta.layout._label_images import grow_mask
from pianta.layout.partial.hypotheses import FEATURES, list_hypotheses
from pianta.layout.partial.predict import MODEL_FILE, PartialModel
from pianta.layout.partial.scene import FloorIndex, ObservedCells, build_scene, find_main_direction, make_view
from pianta.layout.reconstruct import find_rooms
from pianta_bench.data.annotated_floors import read_drawing
from pianta_bench.data.folders import find_data
from pianta_bench.partial.maps import PartialMap, simulate_drawing, simulate_world

# The constants were chosen by hand.
# Folds of the cross-validation.
FOLDS = 4
# Simulated maps of each drawing.
ROUNDS = 3
# Synthetic floors in each round.
WORLDS = 16
# Perceptrons that are averaged.
NETS = 4
# Units in the hidden layer of each.
HIDDEN = 24
# Weight of the L2 penalty.
PENALTY = 0.01
# Step of the optimiser at the beginning.
LEARNING_RATE = 0.003
# Hypotheses of each room that the model learns from, at most.
MAX_HYPOTHESES = 60
# One in this number of maps is reconstructed by the method of the thesis too.
THESIS_EVERY = 4
# Rooms with at least this share observed count in the scores, as in `pianta bench partial`.
MIN_OBSERVED_SHARE = 1 / 3


@dataclass(frozen=True, eq=False)
class Example:
    """The hypotheses for a partial room.

    features: shape (N, 26). iou: shape (N,), with the true room; that of the observed part comes first. observed_iou:
    IoU of the observed part without walls. share: observed share of the true room.
    """

    building: str
    features: NDArray[np.float64]
    iou: NDArray[np.float64]
    observed_iou: float
    share: float

    @property
    def fold(self) -> int:
        """Number of the fold of the building."""
        return crc32(self.building.encode()) % FOLDS


@dataclass(frozen=True)
class Job:
    """A map to simulate: of a drawing, or of a synthetic floor if there is no drawing."""

    drawing: Path | None
    seed: int


def list_jobs(data: Path, rounds: int) -> list[Job]:
    """Maps of each drawing and of synthetic floors in a number of rounds."""
    benchmark = {folder.name for folder in (data / "partial").iterdir()}
    files = [file for folder in ("school", "office") for file in sorted((data / "buildings" / folder).glob("*.xml"))]
    drawings = [file for file in files if file.stem not in benchmark]
    jobs = [Job(file, 1000 * i + j) for i in range(rounds) for j, file in enumerate(drawings)]
    return jobs + [Job(None, i) for i in range(WORLDS * rounds)]


def do_job(job: Job) -> list[Example]:
    """The examples of a map; empty if it cannot be simulated or reconstructed."""
    try:
        if job.drawing:
            partial_map, name = simulate_drawing(read_drawing(job.drawing), seed=job.seed), job.drawing.stem
        else:
            partial_map, name = simulate_world(job.seed, first_seed=0), f"world {job.seed}"
        methods = ("structure", "thesis") if job.seed % THESIS_EVERY == 0 else ("structure",)
        floors = [find_rooms(partial_map.grid, method=method) for method in methods]
        return [example for floor in floors for example in list_examples(name, floor, partial_map)]
    except PiantaError:
        return []


def list_examples(name: str, floor: Floor, partial_map: PartialMap) -> Iterator[Example]:
    """An example for each partial room that overlaps a true one."""
    true_rooms, observed_cells = np.array(partial_map.rooms, dtype=object), ObservedCells.from_grid(partial_map.grid)
    index = FloorIndex.from_floor(floor)
    for room in floor.rooms:
        shared = area_of(intersection(true_rooms, room.polygon))
        if not room.partial or not shared.any():
            continue
        view = make_view(room, find_main_direction(index, room), partial_map.grid)
        scene = build_scene(index, room, observed_cells, view)
        best: Polygon = true_rooms[int(shared.argmax())]
        truth = scene.view.draw([best])
        hypotheses = list_hypotheses(scene)
        iou = []
        for hypothesis in hypotheses:
            cells = np.zeros_like(scene.observed)
            cells[hypothesis.window] = hypothesis.cells
            # Half a wall is about one cell
            with_walls = cells | (grow_mask(cells, 1) & ~scene.others)
            iou.append((with_walls & truth).sum() / max(1, (with_walls | truth).sum()))
        observed_iou = (scene.observed & truth).sum() / max(1, (scene.observed | truth).sum())
        features = np.array([hypothesis.features for hypothesis in hypotheses])
        yield Example(name, features, np.array(iou), float(observed_iou), float(shared.max() / best.area))


def fit_model(examples: Sequence[Example]) -> PartialModel:
    """The mean of perceptrons, as one perceptron with the hidden units of all."""
    rng = np.random.default_rng(0)
    features, iou = [], []
    for example in examples:
        order = rng.permutation(len(example.iou))[:MAX_HYPOTHESES]
        features.append(example.features[order])
        iou.append(example.iou[order])
    inputs, target = np.concatenate(features), np.concatenate(iou)
    means, spreads = inputs.mean(axis=0), inputs.std(axis=0) + 1e-6
    standard = ((inputs - means) / spreads).clip(-4, 4)
    nets = [
        MLPRegressor(
            hidden_layer_sizes=(HIDDEN,),
            alpha=PENALTY,
            early_stopping=True,
            learning_rate_init=LEARNING_RATE,
            random_state=i,
        ).fit(standard, target)
        for i in range(NETS)
    ]
    hidden = np.concatenate([net.coefs_[0] for net in nets], axis=1)
    bias = np.concatenate([net.intercepts_[0] for net in nets])
    output = np.concatenate([net.coefs_[1][:, 0] for net in nets]) / NETS
    return PartialModel(means, spreads, hidden, bias, output, float(np.mean([net.intercepts_[1][0] for net in nets])))


def score_models(examples: Sequence[Example], models: Sequence[PartialModel]) -> dict[str, float]:
    """Means over rooms of which a third was observed, predicted by the model that was not fitted to their floor; %."""
    chosen = [example for example in examples if example.share >= MIN_OBSERVED_SHARE]
    expected = [models[example.fold].predict_iou(example.features) for example in chosen]
    best = [example.iou[iou.argmax()] for example, iou in zip(chosen, expected, strict=True)]
    means = {
        "seen": fmean(example.observed_iou for example in chosen),
        "predicted": fmean(best),
        "best hypothesis": fmean(example.iou.max() for example in chosen),
        "confidence": fmean(iou.max() for iou in expected),
    }
    return {"rooms": len(chosen)} | {name: round(100 * float(mean), 1) for name, mean in means.items()}


def write_model(model: PartialModel, left_out: dict[str, float], path: Path = MODEL_FILE) -> None:
    """Write the model, rounded, as JSON."""
    by_name = {
        key: {name: np.round(getattr(model, key)[i], 4).tolist() for i, name in enumerate(FEATURES)}
        for key in ("means", "spreads", "hidden")
    }
    rest = {key: np.round(getattr(model, key), 4).tolist() for key in ("hidden_bias", "output")}
    content = {**by_name, **rest, "output_bias": round(model.output_bias, 4), "on_buildings_left_out": left_out}
    lines = ",\n".join(f"{json.dumps(key)}: {json.dumps(value)}" for key, value in content.items())
    path.write_text("{\n" + lines + "\n}\n", encoding="utf-8")


def main() -> None:
    """Cross-validate the model by floor, then fit it to all floors and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="number of simulated maps of each drawing")
    options = parser.parse_args()
    jobs = list_jobs(find_data(options.data), options.rounds)
    with Pool() as pool:
        examples = [example for map_examples in pool.imap(do_job, jobs) for example in map_examples]
    folds = [fit_model([example for example in examples if example.fold != fold]) for fold in range(FOLDS)]
    left_out = score_models(examples, folds)
    sys.stdout.write(f"on buildings left out: {json.dumps(left_out, indent=1)}\n")
    write_model(fit_model(examples), left_out)


if __name__ == "__main__":
    main()
