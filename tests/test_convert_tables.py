"""Floors as tables: CSV and Excel."""

import csv

import pytest
from shapely import LineString, box

import pianta
from pianta.io.writers.room_texts import split_number

# Two rooms of 4 m x 3 m north of a corridor of 8 m x 2 m; walls have no thickness.
FLOOR = pianta.Floor(
    (
        pianta.Room(1, box(0, 2, 4, 5), "OFFICE", name="2502C Rossi"),
        pianta.Room(2, box(4, 2, 8, 5), "OFFICE", name='=HYPERLINK("x")'),
        pianta.Room(3, box(0, 0, 8, 2), "CORRIDOR"),
    ),
    (
        pianta.Door((1, 3), LineString([(1, 2), (2, 2)]), 1.0),
        pianta.Door((2, 3), LineString([(6, 2), (7, 2)]), 1.0, "opening"),
        pianta.Door((3, None), LineString([(0, 0.5), (0, 1.5)]), 1.0),
    ),
)
HOUSE = pianta.Building((pianta.Storey(FLOOR, "ground"), pianta.Storey(pianta.Floor(FLOOR.rooms[:1]), "first")))


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("2502C", ("2502C", None)),
        ("Office 12", ("12", "Office")),
        ("Sala Riunioni", (None, "Sala Riunioni")),
        (None, (None, None)),
        ("B-1.04 Lab", ("B-1.04", "Lab")),
    ],
)
def test_numbers_and_names_are_two_columns(name, parts):
    assert split_number(name) == parts


def test_csv_has_a_row_for_each_room(tmp_path):
    notes = pianta.convert(HOUSE, tmp_path / "rooms.csv", to="csv")
    with (tmp_path / "rooms.csv").open(encoding="utf-8", newline="") as file:
        heading, *rows = csv.reader(file)
    assert heading[:6] == ["storey", "id", "number", "name", "label", "probability"]
    assert rows == [
        ["ground", "1", "2502C", "Rossi", "OFFICE", "", "12.0", "14.0", "1", "3", "", ""],
        ["ground", "2", "", '\'=HYPERLINK("x")', "OFFICE", "", "12.0", "14.0", "1", "3", "", ""],
        ["ground", "3", "", "", "CORRIDOR", "", "16.0", "20.0", "3", "1 2", "", ""],
        ["first", "1", "2502C", "Rossi", "OFFICE", "", "12.0", "14.0", "0", "", "", ""],
    ]
    assert notes == ["1 text would be formulas in a spreadsheet and begin with ' here: '=HYPERLINK(\"x\")'"]


def test_excel_has_rooms_doors_and_totals(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    pianta.convert(HOUSE, tmp_path / "rooms.xlsx", to="excel")
    book = openpyxl.load_workbook(tmp_path / "rooms.xlsx")
    rooms, doors, totals = ([list(row) for row in book[name].values] for name in ("Rooms", "Doors", "Totals"))
    assert rooms[1] == ["ground", 1, "2502C", "Rossi", "OFFICE", None, 12, 14, 1, "3", None, None]
    # A text, not a formula
    assert (book["Rooms"]["D3"].value, book["Rooms"]["D3"].data_type) == ('=HYPERLINK("x")', "s")
    assert doors[1:] == [
        ["ground", 1, 3, "door", 1, 1.5, 2],
        ["ground", 2, 3, "opening", 1, 6.5, 2],
        ["ground", 3, None, "door", 1, 0, 1],
    ]
    assert totals[1:] == [
        ["ground", "CORRIDOR", 1, 16],
        ["ground", "OFFICE", 2, 24],
        ["ground", "all", 3, 40],
        ["first", "OFFICE", 1, 12],
        ["first", "all", 1, 12],
        ["all", "all", 4, 52],
    ]
