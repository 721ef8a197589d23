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
from pianta.layout.reconstruct import DEFAULT_METHOD, check_method
from pianta_bench._options import (
    Buildings,
    Data,
    GenerationPictures,
    Json,
    Method,
    Pictures,
    PredictionPictures,
    RealismPictures,
    Samples,
    Seed,
    TypesPictures,
)

if TYPE_CHECKING:
    from pianta_bench.harness.comparison import ComparisonTable, Items

Bench = TypeVar("Bench")
# In the order of the help. Each is a folder with a BENCH.
BENCHES = ("layout", "segmentation", "cost", "graphs", "places", "buildings", "exploration", "plans")

app = typer.Typer(no_args_is_help=True, help="Measure the tables of the thesis again, on the maps that you have.")
for name in BENCHES:
    bench = import_module(f"pianta_bench.{name}").BENCH
    app.command(name, epilog=show_examples(bench.examples))(bench.make_command())


@app.command("types", epilog=show_examples(["pianta bench types", "pianta bench types --pictures types"]))
def bench_types(*, data: Data = None, seed: Seed = 0, json: Json = None, pictures: TypesPictures = None) -> None:
    """Types of buildings: classifiers and clusters of rooms (Tables 4.2 to 4.4).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data, and
    buildings/house/*.xml with labels.yaml when there are any. A building that
    fails does not count; the exit code is then 1.
    """
    _check_outputs(json, pictures)
    from pianta_bench.data.folders import find_data
    from pianta_bench.types.figures import save_types_pictures
    from pianta_bench.types.measure import measure_types
    from pianta_bench.types.tables import save_types_bench, show_types_bench

    bench = measure_types(find_data(data), seed=seed, track=track_items)
    stdout.print(show_types_bench(bench))
    _save(bench, json, save_types_bench, pictures, save_types_pictures)
    _exit_on_failure(bench.failed)


@app.command("realism", epilog=show_examples(["pianta bench realism", "pianta bench realism --pictures realism"]))
def bench_realism(*, data: Data = None, seed: Seed = 0, json: Json = None, pictures: RealismPictures = None) -> None:
    """Real offices and simulated ones told apart (Table 8.2, Fig. 8.4).

    Reads buildings/office/*.xml and buildings/robocup/*.xml of the data, and
    buildings/school/*.xml when there are any, which are judged as if they were
    offices. A floor that fails does not count; the exit code is then 1.
    """
    _check_outputs(json, pictures)
    from pianta_bench.data.folders import find_data
    from pianta_bench.realism.figures import save_realism_pictures
    from pianta_bench.realism.measure import measure_realism, save_realism, tabulate_realism

    bench = measure_realism(find_data(data), seed=seed, track=track_items)
    _show(tabulate_realism(bench), bench.items)
    _save(bench, json, save_realism, pictures, save_realism_pictures)
    _exit_on_failure(bench.items)


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


@app.command("partial", epilog=show_examples(["pianta bench partial", "pianta bench partial --pictures partial"]))
def bench_partial(
    *, data: Data = None, method: Method = DEFAULT_METHOD, json: Json = None, pictures: Pictures = None
) -> None:
    """Rooms that were seen in part, predicted as a whole (section 8.2).

    Reads partial/*/steps.json and its maps of the data with the whole
    buildings, and simulates some more. A map that fails does not count; the
    exit code is then 1.
    """
    check_method(method)
    _check_outputs(json, pictures)
    from pianta_bench.data.folders import find_data
    from pianta_bench.harness.comparison import save_comparisons, show_comparisons
    from pianta_bench.partial.measure import measure_partial, tabulate_partial

    folder = find_data(data)
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    bench = measure_partial(folder, method=method, pictures=pictures, track=track_items)
    tables = tabulate_partial(bench)
    stdout.print(show_comparisons(tables, bench.items))
    if json:
        with atomic_folder(json.parent) as new:
            save_comparisons("partial", tables, bench.items, new / json.name)
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
