"""Help texts as they are printed on a terminal of 80 columns."""

from collections.abc import Iterator

import pytest
import typer
from typer.core import TyperGroup

from pianta.cli import VERBS, build_app

# Columns of a paragraph: rich leaves one at either side of 80. A longer line is broken, and the next starts anew.
LINE = 78


def list_helps(group: TyperGroup, path: str = "pianta") -> Iterator[tuple[str, str]]:
    """Commands of a group and of groups in it, with their help texts."""
    for name, command in group.commands.items():
        if isinstance(command, TyperGroup):
            yield from list_helps(command, f"{path} {name}")
        else:
            yield f"{path} {name}", command.help or ""


def list_broken_lines(text: str) -> list[str]:
    """Lines that are too long, of paragraphs with several lines."""
    paragraphs = [paragraph.splitlines() for paragraph in text.split("\n\n")]
    return [line for lines in paragraphs if len(lines) > 1 for line in lines if len(line) > LINE]


HELPS = dict(list_helps(typer.main.get_group(build_app(VERBS))))


def test_commands_of_commands_are_there():
    assert {"pianta read", "pianta train type"} <= set(HELPS)


def test_a_long_line_is_found_in_a_paragraph_only():
    long = "a" * (LINE + 1)
    assert list_broken_lines(f"{long}\n\n{long}\nb\n\nc") == [long]


@pytest.mark.parametrize("name", HELPS)
def test_no_line_of_a_paragraph_is_broken(name):
    assert list_broken_lines(HELPS[name]) == []
