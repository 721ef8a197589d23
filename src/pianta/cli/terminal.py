"""What commands print: results on stdout; errors, warnings and progress on stderr."""

from __future__ import annotations

import re
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from rich.console import Console
from rich.text import Text

from pianta.errors import BuildingWarning, MapWarning, PlanWarning
from pianta.floor import Floor

if TYPE_CHECKING:
    from rich.progress import Progress

OWN_WARNINGS = (MapWarning, BuildingWarning, PlanWarning)

# Messages of the library name arguments of functions; these are their flags.
FLAGS = {
    "labels=False": "--no-labels",
    "kind='map'": "--as map",
    "kind='plan'": "--as plan",
    "trust_thresholds=True": "--trust-thresholds",
    "kind=": "--as",
    "building_type=": "--type",
    "room_model=": "--model",
    "schema=": "--labels",
    **{
        f"{name}=": f"--{name.replace('_', '-')}"
        for name in (
            "building_model",
            "jobs",
            "max_cells",
            "method",
            "page",
            "previous",
            "resolution",
            "symbols",
            "trust_thresholds",
            "words",
        )
    },
}
# A quoted text, such as the name of a file, is passed over as a whole.
_QUOTED = r"""(?<!\w)'(?:[^'\\]|\\.)*'(?!\w)|(?<!\w)"(?:[^"\\]|\\.)*"(?!\w)"""
_ARGUMENT = re.compile(rf"(?<![\w'\"-])({'|'.join(map(re.escape, FLAGS))})(\w?)|{_QUOTED}", re.DOTALL)

stdout = Console()
stderr = Console(stderr=True)


def print_result(line: str) -> None:
    """Print a line on stdout; above the progress bar, when there is one in the same terminal."""
    # typer.echo keeps the stream that it saw first, and would write into the bar.
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def name_flags(message: str) -> str:
    """A message of the library with the flags of the command in place of the arguments of functions.

    >>> name_flags("map 'a.png' is no plan, leave out page= or give kind='plan'; page=3")
    "map 'a.png' is no plan, leave out --page or give --as plan; --page 3"
    """

    def name_flag(found: re.Match[str]) -> str:
        if found[1] is None:
            return found[0]
        return FLAGS[found[1]] + (f" {found[2]}" if found[2] else "")

    return _ARGUMENT.sub(name_flag, message)


def print_error(error: Exception) -> None:
    """Print an error as one line on stderr."""
    stderr.print(Text.assemble(("error: ", "bold red"), name_flags(str(error))), soft_wrap=True)


def show_examples(commands: Sequence[str]) -> str:
    """Commands as the end of a help text, a line each, which typer breaks at empty lines only."""
    return "\n\n".join(["Examples:", *commands])


@contextmanager
def print_warnings() -> Iterator[None]:
    """A block in which each of pianta's warnings is one line on stderr; those of others stay what they are."""
    with warnings.catch_warnings():
        show_other = warnings.showwarning

        def print_warning(  # noqa: PLR0917 - Python's own signature
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if issubclass(category, OWN_WARNINGS):
                stderr.print(Text.assemble(("warning: ", "bold yellow"), name_flags(str(message))), soft_wrap=True)
            else:
                show_other(message, category, filename, lineno, file, line)

        warnings.showwarning = print_warning
        for own in OWN_WARNINGS:
            warnings.simplefilter("always", own)
        yield


@contextmanager
def counting_files(files: Sequence[str], *, quiet: bool = False) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on stderr where that is a terminal, unless quiet, and the function that moves it.

    The function takes the number of files that are done, and of all.
    """
    with _make_bar(quiet=quiet) as bar:
        task = bar.add_task("", total=len(files))

        def move(done: int, _all: int) -> None:
            bar.update(task, completed=done, description=Path(files[min(done, len(files) - 1)]).name)

        yield move


def _make_bar(*, quiet: bool) -> Progress:
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    return Bar(
        *columns,
        console=stderr,
        transient=True,
        # What is piped away must not be drawn into the terminal.
        redirect_stdout=sys.stdout.isatty(),
        disable=quiet or not stderr.is_terminal,
    )


def track_items(items: Sequence[str], *, quiet: bool = False) -> Iterator[str]:
    """Names or paths one by one, with a progress bar on stderr where that is a terminal, unless quiet."""
    with _make_bar(quiet=quiet) as bar:
        task = bar.add_task("", total=len(items))
        for item in items:
            bar.update(task, description=Path(item).name)
            yield item
            bar.advance(task)


def describe_floor(floor: Floor) -> str:
    """How many rooms, doors, openings and entrances there are, and the area of the rooms together."""
    kinds = Counter("entrance" if door.is_entrance else door.kind for door in floor.doors)
    counts = {"room": len(floor.rooms), "door": kinds["door"]}
    counts |= {kind: kinds[kind] for kind in ("opening", "entrance") if kinds[kind]}
    told = [f"{count} {noun}{'s' * (count != 1)}" for noun, count in counts.items()]
    area = sum(room.polygon.area for room in floor.rooms)
    return f"{', '.join(told)}, {area:.1f} m²"
