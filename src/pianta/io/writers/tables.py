"""Tables of rooms: CSV, and Excel with doors and totals."""

from __future__ import annotations

import csv
import re
import zipfile
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from pianta.building import Building, Storey
from pianta.floor import Room
from pianta.floor.area_trust import AreaTrust
from pianta.io._files import count_noun, short_repr
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.room_texts import number_and_name

ROOM_COLUMNS = (
    *(
        "storey",
        "id",
        "number",
        "name",
        "label",
        "probability",
        "area_m2",
        "perimeter_m",
        "doors",
        "neighbours",
        "flag",
        "global_id",
    ),
)
DOOR_COLUMNS = ("storey", "room", "other_room", "kind", "width_m", "x", "y")
TOTAL_COLUMNS = ("storey", "label", "rooms", "area_m2")
# In place of a storey and of a label, in totals.
ALL = "all"
# The last column of rooms and totals, if the scale of any storey is doubtful.
ROUGH_COLUMN = "area_is_rough"
# Digits after the point: centimetres, and square decimetres.
DIGITS = 2
# Spreadsheets run a text that begins with one of these as a formula (OWASP, CSV injection).
FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
MAX_LISTED = 3  # names in a note
# Of the columns of a sheet, in characters.
MIN_WIDTH, MAX_WIDTH = 8, 40

if TYPE_CHECKING:
    from openpyxl import Workbook
    from openpyxl.cell import Cell

# Equal buildings give equal bytes: the oldest time that a ZIP can have
WRITTEN = datetime(1980, 1, 1)  # openpyxl takes no zone
PROPERTIES = "docProps/core.xml"
_MODIFIED = re.compile(rb"(<dcterms:modified[^>]*>)[^<]*")

Value: TypeAlias = str | float | None
Row: TypeAlias = list[Value]


def write_csv(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """A row for each room; the ids of neighbours are separated by blanks."""
    columns, rows = _mark_rough(building, ROOM_COLUMNS, list_room_rows(building))
    formulas = [text for row in rows for text in row if isinstance(text, str) and text.startswith(FORMULA_STARTS)]
    with target.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows([[_quote_formula(value) for value in row] for row in rows])
    if not formulas:
        return []
    listed = ", ".join(map(short_repr, formulas[:MAX_LISTED])) + (", …" if len(formulas) > MAX_LISTED else "")
    return [f"{count_noun(len(formulas), 'text')} would be formulas in a spreadsheet and begin with ' here: {listed}"]


def write_excel(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """The sheets Rooms, Doors and Totals."""
    from openpyxl import Workbook

    workbook = Workbook(write_only=True)
    _add_sheet(workbook, "Rooms", *_mark_rough(building, ROOM_COLUMNS, list_room_rows(building)))
    _add_sheet(workbook, "Doors", DOOR_COLUMNS, _list_door_rows(building))
    _add_sheet(workbook, "Totals", *_mark_rough(building, TOTAL_COLUMNS, list_totals(building)))
    workbook.properties.created = workbook.properties.modified = WRITTEN
    workbook.save(target)
    _forget_times(target)
    return []


def _forget_times(target: Path) -> None:
    """Write an archive again without the times of its members and of its properties."""
    with zipfile.ZipFile(target) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    # openpyxl writes the time of saving, whatever the property is
    members[PROPERTIES] = _MODIFIED.sub(
        rb"\g<1>%s" % WRITTEN.strftime("%Y-%m-%dT%H:%M:%SZ").encode(), members[PROPERTIES]
    )
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(zipfile.ZipInfo(name, WRITTEN.timetuple()[:6]), content, zipfile.ZIP_DEFLATED)


def list_room_rows(building: Building) -> Iterator[Row]:
    """The values of ROOM_COLUMNS, room by room."""
    for storey, room in building.list_rooms():
        yield _describe_room(storey, room)


def list_totals(building: Building) -> Iterator[Row]:
    """The values of TOTAL_COLUMNS: for each label of each storey, for each storey, and for the building."""
    building_rooms: list[Room] = []
    for storey in building:
        by_label: dict[str, list[Room]] = defaultdict(list)
        for room in storey.floor:
            by_label[room.label or ""].append(room)
        for label in sorted(by_label):
            yield _sum_rooms(storey.name, label or None, by_label[label])
        building_rooms += storey.floor.rooms
        if len(building) > 1:
            yield _sum_rooms(storey.name, ALL, storey.floor.rooms)
    yield _sum_rooms(ALL, ALL, building_rooms)


def _mark_rough(building: Building, columns: Sequence[str], rows: Iterable[Row]) -> tuple[Sequence[str], list[Row]]:
    """The table with ROUGH_COLUMN, yes or no, if any storey has rough areas; each row begins with its storey."""
    rough = {storey.name for storey in building if storey.area_trust is not AreaTrust.EXACT}
    if not rough:
        return columns, [*rows]
    return (*columns, ROUGH_COLUMN), [[*row, "yes" if row[0] in {*rough, ALL} else "no"] for row in rows]


def _describe_room(storey: Storey, room: Room) -> Row:
    doors = [door for door in storey.floor.doors if room.id in door.room_ids]
    neighbours = sorted({other for door in doors for other in door.room_ids} - {room.id})
    number, name = number_and_name(room)
    probability = room.label_probability
    return [
        *(storey.name, room.id, number, name, room.label),
        None if probability is None else round(probability, DIGITS),
        *(round(size, DIGITS) for size in (room.polygon.area, room.polygon.length)),
        *(len(doors), " ".join(map(str, neighbours)), room.flag, room.global_id),
    ]


def _list_door_rows(building: Building) -> Iterator[Row]:
    for storey in building:
        for door in storey.floor.doors:
            middle = door.line.interpolate(0.5, normalized=True)
            sizes = (round(size, DIGITS) for size in (door.width, middle.x, middle.y))
            yield [storey.name, *door.rooms, door.kind, *sizes]


def _sum_rooms(storey: str, label: str | None, rooms: Sequence[Room]) -> Row:
    return [storey, label, len(rooms), round(sum(room.polygon.area for room in rooms), DIGITS)]


def _quote_formula(value: Value) -> Value:
    if not isinstance(value, str):
        return value
    return f"'{value}" if value.startswith(FORMULA_STARTS) else value


def _add_sheet(workbook: Workbook, title: str, columns: Sequence[str], rows: Iterable[Row]) -> None:
    """A sheet with a heading that stays in view and a filter; texts are texts, not formulas."""
    from openpyxl.cell import WriteOnlyCell
    from openpyxl.styles import Font
    from openpyxl.utils import get_column_letter

    listed = [*rows]
    sheet = workbook.create_sheet(title)
    for number, column in enumerate(columns, start=1):
        longest = max([len(column), *(len(str(row[number - 1])) for row in listed)])
        sheet.column_dimensions[get_column_letter(number)].width = min(max(longest + 2, MIN_WIDTH), MAX_WIDTH)
    sheet.freeze_panes = "A2"
    sheet.auto_filter.ref = f"A1:{get_column_letter(len(columns))}{len(listed) + 1}"

    def make_cell(value: Value, *, bold: bool = False) -> Cell:
        cell = WriteOnlyCell(sheet, value)
        if isinstance(value, str):
            cell.data_type = "s"
        if bold:
            cell.font = Font(bold=True)
        return cell

    sheet.append([make_cell(column, bold=True) for column in columns])
    for row in listed:
        sheet.append([make_cell(value) for value in row])
