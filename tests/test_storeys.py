"""The storeys of an IFC are floors in the frame of the model, each in a frame to be drawn in."""

import numpy as np
import pytest

from pianta.errors import PlanError
from pianta.gridmap import UNKNOWN
from pianta.plan.read_plan import CELL, MARGIN, MAX_SIDE_CELLS, read_plan, read_storeys
from pianta.plan.sheets.sheet import PlanScale
from tests.test_ifc_plan import LAB, OFFICE, Model


@pytest.fixture
def path(tmp_path):
    """Two storeys: an office and a lab with a door between them, and a lab above."""
    model = Model()
    upper, ground = model.storey("Upper", 3000.0), model.storey("Ground", 0.0)
    model.space(ground, OFFICE, Name="Office")
    model.space(ground, LAB, Name="Lab")
    model.door(ground, (5100, 1000))
    model.space(upper, LAB, Name="Lab above")
    model.file.write(str(tmp_path / "house.ifc"))
    return tmp_path / "house.ifc"


def test_storeys_come_from_the_lowest_to_the_highest_with_their_names(path):
    ground, upper = read_storeys(path)
    assert [storey.name for storey in (ground, upper)] == ["Ground", "Upper"]
    assert [[room.name for room in storey.floor.rooms] for storey in (ground, upper)] == [
        ["Office", "Lab"],
        ["Lab above"],
    ]
    assert [door.rooms for door in ground.floor.doors] == [(1, 2)]
    assert ground.scale == PlanScale(CELL, "the units of the file", 1.0)


def test_the_frame_holds_the_rooms_and_a_margin(path):
    """The ground floor is 9 m × 6 m, the lab above 3.8 m × 3 m from (5.2, 0)."""
    ground, upper = (storey.grid for storey in read_storeys(path))
    assert ground.shape == (round((6 + 2 * MARGIN) / CELL), round((9 + 2 * MARGIN) / CELL))
    assert ground.origin == pytest.approx((-MARGIN, -MARGIN, 0))
    assert upper.origin == pytest.approx((5.2 - MARGIN, -MARGIN, 0))
    assert upper.shape == (round((3 + 2 * MARGIN) / CELL), round((3.8 + 2 * MARGIN) / CELL))
    assert (ground.cells == UNKNOWN).all()


def test_the_frame_of_a_wide_storey_has_larger_cells(tmp_path):
    model = Model()
    ground = model.storey()
    model.space(ground, LAB, Name="Near")
    model.space(ground, LAB, Name="Far", at=(2_000_000, 500_000))
    model.file.write(str(tmp_path / "campus.ifc"))
    (storey,) = read_storeys(tmp_path / "campus.ifc")
    floor, frame, scale = storey.floor, storey.grid, storey.scale
    assert len(floor.rooms) == 2
    assert max(frame.shape) <= MAX_SIDE_CELLS + 1
    assert frame.resolution == scale.resolution > CELL
    left, bottom, right, top = np.array([room.polygon.bounds for room in floor.rooms]).T
    rows, cols = frame.map_to_pixel([left.min(), right.max()], [bottom.min(), top.max()])
    assert min(rows.min(), cols.min()) > 0
    assert (rows.max(), cols.max()) < frame.shape


def test_read_plan_gives_the_storeys_without_a_sheet(path):
    reading = read_plan(path)
    assert reading.sheet is None
    assert [floor.name for floor in reading.floors] == ["Ground", "Upper"]
    assert [floor.grid.resolution for floor in reading.floors] == [floor.scale.resolution for floor in reading.floors]
    assert reading.floors[0].floor.rooms[1].polygon.bounds == pytest.approx((5.2, 0, 9, 3))


@pytest.mark.parametrize("content", [b"", b"ISO-10303-21;\nHEADER;", b"\x00\xff" * 90])
def test_damaged_ifc_files_are_refused_in_one_line(tmp_path, content):
    (tmp_path / "plan.ifc").write_bytes(content)
    with pytest.raises(PlanError) as refused:
        read_plan(tmp_path / "plan.ifc")
    assert "\n" not in str(refused.value)
    assert "plan.ifc" in str(refused.value)
