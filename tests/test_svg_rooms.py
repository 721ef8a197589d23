"""Shapes of SVGs that ids, classes or labels name rooms are the rooms, with the corners as drawn."""

from pathlib import Path

import numpy as np
import pytest

import pianta
from pianta.errors import PlanError, PlanWarning
from pianta.io.drawings._room_shapes import ROOMS_LAYER, names_rooms
from pianta.io.drawings.svg import read_svg_plan
from pianta.plan.read_plan import read_plan
from tests.conftest import DATA

pytest.importorskip("svgelements", reason="pianta[svg] is not installed")

SPACES = 'xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
# Two rooms of 40 × 30 units, a third that is L-shaped, and a door of 9 units between the first two
ROOMS = (
    '<rect id="room-lobby" class="room" x="10" y="10" width="40" height="30"/>'
    '<rect id="room-02" class="room" x="52" y="10" width="40" height="30"/>'
    '<path id="path77" class="room" d="M10 42 H92 V80 H50 V60 H10 Z"/>'
    '<text x="60" y="55" font-size="4">Copy room</text>'
    '<line class="door" x1="51" y1="20" x2="51" y2="29"/>'
    '<rect id="outside" class="room" x="-50" y="-50" width="300" height="300"/><text x="200" y="90">Street</text>'
)


def write(path: Path, content: str, attributes: str = "") -> Path:
    path.write_text(f"<svg {SPACES} {attributes}>{content}</svg>")
    return path


def test_rooms_of_a_class_are_read_as_drawn(tmp_path):
    """A door of 9 units is 0.9 m wide, so that a unit is 0.1 m; y goes up."""
    plan = read_plan(write(tmp_path / "plan.svg", ROOMS))
    (storey,) = plan.floors
    assert [(room.number, room.name) for room in storey.floor] == [(None, "lobby"), ("02", None), (None, "Copy room")]
    assert storey.floor[1].polygon.bounds == pytest.approx((1, -4, 5, -1))
    assert storey.floor[3].polygon.area == pytest.approx(0.01 * (82 * 38 - 40 * 20))
    assert [door.room_ids for door in storey.floor.doors] == [(1, 2)]
    assert storey.scale.resolution / storey.grid.resolution == pytest.approx(1)
    assert "1 door of about 0.9 m" in storey.scale.source
    assert storey.scale.interval is not None
    assert plan.notes == ("rooms: closed outlines of layer rooms 3, with the corners as drawn",)


@pytest.mark.parametrize(("attribute", "metres"), [('data-metres-per-unit="0.2"', 0.2), ("", 0.1)])
def test_the_scale_of_the_file_counts_before_that_of_doors(tmp_path, attribute, metres):
    floor = read_plan(write(tmp_path / "plan.svg", ROOMS, attribute)).floors[0].floor
    assert floor[1].polygon.area == pytest.approx(40 * 30 * metres**2)


def test_given_resolution_is_metres_per_unit(tmp_path):
    floor = read_plan(write(tmp_path / "plan.svg", ROOMS), resolution=0.3).floors[0].floor
    assert floor[1].polygon.area == pytest.approx(40 * 30 * 0.3**2)


def test_of_an_element_named_room_the_largest_shape_is_the_room_and_of_rooms_all_are(tmp_path):
    content = (
        '<g id="room_12"><rect width="30" height="30"/><rect x="5" y="5" width="9" height="4"/></g>'
        '<g inkscape:label="Rooms"><rect inkscape:label="Kitchen" x="40" width="30" height="30"/>'
        '<rect id="rect31-2" x="80" width="30" height="30"/></g>'
    )
    drawing = read_svg_plan(write(tmp_path / "plan.svg", content + ROOMS))
    assert [np.ptp(outline.ring, axis=0).tolist() for outline in drawing.outlines[:3]] == [[30, 30]] * 3
    assert {outline.layer for outline in drawing.outlines} == {ROOMS_LAYER}
    assert [(stamp.number, stamp.name) for stamp in drawing.stamps[:2]] == [("12", ""), ("", "Kitchen")]


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["room"], True),
        (["path3", "Space Bedroom"], True),
        (["Raum-101"], True),
        (["room-label"], False),
        (["bathroom"], False),
        (["path3"], False),
    ],
)
def test_names_that_mean_rooms(names, expected):
    assert names_rooms(names) is expected


def test_shapes_named_rooms_that_lie_apart_are_no_rooms(tmp_path):
    """Three small boxes far from each other tile no floor, so that the sheet is drawn and read."""
    boxes = "".join(f'<rect class="room" x="{900 * k}" width="9" height="9"/>' for k in range(3))
    drawing = read_svg_plan(write(tmp_path / "plan.svg", boxes))
    assert len(drawing.outlines) == 3
    with pytest.raises(PlanError, match="plan"):
        read_plan(tmp_path / "plan.svg")


@pytest.mark.skipif(not (DATA / "planfiles").exists(), reason=f"no planfiles in {DATA}")
def test_a_plan_of_a_research_site_has_its_30_rooms():
    """Its file names 32 rooms: one is "outside" around the others, and one goes around three others."""
    with pytest.warns(PlanWarning, match="1 image"):
        floor = read_plan(DATA / "planfiles" / "svg" / "dfki_selfie.svg").floors[0].floor
    assert len(floor) == 30
    names = {room.name for room in floor}
    assert {"CONTROL ROOM", "LOBBY", "BOILER ROOM", "HEALTH PHYSICS"} <= names
    assert len(floor.doors) >= 30


@pytest.mark.parametrize(("door", "count"), [('<line class="door" x1="51" y1="20" x2="51" y2="29"/>', 0), ("", 1)])
def test_a_plan_without_doors_between_rooms_has_a_note(tmp_path, door, count):
    content = ROOMS.replace('<line class="door" x1="51" y1="20" x2="51" y2="29"/>', door)
    reading = pianta.read(write(tmp_path / "plan.svg", content), labels=False)
    assert len([message for message in reading.messages if message.startswith("graph: doors")]) == count
