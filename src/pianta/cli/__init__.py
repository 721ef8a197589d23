"""The command line, one file per verb."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from io import TextIOWrapper
from typing import Annotated

import typer

from pianta import __version__
from pianta.cli.terminal import print_error, print_warnings, show_examples
from pianta.errors import OptionError, PiantaError

# Verb -> the function of its module that runs it; None for a verb with verbs of its own.
VERBS = {
    "read": "read_maps",
    "realism": "judge_floors",
    "generate": "generate",
    "predict": "predict_floor",
    "explore": "explore_world",
    "world": "make_world",
    "train": None,
}


# Entry points of packages that add verbs, each a typer.Typer.
PLUGINS = "pianta.verbs"
# Verbs of packages that may not be installed, and the extra that installs each.
EXTRAS = {"bench": "bench"}


def build_app(verbs: Iterable[str] = VERBS, plugins: Iterable[EntryPoint] = ()) -> typer.Typer:
    """The command line with some verbs, own ones and those of plug-ins; only their modules are imported."""
    app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
    app.callback(invoke_without_command=True)(describe)
    for verb in verbs:
        module, function = import_module(f"pianta.cli.{verb}"), VERBS[verb]
        if function is None:
            app.add_typer(module.app, name=verb)
        else:
            app.command(verb, epilog=show_examples(module.EXAMPLES))(getattr(module, function))
    for plugin in plugins:
        app.add_typer(plugin.load(), name=plugin.name)
    return app


def choose_app(verb: str | None) -> typer.Typer:
    """The command line for a verb, without the modules of other verbs; all verbs where it is none of them.

    Raises OptionError for the verb of a package that is not installed.
    """
    if verb in VERBS:
        return build_app([verb])
    plugins = entry_points(group=PLUGINS)
    if verb in plugins.names:
        return build_app([], [plugins[verb]])
    if verb in EXTRAS:
        raise OptionError(f"the verb {verb} is a package of its own, install it: pip install 'pianta[{EXTRAS[verb]}]'")
    return build_app(VERBS, plugins)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command line, by default the one that the process was started with, and exit.

    The exit code is 0, or 1 when some maps of several could not be read, or 2 when nothing could be done.
    """
    given = sys.argv[1:] if arguments is None else [*arguments]
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # file names can hold what no encoding has
    try:
        with print_warnings():
            app = choose_app(given[0] if given else None)
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
