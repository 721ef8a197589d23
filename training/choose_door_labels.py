"""Choose how much similar doors count in predictions of what is behind unopened doors (docs/methods/prediction.md).

Reads the file of `pianta bench prediction --json`, which has what the samples alone say about each door, and the floors
of its data. Each building is left out in turn: the constants with the least log loss on the doors of all other
buildings are used for its own. Prints these, the figures of the buildings left out, and the constants for all doors.

    pianta bench prediction --json prediction.json
    python training/choose_door_labels.py prediction.json --data shared/data
"""

from __future__ import annotations

import argparse
import itertools
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pianta._types import Floats, Mask
from pianta.generation.type_model import learn_type
from pianta.graphs.metrics import find_corridors
from pianta.labels import SCHEMAS, LabelConvention, LabelSchema
from pianta.prediction.explored_part import explore_by_corridors, read_explored_part
from pianta.prediction.open_ends import OpenEnds
from pianta.prediction.similar_doors import DoorWeights, SimilarDoors
from pianta_bench.graphs.measure import PARTS
from pianta_bench.harness.records import Results
from pianta_bench.prediction.measure import list_others, read_floors
from pianta_bench.prediction.scores import SAMPLED

# The constants that are tried.
SIZE_WIDTHS = (0.5, 1.0, np.inf)
LABEL_WIDTHS = (0.1, 0.2, np.inf)
ANY_DOORS = (1.0, 5.0)
FUNCTION_DOORS = (1.0, 5.0, 10.0)
SAMPLES_WEIGHTS = (0.0, 0.25, 0.5, 0.75)
# Share of the uniform distribution in that of the samples, which may not have the true label at all.
UNIFORM = 0.02

Constants = tuple[DoorWeights, float]
GRID: list[Constants] = [
    (DoorWeights(*weights), share)
    for *weights, share in itertools.product(SIZE_WIDTHS, LABEL_WIDTHS, ANY_DOORS, FUNCTION_DOORS, SAMPLES_WEIGHTS)
]


def list_predictions(doors: Sequence[dict[str, Any]], data: Path) -> Iterator[tuple[dict[str, Any], Floats]]:
    """Each door with its probabilities by the constants of GRID, shape (constants, labels)."""
    for building_type, part in PARTS.items():
        schema = SCHEMAS[building_type]
        floors = read_floors(Results({}, details={}), data, building_type)
        for name in dict.fromkeys(door["item"] for door in doors if door["part"] == part):
            ends = OpenEnds(learn_type(list_others(floors, name), schema))
            corridors = find_corridors(floors[name], schema, convention=LabelConvention.GRAPHS)
            stages = explore_by_corridors(floors[name], corridors)
            for number, stage in enumerate(stages, 1):
                own = [door for door in doors if (door["part"], door["item"], door["explored"]) == (part, name, number)]
                explored = read_explored_part(stage, schema)
                nodes = {explored.graph.nodes[door]["room"]: door for door in explored.doors}
                by_weights = {
                    weights: SimilarDoors(ends.examples, schema, weights).predict(explored)
                    for weights in {weights for weights, _ in GRID}
                    if own
                }
                for door in own:
                    similar = [[*by_weights[weights][nodes[door["door"]]].values()] for weights, _ in GRID]
                    shares = np.array([share for _, share in GRID])[:, None]
                    yield door, shares * smooth(door[SAMPLED], schema) + (1 - shares) * np.array(similar)


def smooth(labels: Mapping[str, float], schema: LabelSchema) -> Floats:
    """The probabilities of all labels of a schema, none of which is 0, shape (labels,)."""
    shares = np.array([labels.get(name, 0.0) for name in schema.by_name])
    uniform = np.full(len(shares), 1 / len(shares))
    return (1 - UNIFORM) * shares + UNIFORM * uniform if shares.any() else uniform


@dataclass(frozen=True, eq=False)
class Outcomes:
    """Of each door by the constants of GRID the log loss, nats, and whether the top label is right.

    loss, right: shape (doors, constants). first: whether this is the first stage that has the door, shape (doors,).
    """

    doors: list[dict[str, Any]]
    loss: Floats
    right: Mask
    first: Mask


def score(doors: Sequence[dict[str, Any]], data: Path) -> Outcomes:
    """Score the predictions of all doors by all constants."""
    scored, losses, right, first = [], [], [], []
    earlier: set[tuple[str, str, str]] = set()
    for door, probabilities in list_predictions(doors, data):
        schema = SCHEMAS[next(building_type for building_type, part in PARTS.items() if part == door["part"])]
        true = [*schema.by_name].index(door["true"])
        scored.append(door)
        losses.append(-np.log(probabilities[:, true]))
        right.append(probabilities.argmax(axis=1) == true)
        key = door["part"], door["item"], door["door"]
        first.append(key not in earlier)
        earlier.add(key)
    return Outcomes(scored, np.array(losses), np.array(right), np.array(first))


def main() -> None:
    """Print the constants of each building left out, the figures of these, and the constants for all doors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, help="of pianta bench prediction --json")
    parser.add_argument("--data", type=Path, required=True, help="folder of the data")
    options = parser.parse_args()
    outcomes = score(json.loads(options.file.read_text(encoding="utf-8"))["doors"], options.data)
    buildings = np.array([f"{door['part']}/{door['building']}" for door in outcomes.doors])
    chosen = {
        building: int(outcomes.loss[outcomes.first & (buildings != building)].mean(axis=0).argmin())
        for building in dict.fromkeys(buildings.tolist())
    }
    for index, count in Counter(chosen.values()).most_common():
        print(f"{count} of {len(chosen)} buildings left out: {GRID[index][0]}, samples {GRID[index][1]}")
    used = np.array([chosen[building] for building in buildings.tolist()])
    every = np.arange(len(used))
    for part in PARTS.values():
        in_part = np.array([door["part"] == part for door in outcomes.doors])
        half = np.array([door["half"] for door in outcomes.doors])
        for stage, rows in (("half of the corridors", in_part & half), ("first seen", in_part & outcomes.first)):
            right, loss = 100 * outcomes.right[every, used][rows].mean(), outcomes.loss[every, used][rows].mean()
            print(f"{part}, {stage}: {rows.sum()} doors, {right:.1f} % right, log loss {loss:.3f} nats")
    best = int(outcomes.loss[outcomes.first].mean(axis=0).argmin())
    print(f"all doors: {GRID[best][0]}, samples {GRID[best][1]}")


if __name__ == "__main__":
    main()
