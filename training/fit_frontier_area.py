"""Fit the perceptron of the area behind a frontier on simulated runs in the schools of the data.

    python training/fit_frontier_area.py [--data DIR] [--fold 0|1] [--jobs N] -o frontier_area.json

Writes the weights that src/pianta/models/frontier_area.json has. Robots recognise rooms without error, and also read
them from their own map. What lies beyond open ends is predicted, and rooms are labelled, by models without the school.
--fold leaves every other building out, so that the weights can be evaluated on its floors.
"""

from __future__ import annotations

import argparse
import json
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import replace
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
from pianta.exploration.perceptions import PERFECT
from pianta.exploration.policy_input import Policy, PolicyInput
from pianta.exploration.starts import find_starts
from pianta.exploration.world import World, build_world
from pianta.floor import Floor
from pianta.generation.type_model import learn_type
from pianta.gridmap import UNKNOWN
from pianta.labels import SCHOOL
from pianta.mapping.mapper import Mapper
from pianta.prediction.unexplored_part import FloorSampler
from pianta.rooms.training import train_rooms
from pianta_bench.data.annotated_floors import read_annotated_buildings, set_building_type
from pianta_bench.data.folders import find_data
from pianta_bench.exploration.buildings import ExploredBuilding, read_buildings

# All values were chosen by hand. Of the worlds, metres per cell.
RESOLUTION = 0.2
# Floors of more rooms are left out, as runs in them take longest.
MOST_ROOMS = 45
# Every third decision is recorded, because consecutive ones are alike.
DECISION_STEP = 3
# Runs end at this share of the area.
STOP = 0.98
MAX_SAMPLES = 120_000
HIDDEN = (24, 12)


class Watcher:
    """Records measures of frontiers and the true area behind them, while another policy decides."""

    def __init__(self, policy: Policy, expectations: RoomExpectations, world: World) -> None:
        self.policy, self.expectations, self.world = policy, expectations, world
        self.samples: list[Floats] = []

    def choose(self, inputs: PolicyInput) -> list[Frontier | None]:
        """Choose as the other policy."""
        if inputs.decision % DECISION_STEP == 0:
            measures, _ = measure_frontiers(inputs, self.expectations)
            self.samples.append(np.column_stack([measures, np.sqrt(measure_true_areas(inputs, self.world))]))
        return self.policy.choose(inputs)


def measure_true_areas(inputs: PolicyInput, world: World) -> Floats:
    """Unknown free area of the world nearest to each frontier, on foot through the unknown, m², shape (frontiers,)."""
    markers = np.zeros(inputs.cells.shape, np.int32)
    for number, frontier in enumerate(inputs.frontiers, 1):
        markers[tuple(frontier.cells.T)] = number
    hidden = (inputs.cells == UNKNOWN) & world.free
    nearest = watershed(np.zeros(markers.shape), markers, mask=hidden | (markers > 0))
    counts = np.bincount(nearest[hidden], minlength=len(inputs.frontiers) + 1)[1:]
    return np.asarray(counts * inputs.resolution**2, float)


def record_runs(building: ExploredBuilding, others: Sequence[Floor]) -> Floats:
    """Samples of one school, by both classical policies, and by the second one where the robot reads its map.

    others: labelled floors of other schools.
    """
    warnings.simplefilter("ignore")
    world = build_world(building.floor, resolution=RESOLUTION)
    sampler = FloorSampler(learn_type(building.others, SCHOOL))
    mapper = Mapper(building_type=SCHOOL.building_type, room_model=train_rooms(others))
    samples = []
    for policy, perception in ((NearestFrontier(), PERFECT), (InformationGain(), PERFECT), (InformationGain(), mapper)):
        watcher = Watcher(policy, RoomExpectations(sampler), world)
        explore(world, watcher, starts=find_starts(world)[:1], stop=STOP, perception=perception)
        samples += watcher.samples
    return np.concatenate(samples)


def choose_buildings(data: Path, fold: int | None) -> Iterator[tuple[ExploredBuilding, tuple[Floor, ...]]]:
    """The schools to learn from, each with the labelled floors of all other buildings."""
    annotated, _ = read_annotated_buildings(
        data,
        SCHOOL.building_type,
        lambda each: replace(each, floor=set_building_type(each.floor, SCHOOL.building_type)),
    )
    building_of = {floor.item: floor.building for floor in annotated}
    left_out = [] if fold is None else sorted({*building_of.values()})[fold::2]
    for school in read_buildings(data, SCHOOL.building_type).buildings:
        own = building_of.get(school.name)
        if own and school.others and len(school.floor) <= MOST_ROOMS and own not in left_out:
            yield school, tuple(floor.floor for floor in annotated if floor.building != own)


def fit(samples: Floats, seed: int = 0) -> dict[str, list[object]]:
    """The weights of the perceptron."""
    order = np.random.default_rng(seed).permutation(len(samples))[:MAX_SAMPLES]
    scaler = StandardScaler().fit(samples[order, :-1])
    network = MLPRegressor(hidden_layer_sizes=HIDDEN, random_state=seed, max_iter=60, early_stopping=True, alpha=1e-3)
    network.fit(scaler.transform(samples[order, :-1]), samples[order, -1])
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
    arguments = parser.parse_args()
    training = [*choose_buildings(find_data(arguments.data), arguments.fold)]
    runs = Parallel(n_jobs=arguments.jobs)(delayed(record_runs)(*school) for school in training)
    samples = np.concatenate(runs)
    arguments.out.write_text(json.dumps(fit(samples)) + "\n")
    print(f"{len(samples)} samples from {len(training)} schools, in {arguments.out}")


if __name__ == "__main__":
    main()
