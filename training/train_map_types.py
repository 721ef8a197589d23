"""Train the model of the building types of maps that comes with pianta.

    python training/train_map_types.py READINGS [--data DIR]

It learns from drawn floors, from readings of simulated maps of them and of made floors (simulated_floors.py), and from
readings of the maps of TRAINING_SETS. Readings are kept in the folder READINGS and are made only if they are missing:
about twelve minutes of one core, the training itself half a minute. Empty the folder when the method of reading maps
has changed.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
from simulated_floors import read_simulated_floors

from pianta.building_types.map_type_file import DEFAULT_MODEL, save_map_type_model
from pianta.building_types.map_types import MapExamples, describe_map, join_examples, predict_left_out, soften
from pianta.building_types.map_types import train_map_types as train
from pianta.errors import PiantaError
from pianta.floor import Floor
from pianta.io.floors import read_floor, save_floor
from pianta.layout.reconstruct import reconstruct
from pianta.rooms.features import describe_rooms
from pianta_bench.data.annotated_floors import read_annotated_floors
from pianta_bench.data.folders import find_data
from pianta_bench.data.typed_maps import TypedMap, list_typed_maps, name_training_building

# Sets of maps that are trained on; those of vacuums and of strangers' robots are only measured on.
TRAINING_SETS = ("schools", "survey", "furniture", "kth", "clutter")


def describe_floors(floors: Iterable[tuple[str, str, Floor]]) -> MapExamples:
    """Examples of floors: name, building and floor, which has its type."""
    rows = [(name, building, floor) for name, building, floor in floors if floor.rooms]
    features = [describe_map(describe_rooms(floor)) for _, _, floor in rows]
    return MapExamples(
        np.array(features),
        tuple(floor.building_types[0] for _, _, floor in rows),
        tuple(name_training_building(building) for _, building, _ in rows),
        tuple(name for name, _, _ in rows),
    )


def read_typed_map(each: TypedMap, folder: Path) -> Floor | None:
    """The reading of a map, with its type; None for a map that shows no room."""
    file = folder / f"map_{each.part}_{each.item}.geojson"
    if not file.is_file():
        try:
            reading = reconstruct(each.read(), predict_partial=False)
        except PiantaError:
            return None
        save_floor(replace(reading, walls=(), furniture=()), file)
    return replace(read_floor(file), building_type={each.building_type: 1.0})


def main() -> None:
    """Train, save, and print how many types of floors whose building was left out are right."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("readings", type=Path)
    parser.add_argument("--data", type=Path)
    arguments = parser.parse_args()
    data = find_data(arguments.data)
    floors, _ = read_annotated_floors(data)
    simulated = read_simulated_floors(data, arguments.readings)
    maps = [each for each in list_typed_maps(data) if each.part in TRAINING_SETS]
    readings = [(each, read_typed_map(each, arguments.readings)) for each in maps]
    parts = {
        "drawn": describe_floors((each.item, each.building, each.floor) for each in floors),
        "simulated": describe_floors((each.item, each.building, each.floor) for each in simulated),
        "maps": describe_floors(
            (f"{each.part}/{each.item}", each.building, floor) for each, floor in readings if floor
        ),
    }
    examples = join_examples([*parts.values()])
    model = train(examples)
    save_map_type_model(model, DEFAULT_MODEL)
    chances = soften(predict_left_out(examples), model.temperature)
    right = chances.argmax(axis=1) == examples.truth
    names = [name for name, part in parts.items() for _ in part.types]
    for (name, building_type), count in Counter(zip(names, examples.types, strict=True)).items():
        chosen = [key == (name, building_type) for key in zip(names, examples.types, strict=True)]
        print(
            f"{name}, {building_type}: {count} floors, {right[np.array(chosen)].sum()} right with the building left out"
        )
    print(f"temperature {model.temperature}, {len(examples.types)} floors of {len(set(examples.buildings))} buildings")


if __name__ == "__main__":
    main()
