"""The verb bench: the tables of the thesis, measured again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import typer

from pianta.cli.terminal import show_examples, stdout, track_items
from pianta.errors import OptionError
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder, check_output_folder
from pianta_bench._options import (
    Buildings,
    Data,
    GenerationPictures,
    Json,
    PredictionPictures,
    Samples,
    Seed,
)

if TYPE_CHECKING:
    from pianta_bench.harness.comparison import ComparisonTable, Items

Bench = TypeVar("Bench")
# In the order of the help. Each is a folder with a BENCH.
BENCHES = (
    *("layout", "segmentation", "cost", "graphs", "types", "places", "buildings", "realism", "partial"),
    *("exploration", "plans"),
)

app = typer.Typer(no_args_is_help=True, help="Measure the tables of the thesis again, on the maps that you have.")
for name in BENCHES:
    bench = import_module(f"pianta_bench.{name}").BENCH
    app.command(name, epilog=show_examples(bench.examples))(bench.make_command())


@app.command(
    "generation",
    epilog=show_examples(["pianta bench generation", "pianta bench generation --json new.json --pictures new"]),
)
def bench_generation(
    *,
    data: Data = None,
    count: Buildings = 200,
    seed: Seed = 0,
    json: Json = None,
    pictures: GenerationPictures = None,
) -> None:
    """Models of schools and new ones made by them (chapter 7, Tables 7.1, 7.2).

    Reads buildings/school/*.xml of the data, and sampled/corr_table7_1.json
    when it is there, the thesis' own new schools. A school that fails does
    not count; the exit code is then 1.
    """
    _check_outputs(json, pictures)
    from pianta_bench.data.folders import find_data
    from pianta_bench.generation.figures import save_generation_pictures
    from pianta_bench.generation.file import save_generation
    from pianta_bench.generation.measure import measure_generation
    from pianta_bench.generation.tables import tabulate_generation

    bench = measure_generation(find_data(data), seed=seed, count=count, track=track_items)
    _show(tabulate_generation(bench), bench.items)
    _save(bench, json, save_generation, pictures, save_generation_pictures)
    _exit_on_failure(bench.items)


@app.command("prediction", epilog=show_examples(["pianta bench prediction --json new.json --pictures new"]))
def bench_prediction(
    *, data: Data = None, count: Samples = 100, seed: Seed = 0, json: Json = None, pictures: PredictionPictures = None
) -> None:
    """What lies beyond the explored part of a floor, predicted (section 8.3).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data. Each is
    predicted by all others. What fails does not count; the exit code is then 1.
    """
    _check_outputs(json, pictures)
    from pianta_bench.data.folders import find_data
    from pianta_bench.prediction.figures import save_prediction_pictures
    from pianta_bench.prediction.file import save_prediction
    from pianta_bench.prediction.measure import measure_prediction
    from pianta_bench.prediction.tables import tabulate_prediction

    bench = measure_prediction(find_data(data), count=count, seed=seed, track=track_items)
    _show(tabulate_prediction(bench), bench.items)
    _save(bench, json, save_prediction, pictures, save_prediction_pictures)
    _exit_on_failure(bench.items)


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
