"""The verb bench exploration: how far robots drive, by each policy."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pianta.cli.terminal import stdout, track_items
from pianta.errors import OptionError
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder, check_output_folder
from pianta_bench._options import Data, Json

SET_NAMES = ("school", "office", "synthetic")
EXAMPLES = (
    "pianta bench exploration --jobs 2 --json new.json --pictures new",
    "pianta bench exploration --set office --starts 1 --resolution 0.2 --no-searches",
)

ExploredSets = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME", help=f"Which buildings, may be repeated: {', '.join(SET_NAMES)}; all unless given."
    ),
]
Policies = Annotated[
    list[str] | None,
    typer.Option(
        "--policy", metavar="NAME", help="Which policies, may be repeated, nearest among them; all unless given."
    ),
]
Starts = Annotated[int, typer.Option(min=0, help="At most so many of each building; 0 for every entrance.")]
Resolution = Annotated[float, typer.Option(help="Of the robots' map, metres per cell.")]
Searches = Annotated[bool, typer.Option(help="Whether rooms are looked for, too, by their labels.")]
Jobs = Annotated[int, typer.Option(min=1, help="Processes; the figures do not depend on them.")]
Seed = Annotated[int, typer.Option(min=0, max=2**31, help="Of the noise of the lidars.")]
Pictures = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder for curves.png, and SET_NAME.png of a few buildings with all tracks."),
]


def bench_exploration(
    *,
    data: Data = None,
    set_: ExploredSets = None,
    policy: Policies = None,
    starts: Starts = 3,
    resolution: Resolution = 0.1,
    searches: Searches = True,
    jobs: Jobs = 1,
    seed: Seed = 0,
    json: Json = None,
    pictures: Pictures = None,
) -> None:
    """Ways of robots that explore, or look for a room (sections 8.3, 8.4).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data, and
    makes synthetic ones. What predicts learns from the other buildings. What
    fails does not count; the exit code is then 1.
    """
    for folder in (json and json.parent, pictures):
        if folder:
            check_output_folder(folder)
    if json and json.is_dir():
        raise OptionError(f"JSON file {short_repr(json)} is a folder, give the name of a file")
    from pianta_bench.exploration.figures import save_exploration_pictures
    from pianta_bench.exploration.file import save_exploration
    from pianta_bench.exploration.measure import measure_exploration
    from pianta_bench.exploration.tables import tabulate_exploration
    from pianta_bench.harness.comparison import show_comparisons

    bench = measure_exploration(
        data,
        sets=set_ or (),
        policies=policy or (),
        starts=starts,
        resolution=resolution,
        searches=searches,
        jobs=jobs,
        seed=seed,
        track=track_items,
    )
    stdout.print(show_comparisons(tabulate_exploration(bench), bench.items))
    if json:
        with atomic_folder(json.parent) as new:
            save_exploration(bench, new / json.name)
    if pictures:
        with atomic_folder(pictures) as new:
            save_exploration_pictures(bench, new)
    if any(row.failure for rows in bench.items.values() for row in rows):
        raise typer.Exit(1)
