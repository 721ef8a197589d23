"""Train the model of building types that comes with pianta: python training/train_building_types.py.

As `pianta train buildings` does, but which floors are of one building is read from manifest.json of the data: names of
files do not always tell.
"""

from __future__ import annotations

import typer

from pianta.building_types.model import predict_held_out, train_building_types
from pianta.building_types.model_file import DEFAULT_MODEL, save_building_type_model
from pianta_bench.data.annotated_floors import read_annotated_floors
from pianta_bench.data.folders import find_data


def main() -> None:
    """Train, save, and print how many types are wrong when the building is left out."""
    floors, _ = read_annotated_floors(find_data(None))
    model = train_building_types([floor.floor for floor in floors], buildings=[floor.building for floor in floors])
    save_building_type_model(model, DEFAULT_MODEL)
    verdicts = predict_held_out(model)
    said = [verdict.likeliest for verdict in verdicts]
    wrong = sum(one != other for one, other in zip(said, model.types, strict=True))
    unknown = sum(not verdict.is_known for verdict in verdicts)
    typer.echo(f"{len(floors)} floors of {len(set(model.buildings))} buildings: {wrong} wrong, {unknown} unknown")


if __name__ == "__main__":
    main()
