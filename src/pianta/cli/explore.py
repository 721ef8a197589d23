"""The verb explore: a simulated robot in a building that it does not know."""

from __future__ import annotations

import csv
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pianta.cli.terminal import stderr, tell_result
from pianta.errors import BuildingWarning, OptionError
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder, check_output_folder

if TYPE_CHECKING:
    from pianta.exploration.policy_input import Policy
    from pianta.exploration.record import Exploration
    from pianta.exploration.world import World

PREDICTED = "predicted"
POLICY_NAMES = ("nearest", "gain", "gain-exp", PREDICTED)
ANIMATIONS = ("gif", "mp4", "none")
SHARES = (0.5, 0.9, 0.99)
EXAMPLES = (
    "pianta explore ring -o exploration",
    "pianta explore school.xml --policy gain --robots 2 -o exploration",
    "pianta explore school.xml --policy predicted --model others.json --find gym",
    "pianta explore building --policy predicted --model school.json --enough 0.95 --start 1.5,2",
    "pianta explore map.yaml --stop 0.9 --animation none -o exploration",
)

World_ = Annotated[
    str,
    typer.Argument(
        metavar="WORLD",
        help="A floor or building file, a folder of `pianta read` or `world`, a map.yaml, or a kind of `pianta world`.",
    ),
]
PolicyOption = Annotated[
    str,
    typer.Option(
        "--policy",
        help=f"Who chooses the next frontier: {', '.join(POLICY_NAMES)}; the last by geometry alone without --model.",
    ),
]
Model = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Of predicted: a model of the building's type, of `pianta train type`."),
]
Enough = Annotated[
    float | None,
    typer.Option(metavar="SHARE", help="Of predicted: stop when it expects that so much of the floor was seen."),
]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="Folder for table, picture and animation.")]
Robots = Annotated[int, typer.Option(help="How many robots, which share their map.")]
Find = Annotated[str | None, typer.Option(metavar="LABEL", help="End when a room of this label is recognised.")]
Start = Annotated[
    list[str] | None,
    typer.Option(
        metavar="X,Y", help="Where a robot starts, metres of the map frame; once for each. Unless given: the entrance."
    ),
]
Stop = Annotated[
    float | None, typer.Option(metavar="SHARE", help="End when this share of the area was seen; all unless given.")
]
Reach = Annotated[float, typer.Option(help="Of the lidar, metres.")]
Noise = Annotated[float, typer.Option(help="Standard deviation of its ranges, metres.")]
Radius = Annotated[float, typer.Option(help="Of a robot, metres.")]
DriveOption = Annotated[str, typer.Option("--drive", help="point moves any way at once; differential turns first.")]
MaxDistance = Annotated[
    float | None, typer.Option(help="End after so many metres; derived from the area unless given.")
]
Seed = Annotated[int, typer.Option(min=0, help="Of the noise, and of a synthetic building.")]
Animation = Annotated[str, typer.Option(help=f"One of {', '.join(ANIMATIONS)}; mp4 needs ffmpeg.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors.")]


def explore_world(
    world: World_,
    *,
    policy: PolicyOption = "nearest",
    model: Model = None,
    enough: Enough = None,
    out: Out = None,
    robots: Robots = 1,
    find: Find = None,
    start: Start = None,
    stop: Stop = None,
    reach: Reach = 8.0,
    noise: Noise = 0.01,
    radius: Radius = 0.2,
    drive: DriveOption = "point",
    max_distance: MaxDistance = None,
    seed: Seed = 0,
    animation: Animation = "gif",
    quiet: Quiet = False,
) -> None:
    """Let simulated robots explore a building that they do not know, with a lidar each.

    Writes area.csv (area seen over metres driven), picture.png and exploration.gif when a
    folder is given. Entrances are closed; rooms that robots do not fit into are left out.
    """
    from pianta.exploration.explore import explore
    from pianta.exploration.lidar import Lidar
    from pianta.exploration.world import open_world

    _check_outputs(out, animation)
    _check_policy(policy, model, enough)
    starts, lidar = [read_point(text) for text in start or ()] or None, Lidar(reach=reach, noise=noise)
    stop_at = "all" if stop is None else stop
    built = open_world(world, seed=seed)
    chosen = _make_policy(policy, model, built, name=world, find=find, enough=enough)
    with _tracking(quiet=quiet) as track:
        run = explore(built, chosen, starts=starts, lidar=lidar, robots=robots, radius=radius, drive=drive,
                      stop=stop_at, find=find, max_distance=max_distance, seed=seed, track=track)  # fmt: skip
    _save_exploration(run, built, out, animation)
    if not quiet:
        _tell_exploration(run, policy, find, written=_list_outputs(out, animation))


def read_point(text: str) -> tuple[float, float]:
    """The x, y of "X,Y".

    Raises OptionError for anything else.
    """
    try:
        x, y = map(float, text.split(","))
    except ValueError:
        x = y = float("nan")
    if not (isfinite(x) and isfinite(y)):
        raise OptionError(f"--start is {short_repr(text)}, give two numbers such as 1.5,2")
    return x, y


def _check_outputs(out: Path | None, animation: str) -> None:
    from pianta.plot.exploration import check_animation

    if out is None:
        return
    check_output_folder(out)
    if animation != "none":
        check_animation(animation)


def _check_policy(policy: str, model: Path | None, enough: float | None) -> None:
    """Refuse names of no policy, and options that it would make no use of."""
    from pianta.exploration.policies import check_policy

    check_policy(policy)
    given = [option for option, value in (("--model", model), ("--enough", enough)) if value is not None]
    if given and policy != PREDICTED:
        raise OptionError(f"policy {policy} makes no use of {' and '.join(given)}, give --policy {PREDICTED}")
    if enough is not None and model is None:
        raise OptionError("--enough is a share of what a model lets expect, give --model")


def _make_policy(
    policy: str, model: Path | None, world: World, *, name: str, find: str | None, enough: float | None
) -> Policy:
    """The policy, with what the model of a building's type lets expect; the model is that of the world's type."""
    from pianta.exploration.policies import make_policy

    if model is None:
        return make_policy(policy, find=find, enough=enough)
    from pianta.generation.type_model_file import read_type_model
    from pianta.prediction.prediction import check_model_type
    from pianta.prediction.unexplored_part import FloorSampler

    known = read_type_model(model)
    if world.floor is None:
        raise OptionError(f"world {short_repr(name)} has no rooms that a model could tell of, leave out --model")
    check_model_type(world.floor.given_type, known, f"world {short_repr(name)}")
    labels = {room.label for room in world.floor.rooms if room.label is not None}
    if strange := sorted(label for label in labels if label.upper() not in known.schema.by_name):
        message = (
            f"labels {', '.join(strange)} of world {short_repr(name)} are not in the model's schema, "
            "which expects little there"
        )
        warnings.warn(BuildingWarning(message), stacklevel=2)
    return make_policy(policy, sampler=FloorSampler(known), find=find, enough=enough)


@contextmanager
def _tracking(*, quiet: bool) -> Iterator[Callable[[float], None]]:
    """A progress bar on stderr, where that is a terminal, and the function that moves it to a share."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    from pianta.exploration.beams import has_numba

    if not has_numba() and not quiet:
        stderr.print("without numba this takes long; install it with: pip install 'pianta[sim]'", markup=False)
    columns = TextColumn("exploring"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn()
    hidden = quiet or not stderr.is_terminal
    with Progress(*columns, console=stderr, transient=True, redirect_stdout=sys.stdout.isatty(), disable=hidden) as bar:
        task = bar.add_task("", total=1.0)
        yield lambda share: bar.update(task, completed=share)


def _save_exploration(run: Exploration, world: World, out: Path | None, animation: str) -> None:
    """Write table, picture and animation, all or none."""
    from pianta.plot.exploration import save_animation, save_exploration_picture

    if out is None:
        return
    with atomic_folder(out) as new:
        _save_table(run, new / "area.csv")
        save_exploration_picture(run, world, new / "picture.png")
        if animation != "none":
            with stderr.status(f"drawing exploration.{animation}"):
                save_animation(run, world, new / f"exploration.{animation}", kind=animation)


def _save_table(run: Exploration, path: Path) -> None:
    """Write a row for each scan; with several robots, the metres of each, too."""
    several = run.robot_distance.shape[1] > 1
    robots = [f"robot_{number}_m" for number in range(1, run.robot_distance.shape[1] + 1)] if several else []
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["distance_m", "area_m2", "share", "time_s", *robots])
        for distance, area, share, time, of_robots in zip(
            run.distance, run.area, run.share, run.time, run.robot_distance, strict=True
        ):
            further: Sequence[float] = of_robots.tolist() if several else ()
            figures = [f"{distance:.2f}", f"{area:.2f}", f"{share:.4f}", f"{time:.1f}"]
            table.writerow([*figures, *(f"{metres:.2f}" for metres in further)])


def _tell_exploration(run: Exploration, policy: str, find: str | None, *, written: str) -> None:
    """Print how much was seen on which way, why the run ended, and what was written, if anything."""
    robots = len(run.tracks)
    who = f"{robots} robots" if robots > 1 else "1 robot"
    seen = f"{100 * run.share[-1]:.1f} % of {run.reachable_area:.0f} m²"
    tell_result(f"{who}, {policy}: {seen} seen in {run.distance[-1]:.0f} m, {run.time[-1] / 60:.0f} min: {run.outcome}")
    reached = [(share, run.distance_to(share)) for share in SHARES]
    parts = [f"{100 * share:.0f} % after {metres:.0f} m" for share, metres in reached if isfinite(metres)]
    if parts:
        tell_result(", ".join(parts))
    if find is not None:
        tell_result(f"{find.upper()} is room {run.found_room}" if run.found_room else f"no {find.upper()} was found")
    if written:
        tell_result(written)


def _list_outputs(out: Path | None, animation: str) -> str:
    names = ["area.csv", "picture.png", *([] if animation == "none" else [f"exploration.{animation}"])]
    return "" if out is None else f"in {out}: {', '.join(names)}"
