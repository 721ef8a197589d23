"""The command line, one file per verb."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from io import TextIOWrapper
from typing import Annotated

import typer

from pianta import __version__
from pianta.cli import (
    bench,
    bench_exploration,
    bench_plans,
    explore,
    generate,
    predict,
    read,
    realism,
    train,
    world,
)
from pianta.cli.terminal import show_examples, tell_error, telling_warnings
from pianta.errors import PiantaError

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
app.command("read", epilog=show_examples(read.EXAMPLES))(read.read_maps)
app.command("realism", epilog=show_examples(realism.EXAMPLES))(realism.judge_floors)
app.command("generate", epilog=show_examples(generate.EXAMPLES))(generate.generate)
app.command("predict", epilog=show_examples(predict.EXAMPLES))(predict.predict_floor)
app.command("explore", epilog=show_examples(explore.EXAMPLES))(explore.explore_world)
app.command("world", epilog=show_examples(world.EXAMPLES))(world.make_world)
app.add_typer(train.app, name="train")
bench.app.command("exploration", epilog=show_examples(bench_exploration.EXAMPLES))(bench_exploration.bench_exploration)
bench.app.command("plans", epilog=show_examples(bench_plans.EXAMPLES))(bench_plans.bench_plans)
app.add_typer(bench.app, name="bench")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command line, by default the one that the process was started with, and exit.

    The exit code is 0, or 1 when some maps of several could not be read, or 2 when nothing could be done.
    """
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # file names can hold what no encoding has
    try:
        with telling_warnings():
            app(arguments, prog_name="pianta")
    except PiantaError as error:
        tell_error(error)
        sys.exit(2)


@app.callback(invoke_without_command=True)
def describe(
    *, version: Annotated[bool, typer.Option("--version", help="Print the version and leave.")] = False
) -> None:
    """Read buildings: rooms, what each is for, doors and the topological graph, from a robot's map."""
    if version:
        typer.echo(f"pianta {__version__}")
        raise typer.Exit
