"""Help texts as they are printed on a terminal of 80 columns."""

from collections.abc import Iterator

import click
import pytest
import typer

from pianta.cli import VERBS, build_app

# Columns of a paragraph: rich leaves one at either side of 80. A longer line is broken, and the next starts anew.
LINE = 78


def list_commands(group: click.Group, path: str = "pianta") -> Iterator[tuple[str, click.Command]]:
    for name, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from list_commands(command, f"{path} {name}")
        else:
            yield f"{path} {name}", command


def list_broken_lines(text: str) -> list[str]:
    """Lines that are too long, of paragraphs with several lines."""
    paragraphs = [paragraph.splitlines() for paragraph in text.split("\n\n")]
    return [line for lines in paragraphs if len(lines) > 1 for line in lines if len(line) > LINE]


COMMANDS = dict(list_commands(typer.main.get_command(build_app(VERBS))))


def test_a_long_line_is_found_in_a_paragraph_only():
    long = "a" * (LINE + 1)
    assert list_broken_lines(f"{long}\n\n{long}\nb\n\nc") == [long]


@pytest.mark.parametrize("name", COMMANDS)
def test_no_line_of_a_paragraph_is_broken(name):
    assert list_broken_lines(COMMANDS[name].help or "") == []
