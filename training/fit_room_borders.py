"""Fit the model that distinguishes doors from other necks (method `structure`), with cross-validation by building.

Run: python training/fit_room_borders.py [--data DIR].

The model learns on sequences of merges. Starting from the regions of a map, the pair with the highest log odds among
those of one true room is joined, again and again; each joined pair is an example of one room, and the pair with the
highest log odds among the others an example of two. The log odds are those of the current model, so the sequences are
repeated in three rounds (Ross et al., DAgger, 2011).
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
# Folds of the cross-validation.
FOLDS = 5
# Rounds of DAgger.
ROUNDS = 3
# Subtracted from the log odds of one room, because splitting one room is a smaller error than joining two (chosen by
# hand).
CAUTION = 0.5
# Weight of the mean example against the penalty of the regression (chosen by hand).
SAMPLE_WEIGHT = 0.3
# Substitutions that give the maps of one building the same name.
SPELLINGS = {"freiburgbuilding": "freiburg", "mapadj": "", "scan": "", "map15": "", "mapwithclutter": "", "y2": ""}


@dataclass(frozen=True, eq=False)
class TrainingMap:
    """A map cut into regions. overlap: shape (1 + R, 1 + T), common cells of region and true room; 0 for number 0."""

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
    """The features of a separator, whether both sides are in one true room, and the weight of the example."""

    features: NDArray[np.float64]
    one_room: bool
    weight: float


def name_building(item: str) -> str:
    """Name of the building of a map."""
    name = re.sub("[^a-z0-9]", "", item.lower())
    for spelling, substitute in SPELLINGS.items():
        name = name.replace(spelling, substitute)
    return name


def read_training_maps(data: Path) -> Iterator[TrainingMap]:
    """All maps of the four sets, cut into regions."""
    for mapset, items in choose_sets(SETS, data).items():
        for item in items:
            true_map = mapset.read(data / mapset.folder, item)
            cut = oversegment(true_map.grid, StructureParameters())
            truth = np.where(true_map.free, true_map.spaces, 0) if mapset.free_only else true_map.spaces
            labels = cut.regions.labels
            sampled = cut.working_grid.sample(truth)
            overlap = np.zeros((len(cut.regions.area), int(truth.max()) + 1))
            np.add.at(overlap, (labels.ravel(), sampled.ravel()), 1)
            overlap[0] = overlap[:, 0] = 0
            yield TrainingMap(mapset.name, item, true_map, cut.regions, cut.separators, overlap)


def list_examples(training_map: TrainingMap, model: MergeModel) -> list[Example]:
    """Examples of the merges from the regions of a map to its true rooms; the weights of many examples are lower."""
    rooms, overlap = initial_rooms(training_map.regions), training_map.overlap.copy()
    separator_features: dict[tuple[int, bool], list[NDArray[np.float64]]] = {}
    while len(active := find_active_separators(rooms, training_map.separators)):
        features = describe_separators(
            rooms, training_map.separators, active, resolution=training_map.regions.resolution
        )
        pairs = rooms.owner[training_map.separators.sides[active]]
        labelled = (overlap.sum(axis=1) > 0)[pairs].all(axis=1)
        true_room = overlap.argmax(axis=1)[pairs]
        one_room = labelled & (true_room[:, 0] == true_room[:, 1])
        log_odds = model.log_odds(features)
        two_rooms = labelled & ~one_room
        last = not one_room.any()
        if last:
            chosen = np.flatnonzero(two_rooms).tolist()
        else:
            chosen = [_likeliest(log_odds, mask) for mask in (one_room, two_rooms) if mask.any()]
        for i in chosen:
            separator_features.setdefault((int(active[i]), bool(one_room[i])), []).append(features[i])
        if last:
            break
        pair = np.sort(pairs[_likeliest(log_odds, one_room)])
        rooms = join_rooms(rooms, pair[None])
        overlap[pair[0]] += overlap[pair[1]]
        overlap[pair[1]] = 0
    weight = len(separator_features) ** -0.5
    return [
        Example(features, one_room, weight / len(group))
        for (_, one_room), group in separator_features.items()
        for features in group
    ]


def _likeliest(log_odds: NDArray[np.float64], mask: NDArray[np.bool_]) -> int:
    return int(np.where(mask, log_odds, -np.inf).argmax())


def fit_model(examples: Sequence[Example]) -> MergeModel:
    """Logistic regression on standardised features."""
    features = np.array([example.features for example in examples])
    one_room = np.array([example.one_room for example in examples])
    weight = np.array([example.weight for example in examples])
    mean, spread = features.mean(axis=0), features.std(axis=0) + 1e-9
    regression = LogisticRegression().fit(
        (features - mean) / spread, one_room, sample_weight=SAMPLE_WEIGHT * weight / weight.mean()
    )
    weights = regression.coef_[0] / spread
    constant = float(regression.intercept_[0] - mean @ weights) - CAUTION
    return MergeModel(tuple(np.round(weights, 4).tolist()), round(constant, 4))


def train_model(training_maps: Sequence[TrainingMap]) -> MergeModel:
    """Model of the examples of all rounds on the maps."""
    model, examples = read_default_merge_model(), list[Example]()
    for _ in range(ROUNDS):
        examples += [example for item in training_maps for example in list_examples(item, model)]
        model = fit_model(examples)
    return model


def score_map(training_map: TrainingMap, model: MergeModel) -> Scores:
    """Scores of the rooms of a map, defined as in `pianta bench segmentation`."""
    true_map = training_map.true_map
    floor = reconstruct_structure(true_map.grid, parameters=StructureParameters(), model=model)
    free = true_map.free if training_map.mapset == "schools" else np.ones(true_map.grid.shape, bool)
    predicted, truth = (
        drop_small_rooms(np.where(free, labels, 0), resolution=true_map.grid.resolution)
        for labels in (floor.label_image(true_map.grid), true_map.spaces)
    )
    return score_labels(predicted, truth)


def average_scores(scored: Iterable[tuple[str, Scores]]) -> dict[str, dict[str, float]]:
    """Means in % over the maps of each set, and number of predicted rooms over true ones."""
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
    """Cross-validate the model by building, then fit it to all buildings and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
    training_maps = list(read_training_maps(find_data(parser.parse_args().data)))
    left_out = []
    for fold in range(FOLDS):
        model = train_model([item for item in training_maps if item.fold != fold])
        left_out += [(item.mapset, score_map(item, model)) for item in training_maps if item.fold == fold]
    means = average_scores(left_out)
    sys.stdout.write(f"on buildings left out: {json.dumps(means, indent=1)}\n")
    model = train_model(training_maps)
    fitted = {"weights": dict(zip(FEATURES, model.weights, strict=True)), "constant": model.constant}
    MODEL_FILE.write_text(json.dumps(fitted | {"on_buildings_left_out": means}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
