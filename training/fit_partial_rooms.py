"""Fit the model that says how well a hypothesis of a partial room fits, and measure it on buildings left out.

Run: python training/fit_partial_rooms.py [--data DIR] [--rounds N].

The model learns from simulated robots that have explored drawn schools, offices and made-up floors in part: of each
room that is found partial it sees every hypothesis and its IoU with the true room. Schools that data/partial shows are
left out, so that `pianta bench partial` tells how the model does on buildings that it has never seen. The folds are by
floor: the floors of one building can be in several.
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
from pianta.layout.partial.scene import ObservedCells, build_scene
from pianta.layout.reconstruct import find_rooms
from pianta_bench.data.annotated_floors import read_drawing
from pianta_bench.data.folders import find_data
from pianta_bench.partial.maps import PartialMap, simulate_drawing, simulate_world

FOLDS, ROUNDS, WORLDS = 4, 3, 16
# Perceptrons that are averaged, and cells of the hidden layer of each; weight of the penalty.
NETS, HIDDEN, PENALTY = 4, 24, 0.01
# Of each room so many hypotheses are learned from.
MOST_HYPOTHESES = 60
# Every so many maps are read by the thesis' method too.
THESIS_EVERY = 4
A_THIRD = 1 / 3


@dataclass(frozen=True, eq=False)
class Lesson:
    """The hypotheses of a partial room.

    features: shape (N, 26). iou: shape (N,), with the true room; that of the seen part comes first. seen: its IoU
    without walls. share: of the true room that was seen.
    """

    building: str
    features: NDArray[np.float64]
    iou: NDArray[np.float64]
    seen: float
    share: float

    @property
    def fold(self) -> int:
        """Number of the fold of the building."""
        return crc32(self.building.encode()) % FOLDS


@dataclass(frozen=True)
class Job:
    """A map to simulate: a drawing, or a world where there is none."""

    drawing: Path | None
    seed: int


def list_jobs(data: Path, rounds: int) -> list[Job]:
    """Each drawing so many times, and made-up worlds."""
    known = {folder.name for folder in (data / "partial").iterdir()}
    files = [file for kind in ("school", "office") for file in sorted((data / "buildings" / kind).glob("*.xml"))]
    left = [file for file in files if file.stem not in known]
    drawn = [Job(file, 1000 * i + j) for i in range(rounds) for j, file in enumerate(left)]
    return drawn + [Job(None, i) for i in range(WORLDS * rounds)]


def do_job(job: Job) -> list[Lesson]:
    """The lessons of a map; none where nothing can be made of it."""
    try:
        if job.drawing:
            known, name = simulate_drawing(read_drawing(job.drawing), seed=job.seed), job.drawing.stem
        else:
            known, name = simulate_world(job.seed, first_seed=0), f"world {job.seed}"
        methods = ("structure", "thesis") if job.seed % THESIS_EVERY == 0 else ("structure",)
        floors = [find_rooms(known.grid, method=method) for method in methods]
        return [lesson for floor in floors for lesson in learn_floor(name, floor, known)]
    except PiantaError:
        return []


def learn_floor(name: str, floor: Floor, known: PartialMap) -> Iterator[Lesson]:
    """A lesson for each partial room that lies in a true one."""
    true, sight = np.array(known.rooms, dtype=object), ObservedCells.of(known.grid)
    for room in floor.rooms:
        shared = area_of(intersection(true, room.polygon))
        if not room.partial or not shared.any():
            continue
        scene = build_scene(floor, room, sight)
        best: Polygon = true[int(shared.argmax())]
        truth = scene.view.draw([best])
        hypotheses = list_hypotheses(scene)
        iou = []
        for hypothesis in hypotheses:
            cells = np.zeros_like(scene.seen)
            cells[hypothesis.window] = hypothesis.cells
            # Half a wall is about a cell
            whole = cells | (grow_mask(cells, 1) & ~scene.others)
            iou.append((whole & truth).sum() / max(1, (whole | truth).sum()))
        seen = (scene.seen & truth).sum() / max(1, (scene.seen | truth).sum())
        features = np.array([hypothesis.features for hypothesis in hypotheses])
        yield Lesson(name, features, np.array(iou), float(seen), float(shared.max() / best.area))


def fit_model(lessons: Sequence[Lesson]) -> PartialModel:
    """The mean of perceptrons, which is one with all their hidden cells."""
    rng = np.random.default_rng(0)
    features, iou = [], []
    for lesson in lessons:
        order = rng.permutation(len(lesson.iou))[:MOST_HYPOTHESES]
        features.append(lesson.features[order])
        iou.append(lesson.iou[order])
    every, target = np.concatenate(features), np.concatenate(iou)
    means, spreads = every.mean(axis=0), every.std(axis=0) + 1e-6
    standard = ((every - means) / spreads).clip(-4, 4)
    nets = [
        MLPRegressor(
            hidden_layer_sizes=(HIDDEN,), alpha=PENALTY, early_stopping=True, learning_rate_init=0.003, random_state=i
        ).fit(standard, target)
        for i in range(NETS)
    ]
    hidden = np.concatenate([net.coefs_[0] for net in nets], axis=1)
    bias = np.concatenate([net.intercepts_[0] for net in nets])
    output = np.concatenate([net.coefs_[1][:, 0] for net in nets]) / NETS
    return PartialModel(means, spreads, hidden, bias, output, float(np.mean([net.intercepts_[1][0] for net in nets])))


def score_lessons(lessons: Sequence[Lesson], models: Sequence[PartialModel]) -> dict[str, float]:
    """Means over rooms of which a third was seen, each judged by the model that has not seen its building; %."""
    chosen = [lesson for lesson in lessons if lesson.share >= A_THIRD]
    expected = [models[lesson.fold].predict_iou(lesson.features) for lesson in chosen]
    picked = [lesson.iou[says.argmax()] for lesson, says in zip(chosen, expected, strict=True)]
    means = {
        "seen": fmean(lesson.seen for lesson in chosen),
        "predicted": fmean(picked),
        "best hypothesis": fmean(lesson.iou.max() for lesson in chosen),
        "confidence": fmean(says.max() for says in expected),
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
    """Measure the model on buildings left out, then fit it to all of them and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="how often each drawing is explored")
    options = parser.parse_args()
    jobs = list_jobs(find_data(options.data), options.rounds)
    with Pool() as pool:
        lessons = [lesson for of_map in pool.imap(do_job, jobs) for lesson in of_map]
    folds = [fit_model([lesson for lesson in lessons if lesson.fold != fold]) for fold in range(FOLDS)]
    left_out = score_lessons(lessons, folds)
    sys.stdout.write(f"on buildings left out: {json.dumps(left_out, indent=1)}\n")
    write_model(fit_model(lessons), left_out)


if __name__ == "__main__":
    main()
