"""The command line, one file per verb."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from importlib import import_module
from io import TextIOWrapper
from typing import Annotated

import typer

from pianta import __version__
from pianta.cli.terminal import print_error, print_warnings, show_examples
from pianta.errors import PiantaError

# Verb -> the function of its module that runs it; None for a verb with verbs of its own.
VERBS = {
    "read": "read_maps",
    "realism": "judge_floors",
    "generate": "generate",
    "predict": "predict_floor",
    "explore": "explore_world",
    "world": "make_world",
    "train": None,
    "bench": None,
}


def build_app(verbs: Iterable[str] = VERBS) -> typer.Typer:
    """The command line with some verbs; only their modules are imported."""
    app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
    app.callback(invoke_without_command=True)(describe)
    for verb in verbs:
        module, function = import_module(f"pianta.cli.{verb}"), VERBS[verb]
        if function is None:
            app.add_typer(module.app, name=verb)
        else:
            app.command(verb, epilog=show_examples(module.EXAMPLES))(getattr(module, function))
    return app


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command line, by default the one that the process was started with, and exit.

    The exit code is 0, or 1 when some maps of several could not be read, or 2 when nothing could be done.
    """
    given = sys.argv[1:] if arguments is None else [*arguments]
    app = build_app(given[:1] if given and given[0] in VERBS else VERBS)
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # file names can hold what no encoding has
    try:
        with print_warnings():
            app(given, prog_name="pianta")
    except PiantaError as error:
        print_error(error)
        sys.exit(2)


def describe(
    *, version: Annotated[bool, typer.Option("--version", help="Print the version and leave.")] = False
) -> None:
    """Read buildings: rooms, what each is for, doors and the topological graph, from a robot's map."""
    if version:
        typer.echo(f"pianta {__version__}")
        raise typer.Exit
