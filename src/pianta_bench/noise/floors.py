"""The floors that are mapped, and models of labels and building types that were trained without their buildings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, zip_longest
from math import sqrt
from pathlib import Path

import numpy as np

from pianta.building_types.map_type_file import read_default_map_type_model
from pianta.building_types.map_types import MapTypeModel
from pianta.errors import DataError
from pianta.floor import Floor, scale_floor
from pianta.io._files import short_repr
from pianta.labels import LabelConvention
from pianta.rooms.model import RoomModel
from pianta.rooms.model_file import read_default_room_model
from pianta.rooms.training import TrainingFloor
from pianta.worlds.floors import make_floor
from pianta.worlds.simulated_readings import MEDIAN_ROOM, inset_room
from pianta_bench.data.annotated_floors import KINDS, AnnotatedFloor, read_annotated_floors, set_building_type
from pianta_bench.data.building_of import building_of
from pianta_bench.data.folders import REMEDY, SLAM_FOLDER, SLAM_TRUTH, find_data
from pianta_bench.noise import DRAWN_SET
from pianta_bench.places.models import list_examples, train_room_model

CONVENTION = LabelConvention.EXPERIMENTS
# Endings of the maps of the sets whose buildings the network of `structure` was not trained on.
UNSEEN = ((SLAM_FOLDER, SLAM_TRUTH), ("doors", "_GT.png"))
# A building of these sets of which the network has seen another floor; src/pianta/models/map_regions.md.
SEEN_BUILDING = "varzeapaulistafde"
# Makers of floors whose rooms have the labels of offices, in turn.
MAKERS = ("office", "open_plan")
MADE_TYPE = "office"


@dataclass(frozen=True, eq=False)
class NoiseFloor:
    """A floor to be mapped, with walls between its rooms.

    kind: its building type. building: as of read_annotated_floors; empty for a made floor.
    others: floors of other buildings to train the model of labels on; empty for the model that comes with pianta.
    """

    item: str
    kind: str
    building: str
    floor: Floor
    others: Sequence[TrainingFloor] = ()

    def train_room_model(self, *, seed: int) -> RoomModel:
        """The model of labels, without this building."""
        if not self.others:
            return read_default_room_model()
        return train_room_model(self.others, convention=CONVENTION, seed=seed)

    def train_type_model(self) -> MapTypeModel:
        """The model of building types, without this building; DataError if it cannot be left out."""
        model = read_default_map_type_model()
        if not self.others:
            return model
        if self.building not in model.examples.buildings:
            raise DataError(f"building {short_repr(self.building)} is not in the model of types, train the model again")
        return model.leave_out(self.building)


def list_floors(data: Path | None, floor_set: str, *, count: int, seed: int) -> list[NoiseFloor]:
    """The first floors of a set in an order that the seed draws; raises DataError if the data have none.

    Drawn floors are those of buildings that the network of `structure` has not seen: schools and offices in turn, one
    floor of each building before the second of any.
    """
    if floor_set != DRAWN_SET:
        return [make_office(number, seed=seed + number) for number in range(count)]
    folder = find_data(data)
    floors, _ = read_annotated_floors(folder)
    unseen = list_unseen_buildings(folder)
    chosen = order_floors([each for each in floors if each.building.partition("/")[2] in unseen], seed=seed)[:count]
    if not chosen:
        raise DataError(f"no drawn floor of a building of slam or doors in {short_repr(folder)}, {REMEDY}")
    examples = [(each.building, list_examples([each.floor], convention=CONVENTION)) for each in floors]
    return [
        NoiseFloor(
            each.item,
            each.kind,
            each.building,
            add_walls(each.floor),
            [example for building, own in examples if building != each.building for example in own],
        )
        for each in chosen
    ]


def list_unseen_buildings(data: Path) -> set[str]:
    """The buildings of the maps that other benches measure on, which the network of `structure` has not seen."""
    files = [file for folder, ending in UNSEEN for file in (data / folder).glob(f"*{ending}")]
    return {building_of(data, file.relative_to(data).as_posix()) for file in files} - {SEEN_BUILDING}


def order_floors(floors: Sequence[AnnotatedFloor], *, seed: int) -> list[AnnotatedFloor]:
    """The floors at random: types in turn while both have floors, and one floor of each building before a second."""
    order = np.random.default_rng(seed).permutation(len(floors))
    counts: Counter[str] = Counter()
    rounds: dict[str, list[tuple[int, AnnotatedFloor]]] = {name: [] for name in KINDS}
    for each in (floors[index] for index in order):
        rounds[each.kind].append((counts[each.building], each))
        counts[each.building] += 1
    columns = [[each for _, each in sorted(rounds[name], key=lambda pair: pair[0])] for name in KINDS]
    return [each for each in chain.from_iterable(zip_longest(*columns)) if each is not None]


def add_walls(floor: Floor) -> Floor:
    """A drawn floor with walls between its rooms, a plausible scale, and without doors that lead out of it."""
    area = float(np.median([room.polygon.area for room in floor.rooms]))
    scale = sqrt(min(max(area, MEDIAN_ROOM[0]), MEDIAN_ROOM[1]) / area)
    scaled = scale_floor(floor, scale, scale)
    inner = tuple(door for door in scaled.doors if not door.is_entrance)
    return replace(scaled, rooms=tuple(map(inset_room, scaled.rooms)), doors=inner)


def make_office(number: int, *, seed: int) -> NoiseFloor:
    """A made office; its rooms have labels, and its walls are between them."""
    floor = make_floor(MAKERS[number % len(MAKERS)], seed=seed)
    return NoiseFloor(floor.source, MADE_TYPE, "", set_building_type(floor, MADE_TYPE))
