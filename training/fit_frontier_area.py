"""Fit the perceptron that says how much area is behind a frontier, on simulated runs in the schools of the data.

    python training/fit_frontier_area.py [--data DIR] [--fold 0|1] [--jobs N] -o frontier_area.json

Writes the weights that src/pianta/models/frontier_area.json has. What is predicted beyond open ends comes from
models without the school. --fold leaves every other school out, so that those can be judged.
"""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from skimage.segmentation import watershed
from sklearn.neural_network import MLPRegressor
from sklearn.preprocessing import StandardScaler

from pianta._types import Floats
from pianta.exploration.classical_policies import InformationGain, NearestFrontier
from pianta.exploration.expectations import RoomExpectations
from pianta.exploration.explore import explore
from pianta.exploration.frontier_area import measure_frontiers
from pianta.exploration.frontiers import Frontier
from pianta.exploration.situation import Policy, Situation
from pianta.exploration.starts import find_starts
from pianta.exploration.world import World, build_world
from pianta.generation.type_model import learn_type
from pianta.gridmap import UNKNOWN
from pianta.labels import SCHEMAS
from pianta.prediction.unexplored_part import FloorSampler
from pianta_bench.data.folders import find_data
from pianta_bench.exploration.buildings import ExploredBuilding, read_buildings

RESOLUTION, EVERY, STOP, LESSONS = 0.2, 3, 0.98, 120_000
HIDDEN = (24, 12)


class Watcher:
    """A policy that takes lessons while another decides: measures of frontiers, and the area that really is there."""

    def __init__(self, policy: Policy, expectations: RoomExpectations, world: World) -> None:
        self.policy, self.expectations, self.world = policy, expectations, world
        self.lessons: list[Floats] = []

    def choose(self, situation: Situation) -> list[Frontier | None]:
        """As the other policy."""
        if situation.decision % EVERY == 0:
            measured, _ = measure_frontiers(situation, self.expectations)
            self.lessons.append(np.column_stack([measured, np.sqrt(measure_true_areas(situation, self.world))]))
        return self.policy.choose(situation)


def measure_true_areas(situation: Situation, world: World) -> Floats:
    """Unknown free area of the world nearest to each frontier, on foot through the unknown, m², shape (frontiers,)."""
    markers = np.zeros(situation.known.shape, np.int32)
    for place, frontier in enumerate(situation.frontiers, 1):
        markers[tuple(frontier.cells.T)] = place
    hidden = (situation.known == UNKNOWN) & world.free
    nearest = watershed(np.zeros(markers.shape), markers, mask=hidden | (markers > 0))
    counts = np.bincount(nearest[hidden], minlength=len(situation.frontiers) + 1)[1:]
    return np.asarray(counts * situation.resolution**2, float)


def take_lessons(building: ExploredBuilding) -> Floats:
    """Lessons of one school, by both classical policies."""
    warnings.simplefilter("ignore")
    world = build_world(building.floor, resolution=RESOLUTION)
    sampler = FloorSampler(learn_type(building.others, SCHEMAS["school"]))
    found = []
    for make in (InformationGain, NearestFrontier):
        watcher = Watcher(make(), RoomExpectations(sampler), world)
        explore(world, watcher, starts=find_starts(world)[:1], stop=STOP)
        found += watcher.lessons
    return np.concatenate(found)


def fit(lessons: Floats, seed: int = 0) -> dict[str, list[object]]:
    """The weights of the perceptron."""
    order = np.random.default_rng(seed).permutation(len(lessons))[:LESSONS]
    scaler = StandardScaler().fit(lessons[order, :-1])
    network = MLPRegressor(hidden_layer_sizes=HIDDEN, random_state=seed, max_iter=60, early_stopping=True, alpha=1e-3)
    network.fit(scaler.transform(lessons[order, :-1]), lessons[order, -1])
    weights = {"mean": scaler.mean_, "spread": scaler.scale_}
    for layer, (weight, bias) in enumerate(zip(network.coefs_, network.intercepts_, strict=True)):
        weights |= {f"weights {layer}": weight, f"bias {layer}": bias}
    return {name: np.round(values, 4).tolist() for name, values in weights.items()}


def main() -> None:
    """Fit and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--fold", type=int, choices=(0, 1))
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("-o", "--out", type=Path, required=True)
    given = parser.parse_args()
    buildings = read_buildings(find_data(given.data), "school").buildings
    taken = [building for place, building in enumerate(buildings) if given.fold is None or place % 2 != given.fold]
    found = Parallel(n_jobs=given.jobs)(delayed(take_lessons)(building) for building in taken if building.others)
    lessons = np.concatenate(found)
    given.out.write_text(json.dumps(fit(lessons)) + "\n")
    print(f"{len(lessons)} lessons from {len(taken)} schools, in {given.out}")


if __name__ == "__main__":
    main()
