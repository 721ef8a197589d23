"""Messages of the library become messages of the command: arguments are called by their flags."""

import warnings
from io import StringIO
from unittest.mock import patch

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from pianta.cli.terminal import (
    FLAGS,
    escape_controls,
    make_table,
    name_flags,
    print_error,
    print_result,
    print_warnings,
)
from pianta.errors import BuildingWarning, PiantaError
from pianta.io._files import short_repr

NAMES = st.text(max_size=40) | st.lists(st.sampled_from([*FLAGS, " ", "'", '"', "\\", "a"]), max_size=8).map("".join)


@pytest.mark.parametrize(
    ("message", "fragment"),
    [
        ("map 'a.png' is no plan, leave out page= or give input_kind='plan'", "--page or give --as plan"),
        ("labels=False makes room_model= and words= useless", "--no-labels makes --model and --words useless"),
        ("lift it with max_cells=", "lift it with --max-cells"),
        ("give the schema of their labels by schema=, or school", "by --labels, or school"),
        ("give page=3", "give --page 3"),
        ("building_model=: it is missing", "--building-model: it is missing"),
        ("trust_thresholds=True or trust_thresholds=", "--trust-thresholds or --trust-thresholds"),
        ("pianta's page= and the floors' page=", "pianta's --page and the floors' --page"),
    ],
)
def test_arguments_are_called_by_their_flags(message, fragment):
    assert fragment in name_flags(message)


@pytest.mark.parametrize(
    "message", ["webpage=3", "my-page=", "page", "it is of type 'page=3'", "'a page=1.png' is no map", '"it\'s page="']
)
def test_all_else_stays(message):
    assert name_flags(message) == message


@given(NAMES)
def test_quoted_names_stay(name):
    assert name_flags(f"map {short_repr(name)} is damaged") == f"map {short_repr(name)} is damaged"


@given(NAMES, NAMES)
def test_what_stands_beside_quoted_names_does_not(one, other):
    quoted, again = short_repr(one), short_repr(other)
    assert name_flags(f"{quoted} has page=, {again}: kind=") == f"{quoted} has --page, {again}: --as"


@given(st.text())
def test_messages_without_arguments_stay(message):
    assert "=" in message or name_flags(message) == message


# Escape, the one-byte escape of C1, a line's end, an override of the direction of text, a byte that is not UTF-8.
HOSTILE = "a\x1b[31m\x9b31m\n\u202e\udcffb"
ESCAPED = r"a\x1b[31m\x9b31m\n\u202e\udcffb"


def test_controls_are_shown_and_not_obeyed(capsys):
    print_result(HOSTILE)
    assert capsys.readouterr().out == f"{ESCAPED}\n"


def test_letters_of_any_language_and_spaces_stay():
    assert escape_controls("Büro\u00a0中文 – é") == "Büro\u00a0中文 – é"


def test_messages_and_cells_are_one_line_without_controls():
    stream = StringIO()
    console = Console(file=stream, width=200)
    with patch("pianta.cli.terminal.stderr", console), print_warnings():
        print_error(PiantaError(f"floor {HOSTILE}"))
        warnings.warn(BuildingWarning(f"floor {HOSTILE}"), stacklevel=1)
    console.print(make_table({"label": [HOSTILE]}))
    text = stream.getvalue()
    assert text.splitlines()[:2] == [f"error: floor {ESCAPED}", f"warning: floor {ESCAPED}"]
    assert sum(ESCAPED in line for line in text.splitlines()) == 3
    assert not {*HOSTILE} & {*text} - {*ESCAPED, "\n"}
