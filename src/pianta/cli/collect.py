"""The verb collect: one table of all buildings that were read into a folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pianta.batch.collect import collect_batch
from pianta.cli.terminal import Quiet, print_result

EXAMPLES = ("pianta read maps -o buildings --jobs 4", "pianta collect buildings")

Folder = Annotated[Path, typer.Argument(help="Folder that pianta read has written, with a journal.")]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="Folder for the tables; by default the same.")]


def collect_buildings(folder: Folder, *, out: Out = None, quiet: Quiet = False) -> None:
    """Write buildings.parquet, rooms.parquet and doors.parquet of many maps (GeoParquet).

    A row is a storey, a room or a door of a file that was read; geometries are
    metres in the frame of its own map.
    """
    for table in collect_batch(folder, out).values():
        if not quiet:
            print_result(f"{table}")
