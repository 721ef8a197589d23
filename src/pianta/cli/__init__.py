"""The command line, one file per verb."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from io import TextIOWrapper
from typing import Annotated

import typer

from pianta import __version__
from pianta.cli.terminal import print_error, print_warnings, show_examples
from pianta.errors import OptionError, PiantaError
from pianta.io._files import LACKS, describe_lack, one_line_reason, short_repr

# Verb -> the function of its module that runs it; None for a verb with sub-verbs.
VERBS = {
    "read": "read_maps",
    "collect": "collect_buildings",
    "correct": "correct_floor",
    "convert": "convert_floor",
    "score": "score_floors",
    "view": "view_floors",
    "watch": "watch_map",
    "realism": "assess_floors",
    "patterns": "find_patterns",
    "generate": "generate",
    "predict": "predict_floor",
    "explore": "explore_world",
    "evacuate": "evacuate_floor",
    "world": "make_world",
    "train": None,
}
# Entry points of packages that add verbs, each a typer.Typer.
PLUGINS = "pianta.verbs"
# Verbs of packages that may not be installed, and the extra that installs each.
EXTRAS = {"bench": "bench"}


def build_app(verbs: Iterable[str] = VERBS, plugins: Iterable[EntryPoint] = ()) -> typer.Typer:
    """The command line with the given verbs of pianta and of plug-ins; only their modules are imported.

    verbs: some of VERBS. plugins: entry points of PLUGINS.
    """
    app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
    app.callback(invoke_without_command=True)(describe)
    for verb in verbs:
        module, function = import_module(f"pianta.cli.{verb}"), VERBS[verb]
        if function is None:
            app.add_typer(module.app, name=verb)
        else:
            settings = getattr(module, "SETTINGS", None)
            app.command(verb, epilog=show_examples(module.EXAMPLES), context_settings=settings)(
                getattr(module, function)
            )
    for plugin in plugins:
        app.add_typer(plugin.load(), name=plugin.name)
    return app


def choose_app(verb: str | None) -> typer.Typer:
    """The command line for a verb, without the modules of other verbs; with all verbs if there is no such verb.

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
    """Run a command line, by default that of this process, and exit.

    The exit code is 0; 1 if some of several files could not be read; 2 if nothing could be done.
    """
    arguments = sys.argv[1:] if arguments is None else [*arguments]
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # file names may have characters that cannot be encoded
    try:
        with print_warnings():
            run_app(choose_app(arguments[0] if arguments else None), arguments)
    except PiantaError as error:
        print_error(error)
        sys.exit(2)
    except OSError as error:
        _print_refusal(error)
        sys.exit(2)


def _print_refusal(error: OSError) -> None:
    """Print what the system refuses as one line; raise the error again if it may be our fault."""
    if error.filename is not None:
        # Names of files that the system refuses when they are first looked for, as those that are too long
        print_error(OptionError(f"{short_repr(error.filename)} cannot be used: {one_line_reason(error)}"))
    elif error.errno in LACKS:
        # What is left in the buffer would fail once more at the end
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        print_error(OptionError(describe_lack(error)))
    else:
        raise error


def run_app(app: typer.Typer, arguments: Sequence[str]) -> None:
    """Run a command line and exit; what is wrong in it is one line."""
    try:
        code = app(arguments, prog_name="pianta", standalone_mode=False)
    except typer.Abort:
        sys.exit(1)
    except Exception as error:
        # typer does not export the classes of its errors
        if not hasattr(error, "format_message"):
            raise
        if type(error).__name__ == "NoArgsIsHelpError":
            app(arguments, prog_name="pianta")
        message = " ".join(error.format_message().split())
        end = "" if message.endswith((".", "?")) else "."
        verb = getattr(getattr(error, "ctx", None), "command_path", "pianta")
        print_error(OptionError(f"{message}{end} See `{verb} --help`"))
        sys.exit(2)
    sys.exit(code if isinstance(code, int) else 0)


def describe(
    *, version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False
) -> None:
    """Read buildings from robots' maps and plans: rooms and their use, doors and the topological graph."""
    if version:
        typer.echo(f"pianta {__version__}")
        raise typer.Exit
