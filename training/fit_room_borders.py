"""Fit the model that tells doors from mere narrow places (method `structure`), and measure it on buildings left out.

Run: python training/fit_room_borders.py [--data DIR].

The model learns on the paths that the merging takes: from the regions of a map, the likeliest pair that is one true
room is joined, again and again; each pair joined is an example of one room, and the likeliest of the others an example
of two. The model so far decides what is likely, so the paths are walked three times (Ross et al., DAgger, 2011).
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import fmean
from zlib import crc32

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression

from pianta.evaluation.coverage import Scores
from pianta.evaluation.segmentation import drop_small_rooms, score_labels
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.merging import (
    FEATURES,
    MODEL_FILE,
    MergeModel,
    describe_separators,
    find_active_separators,
    initial_rooms,
    join_rooms,
    read_default_merge_model,
)
from pianta.layout.structure.reconstruct import oversegment, reconstruct_structure
from pianta.layout.structure.regions import Regions, Separators
from pianta_bench.data.folders import find_data
from pianta_bench.data.map_sets import TrueMap, choose_sets

SETS = ("survey", "furniture", "schools", "clutter")
FOLDS, ROUNDS = 5, 3
# To cut one room in two costs less than to join two: log odds.
CAUTION = 0.5
# Spellings of one building in the data.
SAME = {"freiburgbuilding": "freiburg", "mapadj": "", "scan": "", "map15": "", "mapwithclutter": "", "y2": ""}


@dataclass(frozen=True, eq=False)
class Lesson:
    """A map in regions. overlap: shape (1 + P, 1 + T), cells that piece and true room share; those of room 0 are 0."""

    mapset: str
    item: str
    true_map: TrueMap
    regions: Regions
    separators: Separators
    overlap: NDArray[np.float64]

    @property
    def fold(self) -> int:
        """Number of the fold of the building; all maps of a building are in one."""
        return crc32(name_building(self.item).encode()) % FOLDS


@dataclass(frozen=True, eq=False)
class Example:
    """The features of a separator, whether it was between parts of one true room, and how much the example counts."""

    features: NDArray[np.float64]
    one_room: bool
    weight: float


def name_building(item: str) -> str:
    """The building that a map shows."""
    name = re.sub("[^a-z0-9]", "", item.lower())
    for spelling, same in SAME.items():
        name = name.replace(spelling, same)
    return name


def prepare_lessons(data: Path) -> Iterator[Lesson]:
    """Every map of the four sets, in regions."""
    for mapset, items in choose_sets(SETS, data).items():
        for item in items:
            true_map = mapset.read(data / mapset.folder, item)
            cut = oversegment(true_map.grid, StructureParameters())
            truth = np.where(true_map.free, true_map.spaces, 0) if mapset.free_only else true_map.spaces
            labels = cut.regions.labels
            sampled = cut.canvas.sample(truth)
            overlap = np.zeros((len(cut.regions.area), int(truth.max()) + 1))
            np.add.at(overlap, (labels.ravel(), sampled.ravel()), 1)
            overlap[0] = overlap[:, 0] = 0
            yield Lesson(mapset.name, item, true_map, cut.regions, cut.separators, overlap)


def walk_path(lesson: Lesson, model: MergeModel) -> list[Example]:
    """Examples of one path from the regions of a map to its true rooms; the more there are, the less each counts."""
    rooms, overlap = initial_rooms(lesson.regions), lesson.overlap.copy()
    met: dict[tuple[int, bool], list[NDArray[np.float64]]] = {}
    while len(active := find_active_separators(rooms, lesson.separators)):
        features = describe_separators(rooms, lesson.separators, active, resolution=lesson.regions.resolution)
        pairs = rooms.owner[lesson.separators.sides[active]]
        known = (overlap.sum(axis=1) > 0)[pairs].all(axis=1)
        true_room = overlap.argmax(axis=1)[pairs]
        one_room = known & (true_room[:, 0] == true_room[:, 1])
        odds = model.log_odds(features)
        others = known & ~one_room
        last = not one_room.any()
        shown = (
            np.flatnonzero(others) if last else [_likeliest(odds, which) for which in (one_room, others) if which.any()]
        )
        for i in shown:
            met.setdefault((int(active[i]), bool(one_room[i])), []).append(features[i])
        if last:
            break
        pair = np.sort(pairs[_likeliest(odds, one_room)])
        rooms = join_rooms(rooms, pair[None])
        overlap[pair[0]] += overlap[pair[1]]
        overlap[pair[1]] = 0
    weight = len(met) ** -0.5
    return [Example(one, which[1], weight / len(many)) for which, many in met.items() for one in many]


def _likeliest(odds: NDArray[np.float64], which: NDArray[np.bool_]) -> int:
    return int(np.where(which, odds, -np.inf).argmax())


def fit_model(examples: Sequence[Example]) -> MergeModel:
    """Logistic regression on standardised features."""
    features = np.array([example.features for example in examples])
    one_room = np.array([example.one_room for example in examples])
    weight = np.array([example.weight for example in examples])
    mean, spread = features.mean(axis=0), features.std(axis=0) + 1e-9
    regression = LogisticRegression().fit(
        (features - mean) / spread, one_room, sample_weight=0.3 * weight / weight.mean()
    )
    weights = regression.coef_[0] / spread
    constant = float(regression.intercept_[0] - mean @ weights) - CAUTION
    return MergeModel(tuple(np.round(weights, 4).tolist()), round(constant, 4))


def train_model(lessons: Sequence[Lesson]) -> MergeModel:
    """Model of the paths of some maps, walked three times."""
    model, examples = read_default_merge_model(), list[Example]()
    for _ in range(ROUNDS):
        examples += [example for lesson in lessons for example in walk_path(lesson, model)]
        model = fit_model(examples)
    return model


def score_lesson(lesson: Lesson, model: MergeModel) -> Scores:
    """Scores of the rooms of a map, counted as `pianta bench segmentation` counts them."""
    true_map = lesson.true_map
    floor = reconstruct_structure(true_map.grid, parameters=StructureParameters(), model=model)
    free = true_map.free if lesson.mapset == "schools" else np.ones(true_map.grid.shape, bool)
    found, truth = (
        drop_small_rooms(np.where(free, labels, 0), resolution=true_map.grid.resolution)
        for labels in (floor.label_image(true_map.grid), true_map.spaces)
    )
    return score_labels(found, truth)


def average_scores(scored: Iterable[tuple[str, Scores]]) -> dict[str, dict[str, float]]:
    """Means in % over the maps of each set, and rooms found over true ones."""
    by_set: dict[str, list[Scores]] = {}
    for name, scores in scored:
        by_set.setdefault(name, []).append(scores)
    means = {}
    for name, many in by_set.items():
        rows = [asdict(scores) for scores in many]
        shares = {
            key: round(100 * fmean(row[key] for row in rows), 1) for key in rows[0] if key not in ("found", "true")
        }
        means[name] = shares | {
            "found_per_true": round(sum(r["found"] for r in rows) / sum(r["true"] for r in rows), 3)
        }
    return means


def main() -> None:
    """Measure the model on buildings left out, then fit it to all of them and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
    lessons = list(prepare_lessons(find_data(parser.parse_args().data)))
    left_out = []
    for fold in range(FOLDS):
        model = train_model([lesson for lesson in lessons if lesson.fold != fold])
        left_out += [(lesson.mapset, score_lesson(lesson, model)) for lesson in lessons if lesson.fold == fold]
    means = average_scores(left_out)
    sys.stdout.write(f"on buildings left out: {json.dumps(means, indent=1)}\n")
    model = train_model(lessons)
    fitted = {"weights": dict(zip(FEATURES, model.weights, strict=True)), "constant": model.constant}
    MODEL_FILE.write_text(json.dumps(fitted | {"on_buildings_left_out": means}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
