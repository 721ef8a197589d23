"""The verb world: a synthetic building and its map, to try things on."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import Annotated, Any

import typer

from pianta.cli.terminal import describe_floor, print_result
from pianta.io._folders import atomic_folder, check_output_folder
from pianta.io.floors import save_floor
from pianta.io.ros_maps import save_ros_map
from pianta.worlds import make
from pianta.worlds.make import KINDS

EXAMPLES = (
    "pianta world sample -o sample",
    "pianta world ring -o ring --seed 7 --noise 0.5 --furniture 0.3 --glass-spray",
)

Kind = Annotated[str, typer.Argument(metavar="KIND", help=f"One of {', '.join(KINDS)}.")]
Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for the files; made when there is none.")]
Seed = Annotated[int | None, typer.Option(min=0, help="Of the building and the noise; 0 unless given.")]
Resolution = Annotated[float | None, typer.Option(help="Metres per cell; 0.05 unless given.")]
Noise = Annotated[float | None, typer.Option(help="0 for a clean map … 1 for a bad one; 0 unless given.")]
Furniture = Annotated[float | None, typer.Option(help="0 for empty rooms … 1 for a busy office; 0 unless given.")]
GlassSpray = Annotated[bool, typer.Option("--glass-spray", help="Make one outer wall of glass.")]
Yaw = Annotated[float | None, typer.Option(help="Turn the map against the building, radians; 0 unless given.")]


def make_world(
    kind: Kind,
    *,
    out: Out,
    seed: Seed = None,
    resolution: Resolution = None,
    noise: Noise = None,
    furniture: Furniture = None,
    glass_spray: GlassSpray = False,
    yaw: Yaw = None,
) -> None:
    """Make a synthetic building and the map that a robot would make of it.

    Writes map.yaml and map.png, as ROS has them, and the truth, truth.geojson.
    The sample is always the same; the other kinds take options.
    """
    check_output_folder(out)
    values = {"resolution": resolution, "noise": noise, "furniture": furniture, "yaw": yaw}
    options: dict[str, Any] = {name: value for name, value in values.items() if value is not None}
    if glass_spray:
        options["glass_spray"] = True
    floor, grid = make.make_world(kind, seed=seed, **options)
    with atomic_folder(out) as new:
        save_ros_map(grid, new / "map.yaml")
        save_floor(floor, new / "truth.geojson")
    print_result(f"{describe_floor(floor)}, in {out}")
    print_result(f"next: pianta read {quote(str(out / 'map.yaml'))} -o {quote(str(out / 'read'))}")
