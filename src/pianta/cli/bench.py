"""The verb bench: the tables of the thesis, measured again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pianta.cli.outputs import check_output_folder, written_together
from pianta.cli.terminal import show_examples, stdout, track_items
from pianta.errors import OptionError
from pianta.formats.files import shown
from pianta.layout.methods import METHODS, check_method

if TYPE_CHECKING:
    from pianta.bench.table import BenchTable

app = typer.Typer(no_args_is_help=True, help="Measure the tables of the thesis again, on the maps that you have.")

Data = Annotated[
    Path | None, typer.Option(help="Folder of the data; $PIANTA_DATA, or ../shared/data, unless given.", metavar="DIR")
]
Method = Annotated[str, typer.Option(help=f"How rooms are found: {', '.join(METHODS)}.")]
Json = Annotated[
    Path | None, typer.Option("--json", help="File for every figure and its map, as JSON.", metavar="FILE")
]
Pictures = Annotated[Path | None, typer.Option(help="Folder for a picture of every floor found.", metavar="DIR")]


@app.command("layout", epilog=show_examples(["pianta bench layout", "pianta bench layout --pictures layouts"]))
def bench_layout(*, data: Data = None, method: Method = "thesis", json: Json = None, pictures: Pictures = None) -> None:
    """Layouts of schools against the true ones (Table 3.1a).

    Reads slam/NAME.png and slam/NAME_gt.xml of the data. A map that fails
    counts as 0; the exit code is then 1.
    """
    from pianta.bench.layout import measure_layout

    _run(measure_layout, data, method, json, pictures)


@app.command("segmentation", epilog=show_examples(["pianta bench segmentation --json figures.json"]))
def bench_segmentation(
    *, data: Data = None, method: Method = "thesis", json: Json = None, pictures: Pictures = None
) -> None:
    """Rooms on the survey's maps, without and with furniture (Table 3.1b).

    Reads survey/NAME.png, survey/NAME_furnitures.png and
    survey/NAME_gt_segmentation.png of the data. A map that fails counts as 0;
    the exit code is then 1.
    """
    from pianta.bench.segmentation import measure_segmentation

    _run(measure_segmentation, data, method, json, pictures)


def _run(
    measure: Callable[..., BenchTable], data: Path | None, method: str, json: Path | None, pictures: Path | None
) -> None:
    """Measure, print, save; nothing is measured when an option makes no sense."""
    from pianta.bench.data import find_data
    from pianta.bench.report import show_bench_table
    from pianta.bench.table import save_bench_table

    check_method(method)
    _check_outputs(json, pictures)
    folder = find_data(data)
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    table = measure(folder, method=method, pictures=pictures, track=track_items)
    stdout.print(show_bench_table(table))
    if json:
        with written_together(json.parent) as new:
            save_bench_table(table, new / json.name)
    if table.failed:
        raise typer.Exit(1)


def _check_outputs(json: Path | None, pictures: Path | None) -> None:
    """Refuse, before the long run, a JSON file or a folder of pictures that cannot be written."""
    for folder in (json and json.parent, pictures):
        if folder:
            check_output_folder(folder)
    if json and json.is_dir():
        raise OptionError(f"JSON file {shown(json)} is a folder, give the name of a file")
