"""IFC files without spaces: rooms are what walls, doors, windows and slabs enclose on each storey."""

from typing import Any

import pytest
import shapely

from pianta.errors import PlanError, PlanWarning
from pianta.io.drawings import _ifc_walls
from pianta.io.drawings._ifc_model import Shape
from pianta.io.drawings.ifc import IfcStorey, read_ifc_plan
from tests.conftest import DATA
from tests.ifc_models import Corners, Model

ifcopenshell = pytest.importorskip("ifcopenshell", reason="pianta[bim] is not installed")

pytestmark = pytest.mark.filterwarnings("ignore::pianta.errors.PlanWarning")

# Millimetres: outer walls of 300 around 8000 x 5000, a wall of 200 from 5000 on, and the slab below all of it.
OUTER = {
    "south": [(-300, -300), (8300, -300), (8300, 0), (-300, 0)],
    "east": [(8000, 0), (8300, 0), (8300, 5000), (8000, 5000)],
    "north": [(-300, 5000), (8300, 5000), (8300, 5300), (-300, 5300)],
    "west": [(-300, 0), (0, 0), (0, 5000), (-300, 5000)],
}
INNER = [(5000, 0), (5200, 0), (5200, 5000), (5000, 5000)]
SLAB = [(-300, -300), (8300, -300), (8300, 5300), (-300, 5300)]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "plan.ifc"


def build(model: Model, *, low: float = 0.0, name: str = "Ground", slab: Corners = SLAB) -> tuple[Any, dict[str, Any]]:
    """A storey with two rooms; its walls by their names."""
    storey = model.storey(name, low)
    walls = {side: model.element("IfcWall", storey, corners, low=low) for side, corners in OUTER.items()}
    walls["inner"] = model.element("IfcWall", storey, INNER, low=low)
    if slab:
        model.element("IfcSlab", storey, slab, low=low - 200, height=200.0)
    return storey, walls


def add_door(model: Model, storey: object, wall: object) -> Any:
    """A door of 900 in the inner wall."""
    opening = model.opening(wall, [(5000, 1000), (5200, 1000), (5200, 1900), (5000, 1900)])
    door = model.door(storey, (5100, 1000))
    model.fill(opening, door)
    return door


def areas(storey: IfcStorey) -> list[float]:
    return [room.polygon.area for room in storey.floor]


def test_walls_enclose_rooms_that_a_door_joins(path):
    """5000 x 5000 and 2800 x 5000, as measured between the walls; the door is shut for it."""
    model = Model()
    storey, walls = build(model)
    door = add_door(model, storey, walls["inner"])
    with pytest.warns(PlanWarning, match="no spaces.*made from its walls"):
        (read,) = model.read(path)
    assert areas(read) == pytest.approx([25, 14], rel=1e-3)
    assert [(each.rooms, each.kind, each.global_id) for each in read.floor.doors] == [((1, 2), "door", door.GlobalId)]
    assert (read.name, read.elevation, read.floor.global_id) == ("Ground", 0, storey.GlobalId)


@pytest.mark.parametrize(("width", "rooms"), [(1500, 2), (3000, 1)])
def test_a_narrow_opening_divides_rooms_and_a_wide_one_does_not(width, rooms, path):
    model = Model()
    _, walls = build(model)
    model.opening(walls["inner"], [(5000, 1000), (5200, 1000), (5200, 1000 + width), (5000, 1000 + width)])
    (read,) = model.read(path)
    assert len(read.floor) == rooms
    assert [door.kind for door in read.floor.doors] == ["opening"] * (rooms - 1)


def test_windows_and_gaps_between_walls_are_shut(path):
    """A window from the floor of 3000 x 2500 in the south, and walls that end 50 before the next one."""
    model = Model()
    storey, walls = build(model)
    opening = model.opening(walls["south"], [(1000, -300), (4000, -300), (4000, 0), (1000, 0)], height=2500.0)
    window = model.element("IfcWindow", storey, [(1000, -200), (4000, -200), (4000, -150), (1000, -150)], height=2500.0)
    model.fill(opening, window)
    model.shape(walls["inner"], [(5000, 50), (5200, 50), (5200, 4950), (5000, 4950)])
    (read,) = model.read(path)
    assert areas(read) == pytest.approx([25, 14], rel=5e-3)


def test_each_storey_has_the_rooms_at_its_height(path):
    """The walls of the staircase go through both storeys, and are contained in the lower one."""
    model = Model()
    build(model)
    build(model, low=3000.0, name="First", slab=SLAB)
    assert [(read.name, len(read.floor)) for read in model.read(path)] == [("Ground", 2), ("First", 2)]


def test_heights_that_are_no_storeys_have_no_rooms(path):
    """Reference heights near a storey, and one without walls."""
    model = Model()
    build(model)
    low = model.storey("Slab", -400.0)
    model.element("IfcWall", low, [(-300, -300), (-100, -300), (-100, 0), (-300, 0)], low=-400.0)
    model.storey("Eaves", 6000.0)
    assert [read.name for read in model.read(path)] == ["Ground"]


def test_shafts_cavities_and_voids_without_a_floor_are_no_rooms(path):
    """A shaft of 0.8 m², a cavity of 300 x 5000, and a void: the slab ends at the inner wall."""
    model = Model()
    storey, _ = build(model, slab=[(-300, -300), (5200, -300), (5200, 5300), (-300, 5300)])
    for corners in (
        [(1000, 4000), (2000, 4000), (2000, 4100), (1000, 4100)],
        [(1000, 4100), (1100, 4100), (1100, 5000), (1000, 5000)],
        [(1900, 4100), (2000, 4100), (2000, 5000), (1900, 5000)],
        [(300, 0), (400, 0), (400, 5000), (300, 5000)],
    ):
        model.element("IfcWall", storey, corners)
    (read,) = model.read(path)
    # 4600 x 5000 without the shaft, its walls and what remains of the cavity
    assert areas(read) == pytest.approx([4.6 * 5 - 1.0], rel=1e-2)


def test_a_model_without_walls_is_refused(path):
    model = Model()
    storey = model.storey()
    model.element("IfcWall", storey, OUTER["south"])
    with pytest.raises(PlanError, match=r"no spaces .IfcSpace., and no walls that enclose rooms") as caught:
        model.read(path)
    assert "\n" not in str(caught.value)


def test_more_walls_than_the_limit_are_refused(path, monkeypatch):
    monkeypatch.setattr(_ifc_walls, "MAX_BARRIERS", 3)
    model = Model()
    build(model)
    with pytest.raises(PlanError, match="6 walls and slabs, give at most 3"):
        model.read(path)


def test_a_cut_is_the_area_at_its_height():
    """A pyramid of 4 x 4 and 2 high is 2 x 2 at half of its height; an open surface becomes thin."""
    import numpy as np

    corners = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [2, 2, 2]], float)
    faces = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [0, 2, 1], [0, 3, 2]])
    assert Shape(corners, faces).cut(1.0).equals(shapely.box(1, 1, 3, 3))
    assert Shape(corners, faces).cut(3.0).is_empty
    assert Shape(corners, faces).project().area == pytest.approx(16)
    surface = Shape(corners, faces[:1]).cut(1.0)
    assert surface.area == pytest.approx(2 * 0.02, rel=0.05)


@pytest.mark.slow
def test_a_real_house_without_spaces_has_the_rooms_that_people_count():
    """Counted by eye on pictures of the walls at 1 m: 3 in the cellar, 7, 5, and 2 under the roof."""
    file = DATA / "planfiles" / "ifc" / "bbri_house_ifc4.ifc"
    if not file.is_file():
        pytest.skip(f"{file} is missing")
    storeys = read_ifc_plan(file)
    assert [len(storey.floor) for storey in storeys] == [3, 7, 5, 2]
    assert [round(storey.elevation, 2) for storey in storeys] == [-2.94, 0, 3.1, 6]
