"""Messages of the library become messages of the command: arguments are called by their flags."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.cli.terminal import FLAGS, name_flags
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
