"""The verb explore: a simulated robot in a building that it does not know."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pianta.cli.terminal import Quiet, describe_floor, print_result, stderr
from pianta.errors import BuildingWarning, OptionError
from pianta.io._files import count_noun, short_repr
from pianta.io._folders import atomic_folder, check_output_folder, number_outputs

if TYPE_CHECKING:
    from pianta.exploration.policy_input import Policy
    from pianta.exploration.record import Exploration
    from pianta.exploration.world import World
    from pianta.mapping.mapper import Mapper

PREDICTED = "predicted"
POLICY_NAMES = ("nearest", "gain", "gain-exp", PREDICTED)
PERFECT, MAP = PERCEPTION_NAMES = ("perfect", "map")
ANIMATIONS = ("gif", "mp4", "none")
# Reading a map takes about a second.
DEFAULT_STEPS = 12
SHARES = (0.5, 0.9, 0.99)
EXAMPLES = (
    "pianta explore ring -o exploration",
    "pianta explore school.xml --policy gain --robots 2 -o exploration",
    "pianta explore school.xml --policy predicted --model others.json --find gym",
    "pianta explore building --policy predicted --model school.json --enough 0.95 --start 1.5,2",
    "pianta explore map.yaml --policy predicted --model school.json --perception map",
    "pianta explore school.xml --perception map --find corridor",
    "pianta explore map.yaml --stop 0.9 --animation none -o exploration",
)

World_ = Annotated[
    str,
    typer.Argument(
        metavar="WORLD",
        help="A floor or building file, a folder of `pianta read` or `world`, a map.yaml, or a KIND of `pianta world`.",
    ),
]
PolicyOption = Annotated[
    str,
    typer.Option(
        "--policy",
        help=f"How the next frontier is chosen: {', '.join(POLICY_NAMES)}; the last without --model by geometry alone.",
    ),
]
Model = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="For predicted: a model of the building's type, of `pianta train type`."),
]
Enough = Annotated[
    float | None,
    typer.Option(metavar="SHARE", help="For predicted: stop when this share of the floor is expected to be explored."),
]
PerceptionOption = Annotated[
    str,
    typer.Option(
        "--perception",
        help="For predicted and --find: perfect if robots know true rooms that they see, map if they read them from "
        "their map.",
    ),
]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="Folder for table, picture and animation.")]
Robots = Annotated[int, typer.Option(help="How many robots; they share their map.")]
Find = Annotated[
    str | None,
    typer.Option(
        metavar="LABEL",
        help="End when a room of this label is recognised; with --perception map when the robots' own map has one with "
        "a probability of a half or more, else the likeliest room is named at the end.",
    ),
]
Start = Annotated[
    list[str] | None,
    typer.Option(
        metavar="X,Y", help="Where a robot starts, metres of the map frame; once for each robot. Default: the entrance."
    ),
]
Stop = Annotated[
    float | None, typer.Option(metavar="SHARE", help="End when this share of the area is explored; all unless given.")
]
Reach = Annotated[float, typer.Option(help="Range of the lidar, metres.")]
Noise = Annotated[float, typer.Option(help="Standard deviation of the lidar's ranges, metres.")]
Radius = Annotated[float, typer.Option(help="Radius of a robot, metres.")]
DriveOption = Annotated[str, typer.Option("--drive", help="point moves in any direction; differential turns first.")]
MaxDistance = Annotated[
    float | None, typer.Option(help="End after this many metres; derived from the area unless given.")
]
Seed = Annotated[int, typer.Option(min=0, help="Of the noise, and of a synthetic building.")]
Steps = Annotated[
    int, typer.Option(help="With -o: at how many steps the map and the floor read from it are written.", min=0, max=200)
]
Animation = Annotated[str, typer.Option(help=f"One of {', '.join(ANIMATIONS)}; mp4 needs ffmpeg.")]


def explore_world(
    world: World_,
    *,
    policy: PolicyOption = "nearest",
    model: Model = None,
    enough: Enough = None,
    perception: PerceptionOption = PERFECT,
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
    steps: Steps = DEFAULT_STEPS,
    quiet: Quiet = False,
) -> None:
    """Let simulated robots with lidars explore an unknown building.

    With -o writes area.csv (explored area over metres driven), picture.png,
    exploration.gif, and for the timeline of `pianta view` exploration.json and
    the map and the floor of each step, step-001.npz, step-001.geojson and so on.
    Entrances are closed; rooms too narrow for the robots are
    left out.
    """
    from pianta.exploration.explore import explore
    from pianta.exploration.lidar import Lidar
    from pianta.exploration.world import open_world

    step_names = [] if out is None else _check_outputs(out, animation, steps)
    _check_policy(policy, model, enough, None if find else perception)
    _check_perception(policy, model, perception)
    starts, lidar = [read_point(text) for text in start or ()] or None, Lidar(reach=reach, noise=noise)
    stop_share = "all" if stop is None else stop
    opened = open_world(world, seed=seed)
    chosen = _make_policy(policy, model, opened, name=world, find=find, enough=enough, perception=perception)
    mapper = _make_mapper(model) if perception == MAP else None
    with _tracking(quiet=quiet) as track:
        run = explore(opened, chosen, starts=starts, lidar=lidar, robots=robots, radius=radius, drive=drive,
                      stop=stop_share, find=find, perception=mapper or perception, max_distance=max_distance,
                      seed=seed, track=track)  # fmt: skip
    names = []
    if out is not None:
        with stderr.status("drawing, and reading maps"):
            names = _save_exploration(
                run, opened, out, animation, step_names, title=(world, policy), mapper=_make_mapper(model)
            )
    if not quiet:
        _print_exploration(run, policy, find, on_map=mapper is not None)
        if mapper is not None:
            if mapper.floor.rooms:
                mapper.finish()
            print_result(f"the robots read {describe_floor(mapper.floor)}")
        if names:
            print_result(f"in {out}: {', '.join(names)}")


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


def _check_outputs(out: Path, animation: str, steps: int) -> list[str]:
    """The names of the steps; raises OptionError for a folder or an animation that cannot be written."""
    from pianta.plot.exploration import check_animation

    check_output_folder(out)
    if animation != "none":
        check_animation(animation)
    return number_outputs("step", steps, out)


def _check_policy(policy: str, model: Path | None, enough: float | None, perception: str | None) -> None:
    """Raise OptionError for an unknown policy, and for options that it does not use; perception: None for a search."""
    from pianta.exploration.policies import check_policy

    check_policy(policy)
    options = [option for option, value in (("--model", model), ("--enough", enough)) if value is not None]
    options += ["--perception"] if perception == MAP else []
    if options and policy != PREDICTED:
        raise OptionError(f"policy {policy} does not use {' and '.join(options)}, give --policy {PREDICTED}")
    if enough is not None and model is None:
        raise OptionError("--enough is a share of the floor that a model predicts, give --model")


def _check_perception(policy: str, model: Path | None, perception: str) -> None:
    """Raise OptionError for an unknown perception, and without the model that the policy compares rooms with."""
    from pianta.exploration.perceptions import check_perception

    check_perception(perception)
    if policy == PREDICTED and perception == MAP and model is None:
        raise OptionError(f"with --perception {perception} robots compare rooms with a model, give --model")


def _make_mapper(model: Path | None) -> Mapper:
    """A mapper of buildings of the type of a model."""
    from pianta.generation.type_model_file import read_type_model
    from pianta.mapping.mapper import Mapper

    return Mapper(building_type=None if model is None else read_type_model(model).building_type)


def _make_policy(
    policy: str,
    model: Path | None,
    world: World,
    *,
    name: str,
    find: str | None,
    enough: float | None,
    perception: str,
) -> Policy:
    """The policy, with a model of the building type of the world, if one is given."""
    from pianta.exploration.policies import make_policy

    if model is None:
        return make_policy(policy, find=find, enough=enough)
    from pianta.generation.type_model import check_model_type
    from pianta.generation.type_model_file import read_type_model
    from pianta.prediction.unexplored_part import FloorSampler

    type_model, quoted = read_type_model(model), short_repr(name)
    if perception == MAP:
        return make_policy(policy, sampler=FloorSampler(type_model), find=find, enough=enough)
    if world.floor is None:
        raise OptionError(
            f"world {quoted} has no rooms to compare with a model, leave out --model, or give --perception {MAP}"
        )
    check_model_type(world.floor.given_type, type_model, f"world {quoted}")
    labels = {room.label for room in world.floor.rooms if room.label is not None}
    if unknown := sorted(label for label in labels if label.upper() not in type_model.schema.by_name):
        message = f"the model does not have labels {', '.join(unknown)} of world {quoted}, and predicts little there"
        warnings.warn(BuildingWarning(message), stacklevel=2)
    return make_policy(policy, sampler=FloorSampler(type_model), find=find, enough=enough)


@contextmanager
def _tracking(*, quiet: bool) -> Iterator[Callable[[float], None]]:
    """A progress bar on stderr if that is a terminal, and the function that moves it to a share."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    from pianta.exploration.beams import has_numba

    if not has_numba() and not quiet:
        stderr.print("without numba this takes long; install it with: pip install 'pianta[sim]'", markup=False)
    columns = TextColumn("exploring"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn()
    hidden = quiet or not stderr.is_terminal
    with Progress(*columns, console=stderr, transient=True, redirect_stdout=sys.stdout.isatty(), disable=hidden) as bar:
        task = bar.add_task("", total=1.0)
        yield lambda share: bar.update(task, completed=share)


def _save_exploration(
    run: Exploration,
    world: World,
    out: Path,
    animation: str,
    steps: list[str],
    *,
    title: tuple[str, str],
    mapper: Mapper,
) -> list[str]:
    """Write table, picture, animation and steps, all or none; their names.

    title: of the world, and of the policy. mapper: reads the maps of the steps.
    """
    from pianta.exploration.steps import FILE_NAME, save_steps
    from pianta.plot.exploration import draw_exploration, save_animation
    from pianta.plot.figure import save_figure

    names = ["area.csv", "picture.png", *([] if animation == "none" else [f"exploration.{animation}"])]
    with atomic_folder(out) as new:
        _save_table(run, new / names[0])
        save_figure(draw_exploration(run, world), new / names[1])
        for name in names[2:]:
            save_animation(run, world, new / name, file_format=animation)
        if steps:
            save_steps(run, steps, new, world=title[0], policy=title[1], mapper=mapper)
    return [*names, FILE_NAME, "step-*"] if steps else names


def _save_table(run: Exploration, path: Path) -> None:
    """Write a row for each scan; with several robots, also the metres of each."""
    import numpy as np

    robots = run.robot_distance.shape[1] if run.robot_distance.shape[1] > 1 else 0
    names = ["distance_m", "area_m2", "share", "time_s", *(f"robot_{number}_m" for number in range(1, robots + 1))]
    formats = ["%.2f", "%.2f", "%.4f", "%.1f", *["%.2f"] * robots]
    table = np.column_stack([run.distance, run.area, run.share, run.time, run.robot_distance[:, :robots]])
    np.savetxt(path, table, fmt=formats, delimiter=",", newline="\r\n", header=",".join(names), comments="")


def _print_exploration(run: Exploration, policy: str, find: str | None, *, on_map: bool) -> None:
    """Print how much was explored on how many metres, why the run ended, and whether a room was found."""
    explored = f"{100 * run.share[-1]:.1f} % of {run.reachable_area:.0f} m² seen"
    effort = f"{run.distance[-1]:.0f} m, {run.time[-1] / 60:.0f} min"
    print_result(f"{count_noun(len(run.tracks), 'robot')}, {policy}: {explored} in {effort}: {run.outcome}")
    distances = [(share, run.distance_to(share)) for share in SHARES]
    reached = [f"{100 * share:.0f} % after {metres:.0f} m" for share, metres in distances if isfinite(metres)]
    if reached:
        print_result(", ".join(reached))
    if find is not None:
        print_result(_describe_search(run, find.upper(), on_map=on_map))


def _describe_search(run: Exploration, label: str, *, on_map: bool) -> str:
    """Which room was found, and whether robots that read rooms from their map are right."""
    if run.found_room is None:
        return f"no {label} was found"
    if not on_map:
        return f"{label} is room {run.found_room}"
    truth = {True: ", which is right", False: ", which is wrong", None: ""}[run.is_found_room_right]
    room = f"room {run.found_room} of the robots' map ({100 * (run.found_probability or 0.0):.0f} %){truth}"
    is_found = run.outcome.startswith("found ")
    return f"{label} is {room}" if is_found else f"no room is surely {label}, the likeliest is {room}"
