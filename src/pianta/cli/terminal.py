"""What commands print: results on stdout; errors, warnings and progress on stderr."""

from __future__ import annotations

import os
import re
import sys
import unicodedata
import warnings
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TextIO

import typer
from rich import box
from rich.console import Console, JustifyMethod
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from pianta.errors import BuildingWarning, MapWarning, PlanWarning
from pianta.floor import Floor
from pianta.floor.area_trust import NO_AREA, AreaTrust, round_roughly
from pianta.io._files import count_noun

if TYPE_CHECKING:
    from rich.progress import Progress

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors.")]

OWN_WARNINGS = (MapWarning, BuildingWarning, PlanWarning)

# Arguments of functions whose flags have the same names.
SAME_NAMES = (
    "building_model density earlier jobs max_cells message method page people port previous resolution shard shut "
    "symbols time_limit topic trust_thresholds words"
)
# Messages of the library name arguments of functions; these are their flags.
FLAGS = {
    "labels=False": "--no-labels",
    "label_unknown=True": "--label-unknown",
    "predict_partial=False": "--no-predictions",
    "as_printed=True": "--as-printed",
    "plans=True": "--plans",
    "method='thesis'": "--method thesis",
    "input_kind='map'": "--as map",
    "input_kind='plan'": "--as plan",
    "trust_thresholds=True": "--trust-thresholds",
    "kind=": "--as",
    "building_type=": "--type",
    "room_model=": "--model",
    "schema=": "--labels",
    "exits=": "--exit",
    "scheduler=": "--scheduler",
    "only_failed=": "--retry-failed",
    "resume=False": "--no-resume",
    "explored=": "--explored",
    "georeference=": "--georeference FILE",
    **{f"{name}=": f"--{name.replace('_', '-')}" for name in SAME_NAMES.split()},
}
# Quoted text, such as the name of a file, is left as it is.
_QUOTED = r"""(?<!\w)'(?:[^'\\]|\\.)*'(?!\w)|(?<!\w)"(?:[^"\\]|\\.)*"(?!\w)"""
_ARGUMENT = re.compile(rf"(?<![\w'\"-])({'|'.join(map(re.escape, FLAGS))})(\w?)|{_QUOTED}", re.DOTALL)

# Categories of Unicode that terminals obey, or that hide or move the text beside them: controls, formats such as the
# override of the direction of text, surrogates of names that are not UTF-8, ends of lines and paragraphs.
NOT_SHOWN = ("Cc", "Cf", "Cs", "Zl", "Zp")

# Of a table that is printed into a pipe or file, characters: more than any table has.
PIPE_WIDTH = 100_000

stdout = Console()
stderr = Console(stderr=True)


def print_result(line: str) -> None:
    """Print a line on stdout; above the progress bar, if there is one in the same terminal."""
    # typer.echo keeps the first stream that it used, and would write into the bar.
    sys.stdout.write(f"{escape_controls(line)}\n")
    sys.stdout.flush()


def escape_controls(text: str) -> str:
    r"""A text on one line, without what a terminal obeys; names of files and labels may have any characters.

    >>> print(escape_controls("a" + chr(27) + "[31m" + chr(10) + "b"))
    a\x1b[31m\nb
    """
    return "".join(
        sign if unicodedata.category(sign) not in NOT_SHOWN else sign.encode("unicode_escape").decode() for sign in text
    )


def name_flags(message: str) -> str:
    """A message of the library with arguments of functions replaced by the flags of the command.

    >>> name_flags("map 'a.png' is no plan, leave out page= or give input_kind='plan'; page=3")
    "map 'a.png' is no plan, leave out --page or give --as plan; --page 3"
    """

    def name_flag(match: re.Match[str]) -> str:
        if match[1] is None:
            return match[0]
        return FLAGS[match[1]] + (f" {match[2]}" if match[2] else "")

    return _ARGUMENT.sub(name_flag, message)


def print_error(error: Exception) -> None:
    """Print an error as one line on stderr."""
    _print_message("error", "bold red", str(error))


def _print_message(heading: str, style: str, message: str) -> None:
    stderr.print(Text.assemble((f"{heading}: ", style), escape_controls(name_flags(message))), soft_wrap=True)


def show_examples(commands: Sequence[str]) -> str:
    """Commands as the end of a help text, a line each; typer breaks it at empty lines only."""
    return "\n\n".join(["Examples:", *commands])


@contextmanager
def print_warnings() -> Iterator[None]:
    """A block in which each of pianta's warnings is one line on stderr; warnings of other packages do not change."""
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
                _print_message("warning", "bold yellow", str(message))
            else:
                show_other(message, category, filename, lineno, file, line)

        warnings.showwarning = print_warning
        for own in OWN_WARNINGS:
            warnings.simplefilter("always", own)
        yield


@contextmanager
def counting_files(files: Sequence[str], *, quiet: bool = False) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on stderr if that is a terminal, unless quiet, and the function that moves it.

    The function takes the number of files that are done, and of all.
    """
    with _make_bar(quiet=quiet) as bar:
        task = bar.add_task("", total=len(files))

        def move(done: int, _all: int) -> None:
            bar.update(task, completed=done, description=Path(files[min(done, len(files) - 1)]).name)

        yield move


@dataclass(frozen=True)
class BatchBar:
    """A progress bar of a batch.

    move: takes the number of items that are done, and of all. add_failure: counts a failure. track: wraps the names of
    the steps of an item, which have a bar of their own below it.
    """

    move: Callable[[int, int], None]
    add_failure: Callable[[], None]
    track: Callable[[Sequence[str]], Iterator[str]]


@contextmanager
def counting_batch(*, noun: str, quiet: bool = False) -> Iterator[BatchBar]:
    """A progress bar with rate and remaining time, on stderr if that is a terminal, unless quiet.

    noun: of the items, such as "files".
    """
    failures = 0
    with _make_bar(quiet=quiet, with_rate=True) as bar:
        task = bar.add_task("", total=None, rate="")

        def move(done: int, total: int) -> None:
            speed = bar.tasks[0].speed
            bar.update(task, completed=done, total=total, rate=f"{speed:.2f} {noun}/s" if speed else "")

        def add_failure() -> None:
            nonlocal failures
            failures += 1
            bar.update(task, description=f"{failures} failed")

        def track(names: Sequence[str]) -> Iterator[str]:
            steps = bar.add_task("", total=len(names), rate="")
            try:
                for done, name in enumerate(names):
                    bar.update(steps, completed=done, description=name, refresh=True)
                    yield name
            finally:
                bar.remove_task(steps)

        yield BatchBar(move, add_failure, track)


def track_items(items: Sequence[str], *, quiet: bool = False) -> Iterator[str]:
    """Names or paths one by one, with a progress bar on stderr if that is a terminal, unless quiet."""
    with counting_files(items, quiet=quiet) as move:
        for done, item in enumerate(items):
            move(done, len(items))
            yield item


def _make_bar(*, quiet: bool, with_rate: bool = False) -> Progress:
    """A progress bar on stderr that vanishes at its end; disabled if quiet, or if stderr is no terminal."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    rate = TextColumn("{task.fields[rate]}", markup=False), TimeRemainingColumn()
    return Bar(
        *(*columns, *(rate if with_rate else ())),
        console=stderr,
        transient=True,
        # Output to a pipe must not be drawn into the terminal.
        redirect_stdout=sys.stdout.isatty(),
        disable=quiet or not stderr.is_terminal,
    )


def print_table(table: Table) -> None:
    """Print a table on stdout; where that is no terminal, no cell is wrapped or cut, so that programs can read it."""
    if stdout.is_terminal or "COLUMNS" in os.environ:
        stdout.print(table)
    else:
        Console(width=PIPE_WIDTH).print(table)


def make_table(
    columns: Mapping[str, Sequence[str]], *, left: Collection[str] = (), wrapped: Collection[str] = ()
) -> Table:
    """A table of columns by their headings, without those that are empty in every row.

    left: columns that are aligned left. wrapped: columns whose words become several lines on a narrow terminal.
    """
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    filled = {heading: cells for heading, cells in columns.items() if any(cells)}
    for heading in filled:
        justify: JustifyMethod = "left" if heading in left else "right"
        table.add_column(heading, justify=justify, no_wrap=heading not in wrapped, overflow="fold")
    for row in zip(*filled.values(), strict=True):
        # Names come from files, and are no markup.
        table.add_row(*(escape(escape_controls(cell)) for cell in row))
    return table


def format_area(area: float, area_trust: AreaTrust = AreaTrust.EXACT) -> str:
    """An area, m², without its unit; a rough one has a mark and two digits, an unknown one is a question mark."""
    if area_trust is AreaTrust.UNKNOWN:
        return NO_AREA
    return f"~{round_roughly(area)}" if area_trust is AreaTrust.ROUGH else f"{area:.1f}"


def describe_floor(floor: Floor, area_trust: AreaTrust = AreaTrust.EXACT) -> str:
    """How many rooms, doors, openings, entrances and possible doors there are, and the area of the rooms together.

    area_trust: whether the area is marked, or left out.
    """
    door_kinds = Counter("entrance" if door.is_entrance else door.kind for door in floor.doors)
    counts = {"room": len(floor.rooms), "door": door_kinds["door"]}
    counts |= {noun: door_kinds[noun] for noun in ("opening", "entrance") if door_kinds[noun]}
    counts |= {"possible door": len(floor.possible_doors)} if floor.possible_doors else {}
    listed = ", ".join(count_noun(count, noun) for noun, count in counts.items())
    if area_trust is AreaTrust.UNKNOWN:
        return listed
    return f"{listed}, {format_area(sum(room.polygon.area for room in floor.rooms), area_trust)} m²"
