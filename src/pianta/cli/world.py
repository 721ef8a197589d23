"""The verb world: a synthetic building and its map, to try things on."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import Annotated, Any

import typer

from pianta.cli.terminal import Quiet, describe_floor, print_result
from pianta.io._folders import atomic_folder, check_output_folder
from pianta.io.floors import save_floor
from pianta.io.ros_maps import save_ros_map
from pianta.worlds.make import WORLD_NAMES

EXAMPLES = (
    "pianta world sample -o sample",
    "pianta world ring -o ring --seed 7 --noise 0.5 --furniture 0.3 --glass-spray",
    "pianta world home -o home --furniture 1 --dense-furniture --door-leaves",
    "pianta world school --model school.json --seed 3 -o school --furniture 1 --dense-furniture",
)

Name = Annotated[
    str, typer.Argument(metavar="NAME", help=f"One of {', '.join(WORLD_NAMES)}; or with --model its building type.")
]
Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for the files; created if necessary.")]
Model = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Of `pianta train type`: make a building of its type, NAME.")
]
Seed = Annotated[int | None, typer.Option(min=0, help="Of the building and the noise; 0 unless given.")]
Resolution = Annotated[float | None, typer.Option(help="Metres per cell; 0.05 unless given.")]
Noise = Annotated[float | None, typer.Option(help="0 for a clean map … 1 for a bad one; 0 unless given.")]
Furniture = Annotated[float | None, typer.Option(help="0 for empty rooms … 1 for a busy office; 0 unless given.")]
DenseFurniture = Annotated[
    bool, typer.Option("--dense-furniture", help="Furnish rooms by their labels, until passages nearly close.")
]
DoorLeaves = Annotated[bool, typer.Option("--door-leaves", help="Make doors open, half open and shut, not gaps.")]
GlassSpray = Annotated[bool, typer.Option("--glass-spray", help="Make one outer wall of glass; lidar rays pass it.")]
Yaw = Annotated[float | None, typer.Option(help="Rotation of the map against the building, radians; 0 unless given.")]


def make_world(
    name: Name,
    *,
    out: Out,
    model: Model = None,
    seed: Seed = None,
    resolution: Resolution = None,
    noise: Noise = None,
    furniture: Furniture = None,
    dense_furniture: DenseFurniture = False,
    door_leaves: DoorLeaves = False,
    glass_spray: GlassSpray = False,
    yaw: Yaw = None,
    quiet: Quiet = False,
) -> None:
    """Make a building and the map that a robot would make of it: a synthetic one, or one of a building type.

    Writes map.yaml and map.png in the format of ROS, and the true floor,
    truth.geojson. The sample is always the same; the other buildings have
    options.

    With --model it is the first building of `pianta generate` with this seed,
    drawn as a floor; `pianta generate --worlds` makes many, for simulators.
    """
    from pianta.generation import world
    from pianta.generation.type_model_file import read_type_model

    check_output_folder(out)
    values = {"resolution": resolution, "noise": noise, "furniture": furniture, "yaw": yaw}
    options: dict[str, Any] = {key: value for key, value in values.items() if value is not None}
    flags = {"dense_furniture": dense_furniture, "door_leaves": door_leaves, "glass_spray": glass_spray}
    options |= {key: value for key, value in flags.items() if value}
    if model is not None:
        options["model"] = read_type_model(model)
    floor, grid = world.make_world(name, seed=seed, **options)
    with atomic_folder(out) as new:
        save_ros_map(grid, new / "map.yaml")
        save_floor(floor, new / "truth.geojson")
    if not quiet:
        print_result(f"{describe_floor(floor)}, in {out}")
        print_result(f"next: pianta read {quote(str(out / 'map.yaml'))} -o {quote(str(out / 'read'))}")
