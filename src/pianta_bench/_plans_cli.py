"""The verb bench plans: how well pictures of plans are read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.text import Text

from pianta.cli.terminal import stdout, track_items
from pianta.errors import OptionError
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder, check_output_folder
from pianta_bench._options import Data, Json

if TYPE_CHECKING:
    from pianta_bench.plans.measure import PlanBench

SET_NAMES = ("real", "drawn")
EXAMPLES = (
    "pianta bench plans --jobs 2 --json plans.json --pictures plans",
    "pianta bench plans --only off2 --only milano1 --no-text",
)

PlanSets = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME", help=f"Which plans, may be repeated: {', '.join(SET_NAMES)}; both unless given."
    ),
]
Only = Annotated[list[str] | None, typer.Option(metavar="NAME", help="Only this plan, may be repeated.")]
WithText = Annotated[bool, typer.Option("--text/--no-text", help="Whether what is written on plans is read, too.")]
Jobs = Annotated[int, typer.Option(min=1, help="Processes; the figures, but for times, do not depend on them.")]
Pictures = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder for NAME.png, found rooms and doors over each plan, the truth in red."),
]


def bench_plans(
    *,
    data: Data = None,
    set_: PlanSets = None,
    only: Only = None,
    text: WithText = True,
    jobs: Jobs = 1,
    json: Json = None,
    pictures: Pictures = None,
) -> None:
    """Pictures of plans, read with and without symbols (section 3.3).

    Reads floorplans/NAME.png or .jpg with NAME.xml of the data, and draws some
    plans. A plan that fails counts as 0; the exit code is then 1.
    """
    for folder in (json and json.parent, pictures):
        if folder:
            check_output_folder(folder)
    if json and json.is_dir():
        raise OptionError(f"JSON file {short_repr(json)} is a folder, give the name of a file")
    from pianta_bench.plans.file import save_plans
    from pianta_bench.plans.measure import measure_plans

    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    bench = measure_plans(
        data, sets=set_ or (), only=only or (), with_text=text, jobs=jobs, pictures=pictures, track=track_items
    )
    _show(bench)
    if json:
        with atomic_folder(json.parent) as new:
            save_plans(bench, new / json.name)
    if bench.failed:
        raise typer.Exit(1)


def _show(bench: PlanBench) -> None:
    """Print the tables, and what failed."""
    from pianta_bench.harness.comparison import show_comparisons
    from pianta_bench.harness.old_report import show_bench_table
    from pianta_bench.plans.tables import list_faults, tabulate_plans

    stdout.print(show_comparisons(tabulate_plans(bench)))
    if bench.text:
        stdout.print(show_bench_table(bench.text))
    for fault in list_faults(bench):
        stdout.print(Text(fault))
