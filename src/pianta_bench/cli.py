"""The verb bench: the tables of the thesis, measured again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import typer

from pianta.cli.terminal import show_examples, stdout, track_items
from pianta.errors import OptionError
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder, check_output_folder
from pianta_bench import _exploration_cli as bench_exploration
from pianta_bench import _plans_cli as bench_plans
from pianta_bench._options import (
    PLACE_SPLITS,
    BuildingTypes,
    CurvePictures,
    Data,
    Json,
    PlacePictures,
    PlaceSplit,
    Seed,
    Trees,
)

if TYPE_CHECKING:
    from pianta_bench.harness.comparison import ComparisonTable, Items

Bench = TypeVar("Bench")
# In the order of the help. Each is a folder with a BENCH.
BENCHES = ("layout", "segmentation", "cost", "graphs", "types", "realism", "partial", "generation", "prediction")

app = typer.Typer(no_args_is_help=True, help="Measure the tables of the thesis again, on the maps that you have.")
for name in BENCHES:
    bench = import_module(f"pianta_bench.{name}").BENCH
    app.command(name, epilog=show_examples(bench.examples))(bench.make_command())
app.command("exploration", epilog=show_examples(bench_exploration.EXAMPLES))(bench_exploration.bench_exploration)
app.command("plans", epilog=show_examples(bench_plans.EXAMPLES))(bench_plans.bench_plans)


@app.command(
    "places", epilog=show_examples(["pianta bench places", "pianta bench places --json places.json --pictures places"])
)
def bench_places(
    *,
    data: Data = None,
    split: PlaceSplit = "experiments",
    seed: Seed = 0,
    json: Json = None,
    pictures: PlacePictures = None,
) -> None:
    """What rooms are for (Table 6.1, Tables 5.2 to 5.4), calibration and cost.

    Reads buildings/school/*.xml and buildings/office/*.xml of the data, and
    slam/NAME.png with slam/NAME_gt.xml. Each building is labelled by models
    that have not seen it. A floor that fails does not count; the exit code is
    then 1.
    """
    from pianta.labels import LabelConvention
    from pianta_bench.data.folders import find_data
    from pianta_bench.places.figures import save_place_pictures
    from pianta_bench.places.measure import measure_places, save_places
    from pianta_bench.places.tables import tabulate_places

    if split not in PLACE_SPLITS:
        raise OptionError(f"split is {split!r}, give one of {', '.join(PLACE_SPLITS)}")
    _check_outputs(json, pictures)
    folder = find_data(data)
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    bench = measure_places(folder, split=LabelConvention(split), seed=seed, pictures=pictures, track=track_items)
    _show(tabulate_places(bench), bench.items)
    _save(bench, json, save_places, pictures, save_place_pictures)
    _exit_on_failure(bench.items)


@app.command(
    "buildings",
    epilog=show_examples(
        [
            "pianta bench buildings --json buildings.json --pictures buildings",
            "pianta bench buildings --types dorms --types offices --types labs",
        ]
    ),
)
def bench_buildings(
    *,
    data: Data = None,
    types: BuildingTypes = None,
    split: PlaceSplit = "experiments",
    trees: Trees = 100,
    seed: Seed = 0,
    json: Json = None,
    pictures: CurvePictures = None,
) -> None:
    """Rooms and whole buildings (Table 6.1, Figs. 6.2 and 6.3).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data. Each
    building is judged by models that have not seen it. With --types only
    buildings are classified, those of your folders. A floor that fails does
    not count; the exit code is then 1.
    """
    from pianta.labels import LabelConvention
    from pianta_bench.buildings.figures import save_building_pictures
    from pianta_bench.buildings.measure import measure_building_types, measure_buildings
    from pianta_bench.buildings.tables import list_items, save_buildings, tabulate_buildings
    from pianta_bench.data.folders import find_data

    if split not in PLACE_SPLITS:
        raise OptionError(f"split is {split!r}, give one of {', '.join(PLACE_SPLITS)}")
    if types and pictures:
        raise OptionError("--pictures are of the thesis' two types, leave it out with --types")
    _check_outputs(json, pictures)
    measure = partial(measure_building_types, types) if types else partial(measure_buildings, find_data(data))
    bench = measure(split=LabelConvention(split), trees=trees, seed=seed, track=track_items)
    items = list_items(bench)
    _show(tabulate_buildings(bench), items)
    _save(bench, json, save_buildings, pictures, save_building_pictures)
    _exit_on_failure(items)


def _show(tables: Sequence[ComparisonTable], items: Items) -> None:
    """Print the tables, and what failed."""
    from pianta_bench.harness.comparison import show_comparisons

    stdout.print(show_comparisons(tables, items))


def _save(
    bench: Bench,
    json: Path | None,
    save_figures: Callable[[Bench, Path], None],
    pictures: Path | None,
    save_pictures: Callable[[Bench, Path], None],
) -> None:
    """Write the figures and the pictures that are wanted."""
    if json:
        with atomic_folder(json.parent) as new:
            save_figures(bench, new / json.name)
    if pictures:
        with atomic_folder(pictures) as new:
            save_pictures(bench, new)


def _exit_on_failure(items: Items) -> None:
    """Leave with the code 1 when an item failed."""
    if any(row.failure for rows in items.values() for row in rows):
        raise typer.Exit(1)


def _check_outputs(json: Path | None, pictures: Path | None) -> None:
    """Refuse, before the long run, a JSON file or a folder of pictures that cannot be written."""
    for folder in (json and json.parent, pictures):
        if folder:
            check_output_folder(folder)
    if json and json.is_dir():
        raise OptionError(f"JSON file {short_repr(json)} is a folder, give the name of a file")
