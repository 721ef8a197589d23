"""Fit the model that predicts the IoU of a hypothesis for a partial room, with cross-validation by building.

Run: python training/fit_partial_rooms.py [--data DIR] [--jobs N].

The model learns from the maps of partial_maps.py: from every hypothesis for each partial room, and its IoU with the
true room. Buildings of data/partial and of VALIDATION are not among them, so that `pianta bench partial` and
benchmarks/score_partial_rooms.py measure the model on unknown buildings; all maps and floors of one building are in
one fold.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from multiprocessing import Pool
from pathlib import Path
from statistics import fmean

import numpy as np
from numpy.typing import NDArray
from partial_maps import VALIDATION, WORLD, Job, add_data_option, list_jobs
from shapely import Polygon, intersection
from shapely import area as area_of
from sklearn.neural_network import MLPRegressor

from pianta.errors import PiantaError
from pianta.evaluation.folds import leave_buildings_out
from pianta.floor import Floor
from pianta.layout._label_images import grow_mask
from pianta.layout.partial.hypotheses import FEATURES, list_hypotheses
from pianta.layout.partial.predict import MODEL_FILE, PartialModel
from pianta.layout.partial.scene import FloorIndex, ObservedCells, build_scene, find_main_direction, make_view
from pianta.layout.reconstruct import find_rooms
from pianta_bench.data.folders import find_data
from pianta_bench.partial.maps import PartialMap

# The constants were chosen by hand.
# Folds of the cross-validation.
FOLDS = 4
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
# Explorations of each map that the model learns from; a limit of time.
EXPLORATIONS = 2
# Made floors that the model learns from.
WORLDS = 40
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


def read_examples(job: Job, data: Path) -> list[Example]:
    """The examples of a map; empty if it cannot be made or reconstructed."""
    try:
        partial_map = job.read(data)
        methods = ("structure", "thesis") if job.seed % THESIS_EVERY == 0 else ("structure",)
        floors = [find_rooms(partial_map.grid, method=method) for method in methods]
        return [example for floor in floors for example in list_examples(job.building, floor, partial_map)]
    except PiantaError:
        return []


def is_chosen(job: Job) -> bool:
    """Whether the model learns from a map."""
    return job.building not in VALIDATION and job.number < (WORLDS if job.source == WORLD else EXPLORATIONS)


def list_examples(building: str, floor: Floor, partial_map: PartialMap) -> Iterator[Example]:
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
        yield Example(building, features, np.array(iou), float(observed_iou), float(shared.max() / best.area))


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


def cross_validate(examples: Sequence[Example]) -> dict[str, float]:
    """Means over rooms of which a third was observed, by the model that was not fitted to their building; %."""
    chosen: list[tuple[Example, NDArray[np.float64]]] = []
    for others, own in leave_buildings_out([example.building for example in examples], parts=FOLDS):
        model = fit_model([examples[i] for i in others])
        tested = [examples[i] for i in own if examples[i].share >= MIN_OBSERVED_SHARE]
        chosen += [(example, model.predict_iou(example.features)) for example in tested]
    means = {
        "seen": fmean(example.observed_iou for example, _ in chosen),
        "predicted": fmean(example.iou[expected.argmax()] for example, expected in chosen),
        "best hypothesis": fmean(example.iou.max() for example, _ in chosen),
        "confidence": fmean(expected.max() for _, expected in chosen),
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
    """Cross-validate the model by building, then fit it to all buildings and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_data_option(parser)
    parser.add_argument("--jobs", type=int, help="number of processes, one for each core unless given")
    options = parser.parse_args()
    data = find_data(options.data)
    with Pool(options.jobs) as pool:
        read = partial(read_examples, data=data)
        chosen = filter(is_chosen, list_jobs(data))
        examples = [example for map_examples in pool.imap(read, chosen) for example in map_examples]
    left_out = cross_validate(examples)
    sys.stdout.write(f"on buildings left out: {json.dumps(left_out, indent=1)}\n")
    write_model(fit_model(examples), left_out)


if __name__ == "__main__":
    main()
