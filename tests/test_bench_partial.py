"""`pianta bench partial` on a tiny building whose prediction is known."""

import json

import cv2
import numpy as np
import pytest
from shapely import STRtree, box

from pianta.errors import DataError, MapError
from pianta.floor import Floor, Room
from pianta.gridmap import FREE, UNKNOWN, GridMap
from pianta.worlds.floors import make_corridor_floor
from pianta_bench.partial import measure as bench
from pianta_bench.partial.guesses import (
    FACES,
    GUESSES,
    PREDICTED,
    RECTANGLE,
    SEEN_PART,
    Guesser,
    complete_by_faces,
    draw_rectangle,
)
from pianta_bench.partial.maps import PartialMap, list_real_maps, simulate_drawing, simulate_world
from pianta_bench.partial.measure import (
    EvaluatedRoom,
    evaluate_rooms,
    measure,
    measure_iou,
    measure_unseen,
)
from tests.command_line import run_pianta

LAYOUT = """<building><building_type><main_type>SCHOOL</main_type></building_type>
<scale><represented_distance><value>9</value><um>pixel</um></represented_distance>
<real_distance><value>90</value><um>cm</um></real_distance></scale>
<floor><spaces><space id="a"><labels><label>CLASSROOM</label></labels>
<bounding_polygon><point x="10" y="10"/><point x="50" y="10"/>
<point x="50" y="40"/><point x="10" y="40"/></bounding_polygon>
</space></spaces></floor></building>"""
# The affine map moves the layout by 5 columns and 20 rows.
STEP = {"file": "a_001.png", "run": "a", "step": 1, "affine": [[1, 0, 5], [0, 1, 20]]}
TRUE, VISIBLE = box(1.5, 4.0, 5.5, 7.0), box(1.5, 4.0, 3.5, 7.0)


def write_data(folder, *steps: dict[str, object]) -> None:
    """A map of 100 x 100 cells of 0.1 m that shows the left half of the only room."""
    building = folder / "partial" / "here"
    building.mkdir(parents=True)
    image = np.full((100, 100), 205, np.uint8)
    image[30:60, 15:35] = 254
    cv2.imwrite(str(building / "a_001.png"), image)
    (building / "steps.json").write_text(json.dumps(steps))
    (folder / "buildings" / "school").mkdir(parents=True)
    (folder / "buildings" / "school" / "here.xml").write_text(LAYOUT)


def reconstruct_floor(*_: object, **__: object) -> Floor:
    return Floor((Room(1, VISIBLE, partial=True, predicted=TRUE, confidence=0.75),))


@pytest.fixture
def tiny(tmp_path, monkeypatch):
    write_data(tmp_path / "data", STEP)
    monkeypatch.setattr(bench, "reconstruct", reconstruct_floor)
    monkeypatch.setattr(bench, "SIMULATED_COUNT", 0)
    return tmp_path / "data"


def test_the_layout_is_moved_by_the_affine_map(tiny):
    (partial_map,) = list_real_maps(tiny)
    assert partial_map.read().rooms[0].equals(TRUE)


def test_a_room_is_compared_with_the_true_one(tiny):
    (room,) = measure(tiny, simulated=0).objects["rooms"]["here a"]
    # Half a wall is 0.08 m: the 2 m x 3 m that were seen become 2.16 m x 3.16 m, of which 2.08 m x 3 m are in the true
    # 4 m x 3 m.
    grown = 6.24 / (12 + 6.8256 - 6.24)
    assert (room.ious[SEEN_PART], room.ious[RECTANGLE], room.confidence) == pytest.approx((grown, grown, 0.75))
    assert room.ious[PREDICTED] == pytest.approx(12 / (12 + 6.8256 - 6.24))
    assert (room.seen_share, room.unseen_share) == pytest.approx((0.5, 0.5))
    assert room.truly_partial


def test_the_rectangle_goes_along_the_walls():
    room = Room(1, box(0, 0, 4, 1).union(box(0, 0, 1, 3)))
    assert draw_rectangle(room, 0.0).equals(box(0, 0, 4, 3))
    assert draw_rectangle(room, np.pi / 4).area > 12


def test_no_guess_covers_another_room():
    floor = Floor((Room(1, box(0, 0, 4, 1).union(box(0, 0, 1, 3)), partial=True), Room(2, box(2, 1.1, 4, 3))))
    guesses = Guesser.make(floor, GridMap(np.full((100, 100), UNKNOWN, np.int8), 0.1)).guess(floor.rooms[0])
    assert {name: guess.intersection(floor.rooms[1].polygon).area for name, guess in guesses.items()} == pytest.approx(
        dict.fromkeys((SEEN_PART, RECTANGLE, FACES, PREDICTED), 0)
    )
    assert guesses[RECTANGLE].area > guesses[SEEN_PART].area


def test_a_face_belongs_to_a_room_that_has_enough_of_it():
    faces = STRtree([box(0, 0, 6, 3), box(6, 0, 9, 3), box(0, 3, 4, 13)])
    room = Room(1, box(0, 0, 4, 4), partial=True)
    assert complete_by_faces(room, faces, inside_share=0.5).equals(box(0, 0, 6, 3).union(box(0, 3, 4, 4)))
    assert complete_by_faces(room, faces, inside_share=0.1).equals(box(0, 0, 6, 3).union(box(0, 3, 4, 13)))


def test_a_whole_room_is_evaluated_where_part_of_it_was_not_seen():
    cells = np.full((100, 100), UNKNOWN, np.int8)
    cells[30:60, 15:35] = FREE
    partial_map = PartialMap("here", GridMap(cells, 0.1), [TRUE])
    (room,) = evaluate_rooms(Floor((Room(1, VISIBLE),)), partial_map)
    assert (room.called_partial, room.ious[PREDICTED], room.confidence) == (False, room.ious[SEEN_PART], None)


def test_a_wall_is_no_unseen_space():
    cells = np.full((100, 100), UNKNOWN, np.int8)
    cells[33:57, 18:52] = FREE
    assert measure_unseen(TRUE, GridMap(cells, 0.1)) == 0
    assert measure_unseen(box(20, 20, 22, 22), GridMap(cells, 0.1)) == 1


def test_iou_is_what_is_common_of_all():
    assert measure_iou(box(0, 0, 2, 1), box(1, 0, 3, 1)) == pytest.approx(1 / 3)


def test_bench_prints_and_saves_what_it_measures(tiny, tmp_path, monkeypatch):
    monkeypatch.setattr(
        bench, "simulate_world", lambda _: PartialMap("world", GridMap(np.full((9, 9), -1), 1.0), [TRUE])
    )
    code, out, err = run_pianta("bench", "partial", "--data", tiny, "--json", tmp_path / "figures.json")
    assert (code, err) == (0, "")
    row = next(line.split() for line in out.splitlines() if line.startswith("here a (1)"))
    # The thesis draws no lines along sides of 2 m, so a face is 5 m long: 6 of 10 m² are in the room.
    assert row == ["here", "a", "(1)", "49.6", "49.6", "37.3", "95.3", "45.8"]
    records = json.loads((tmp_path / "figures.json").read_text())["records"]
    (confidence,) = [record for record in records if record["metric"] == "confidence" and record["part"] == "here a"]
    assert (confidence["item"], confidence["value"]) == ("here/a_001 room 1", 75)


def test_a_map_that_fails_is_named_and_does_not_count(tiny, monkeypatch):
    def fail(*_: object, **__: object) -> Floor:
        raise MapError("it shows nothing")

    monkeypatch.setattr(bench, "reconstruct", fail)
    results = measure(tiny, simulated=0)
    assert not results.objects["rooms"]["here a"]
    assert [(item.part, item.failure) for item in results.items] == [("here a", "it shows nothing")]


def test_data_without_partial_maps_are_refused(tmp_path):
    with pytest.raises(DataError, match=r"\bpartial\b"):
        list_real_maps(tmp_path)


@pytest.mark.parametrize("step", [{"file": "a.png"}, STEP | {"affine": [[1, 2], [3, 4]]}, STEP | {"affine": None}])
def test_a_faulty_list_of_steps_is_refused(tmp_path, step):
    write_data(tmp_path, step)
    with pytest.raises(DataError, match=r"\blist\b"):
        list_real_maps(tmp_path)


@pytest.mark.slow
def test_simulated_maps_show_part_of_their_rooms_and_are_repeated():
    one, same, from_drawing = (
        simulate_world(8),
        simulate_world(8),
        simulate_drawing(make_corridor_floor(seed=2), seed=2),
    )
    assert (one.grid.cells == same.grid.cells).all()
    for each in (one, from_drawing):
        assert each.grid.unknown.any()
        assert each.grid.free.any()
        assert 0 < np.mean([measure_unseen(room, each.grid) for room in each.rooms]) < 1


def test_a_room_is_truly_partial_from_a_tenth_on():
    room = EvaluatedRoom("", 1, True, 0.9, 0.05, dict.fromkeys(GUESSES, 0.9), None)
    assert not room.truly_partial
