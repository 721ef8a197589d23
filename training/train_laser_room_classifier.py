"""Train the classifier of `pianta read --method features` on synthetic floors, and write it as JSON.

Run: python training/train_laser_room_classifier.py.
"""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from shapely import unary_union
from sklearn.ensemble import AdaBoostClassifier
from sklearn.tree import DecisionTreeClassifier

from pianta.floor import Floor, cells_of_polygon
from pianta.gridmap import GridMap
from pianta.layout.rivals.features import PLACE_CLASSES, choose_cells, describe_scans, scan_cells
from pianta.models import MODELS
from pianta.worlds.floors import FLOOR_MAKERS
from pianta.worlds.scan import simulate_map

MODEL = MODELS / "laser_room_classifier.json"
WEAK_CLASSIFIERS = 350
SEEDS = range(4)
FURNITURE = (0.0, 0.4, 1.0)
# Cells within this distance of the line of a door are in the doorway, metres.
DOOR_DEPTH = 0.3
# Side of the squares with one scan each, metres.
SPACING = 1.0


def make_training_maps() -> Iterator[tuple[Floor, GridMap]]:
    """Floors of every type, with narrow and wide corridors and rooms, and their maps, bare and furnished."""
    for name, make in FLOOR_MAKERS.items():
        for seed in SEEDS:
            rng = np.random.default_rng([seed, len(name)])
            options = {"room_depth": 3.5 + 4.5 * rng.random(), "room_width": (2.2, 3.0 + 6.0 * rng.random())}
            if name != "hall":
                options["corridor_width"] = 1.6 + 1.6 * rng.random()
            floor = make(seed=seed, **options)
            for furniture in FURNITURE:
                yield floor, simulate_map(floor, furniture=furniture, noise=0.3 * (seed % 2), seed=seed)


def label_cells(floor: Floor, grid: GridMap) -> NDArray[np.int32]:
    """Index in PLACE_CLASSES of each cell of a map, shape (H, W); -1 outside the building."""
    corridors = [room.id for room in floor.rooms if room.label == "CORRIDOR"]
    ids = floor.label_image(grid)
    classes = np.select(
        [np.isin(ids, corridors), ids > 0], [PLACE_CLASSES.index("corridor"), PLACE_CLASSES.index("room")], -1
    )
    for doorway in unary_union([door.line.buffer(DOOR_DEPTH, cap_style="flat") for door in floor.doors]).geoms:
        rows, cols, inside = cells_of_polygon(doorway, grid)
        classes[rows, cols][inside] = PLACE_CLASSES.index("doorway")
    return np.asarray(classes, np.int32)


def collect_scans() -> tuple[dict[str, NDArray[np.float64]], NDArray[np.int32]]:
    """Features of scans all over the training maps, by name, and their place classes."""
    features, classes = [], []
    for floor, grid in make_training_maps():
        truth = label_cells(floor, grid)
        cells = choose_cells(grid.free & (truth >= 0), round(SPACING / grid.resolution))
        doorway = np.argwhere(grid.free & (truth == PLACE_CLASSES.index("doorway")))[::40]
        cells = np.concatenate([cells, doorway.astype(np.int32)])
        features.append(describe_scans(scan_cells(grid.free, cells, grid.resolution)))
        classes.append(truth[tuple(cells.T)])
    return {name: np.concatenate([part[name] for part in features]) for name in features[0]}, np.concatenate(classes)


def train_stumps(features: dict[str, NDArray[np.float64]], classes: NDArray[np.int32]) -> list[list[object]]:
    """AdaBoost of decision stumps, each as feature, threshold, class up to it, class beyond it, weight."""
    names = list(features)
    share = np.bincount(classes, minlength=len(PLACE_CLASSES)) / len(classes)
    boosted = AdaBoostClassifier(DecisionTreeClassifier(max_depth=1), n_estimators=WEAK_CLASSIFIERS, random_state=0)
    boosted.fit(np.column_stack(list(features.values())), classes, sample_weight=1 / share[classes])
    stumps = []
    for tree, weight in zip(boosted.estimators_, boosted.estimator_weights_, strict=True):
        chosen = boosted.classes_[tree.tree_.value[:, 0].argmax(axis=1)]
        threshold = float(np.float32(tree.tree_.threshold[0]))
        stumps.append([names[tree.tree_.feature[0]], threshold, *chosen[1:].tolist(), round(float(weight), 6)])
    return stumps


def main() -> None:
    """Train and write the model; print how many scans it was trained on."""
    features, classes = collect_scans()
    stumps = train_stumps(features, classes)
    lines = ",\n".join(json.dumps(stump) for stump in stumps)
    MODEL.write_text(f'{{"places": {json.dumps(PLACE_CLASSES)}, "stumps": [\n{lines}\n]}}\n', encoding="utf-8")
    print(f"{len(classes)} scans, {len(stumps)} stumps, in {MODEL}")


if __name__ == "__main__":
    main()
