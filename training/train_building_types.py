"""Train the model of building types that comes with pianta: python training/train_building_types.py.

As `pianta train buildings`, but manifest.json of the data says which floors are of one building, as names of files are
not always enough.
"""

from __future__ import annotations

import typer

from pianta.building_types.model import predict_held_out, train_building_types
from pianta.building_types.model_file import DEFAULT_MODEL, save_building_type_model
from pianta_bench.data.annotated_floors import read_annotated_floors
from pianta_bench.data.folders import find_data


def main() -> None:
    """Train, save, and print the number of wrong types when the building is left out."""
    floors, _ = read_annotated_floors(find_data(None))
    model = train_building_types([floor.floor for floor in floors], buildings=[floor.building for floor in floors])
    save_building_type_model(model, DEFAULT_MODEL)
    predictions = predict_held_out(model)
    wrong = sum(each.likeliest != true for each, true in zip(predictions, model.types, strict=True))
    unknown = sum(not each.is_known for each in predictions)
    typer.echo(f"{len(floors)} floors of {len(set(model.buildings))} buildings: {wrong} wrong, {unknown} unknown")


if __name__ == "__main__":
    main()
