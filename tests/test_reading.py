"""`pianta.read` and `pianta.read_all`: the command from Python."""

import inspect
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import pianta
from pianta.corrections.corrections_file import save_corrections
from pianta.corrections.kinds import LabelRoom
from pianta.errors import FloorError, MapError, MapWarning, ModelError, OptionError
from pianta.reading._reader import ReadOptions
from pianta.reading.reading import OUTPUTS, Reading, StoreyReading
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.plans.drawing import draw_plan
from pianta.worlds.scan import simulate_map
from tests.command_line import list_files, run_pianta
from tests.generated_types import small_model
from tests.hidden_figures import hiding_figures


def write_map(path: Path, *, length: float = 10.0) -> Path:
    """The map of a corridor with rooms of 5 m on both sides."""
    simulate_map(make_corridor_floor(length=length, room_width=(5, 5))).save(path)
    return path


def write_suspicious_map(path: Path) -> Path:
    """A map whose unknown grey 205 would be free."""
    write_map(path)
    path.write_text(path.read_text().replace("free_thresh: 0.196", "free_thresh: 0.25"))
    assert "free_thresh: 0.25" in path.read_text()
    return path


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_map(tmp_path_factory.mktemp("small") / "small.yaml")


@pytest.fixture(scope="module")
def reading(small: Path) -> Reading:
    return pianta.read(small)


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("plan") / "plan.png"
    floor = make_corridor_floor(length=10, room_width=(5, 5))
    Image.fromarray(draw_plan(floor, style="thick", px_per_metre=30, doors="arc", seed=1).colors).save(file)
    return file


@pytest.fixture
def _hidden():
    with hiding_figures():
        yield


class TestRead:
    def test_reconstructs_the_drawn_floor(self, small, reading):
        assert reading.path == small
        assert len(reading.floor) == 5
        assert reading.floor.source == "small.yaml"
        assert [room.id for room in reading.floor if room.labels["R/C"] == "CORRIDOR"] == [3]
        assert reading.floors == (reading.floor,)
        assert (reading.grid.cells == pianta.read_map(small).cells).all()
        assert (reading.scale, reading.messages, reading.folder) == (None, (), None)

    @pytest.mark.parametrize(
        ("flags", "options"),
        [
            ([], {}),
            (["--type", "school"], {"building_type": "school"}),
            (["--no-labels", "--method", "voronoi"], {"labels": False, "method": "voronoi"}),
            (["--no-predictions"], {"predict_partial": False}),
            (["--method", "thesis", "--as-printed"], {"method": "thesis", "as_printed": True}),
        ],
        ids=["plain", "type", "method", "predictions", "as printed"],
    )
    def test_gives_the_files_of_the_command(self, small, tmp_path, flags, options):
        assert run_pianta("read", small, "-o", tmp_path / "command", *flags, "-q") == (0, "", "")
        assert pianta.read(small, **options).save(tmp_path / "library") == [tmp_path / "library"]
        files = list_files(tmp_path / "library")
        assert files.keys() == {*OUTPUTS}
        assert files == list_files(tmp_path / "command")

    def test_draws_walls_and_graph_as_the_command_does(self, small, reading, tmp_path):
        run_pianta("read", small, "-o", tmp_path / "command", "--walls", "--graph", "-q")
        reading.save(tmp_path / "library", walls=True, graph=True)
        assert list_files(tmp_path / "library") == list_files(tmp_path / "command")

    def test_keeps_ids_as_the_command_does(self, small, reading, tmp_path):
        """The older floor may be a floor, its file, or the folder of the file."""
        new_ids = {room.id: room.id + 10 for room in reading.floor}
        rooms = [replace(room, id=new_ids[room.id]) for room in reading.floor]
        doors = [door.renumber_rooms(new_ids) for door in reading.floor.doors]
        older = pianta.Floor(tuple(rooms), tuple(doors), building_type={"school": 1})
        older.save(tmp_path / "floor.geojson")
        run_pianta("read", small, "-o", tmp_path / "command", "--previous", tmp_path, "-q")
        for previous in (older, tmp_path, str(tmp_path / "floor.geojson")):
            with_previous = pianta.read(small, previous=previous)
            assert [room.id for room in with_previous.floor] == [11, 12, 13, 14, 15]
            assert with_previous.floor.given_type == "school"
            assert with_previous.messages == ("5 rooms kept their ids, 0 are new, 0 are gone",)
            with_previous.save(tmp_path / "library")
            assert list_files(tmp_path / "library") == list_files(tmp_path / "command")

    def test_takes_ids_back_from_earlier_floors_as_the_command_does(self, small, reading, tmp_path):
        """The previous floor lacks the first room, which was number 1 two floors ago."""
        first, before = reading.floor.rooms[0], tmp_path / "before"
        before.mkdir()
        reading.floor.save(before / "floor.geojson")
        doors = tuple(door for door in reading.floor.doors if first.id not in door.rooms)
        replace(reading.floor, rooms=reading.floor.rooms[1:], doors=doors).save(tmp_path / "floor.geojson")
        code, out, err = run_pianta(
            "read", small, "-o", tmp_path / "command", "--previous", tmp_path, "--earlier", before
        )
        assert (code, err) == (0, "")
        line = "4 rooms kept their ids, 1 has its id back, 0 are new, 0 are gone"
        assert line in out.splitlines()
        with_earlier = pianta.read(small, previous=tmp_path, earlier=[reading.floor])
        assert [room.id for room in with_earlier.floor] == [room.id for room in reading.floor]
        assert with_earlier.messages == (line,)
        with_earlier.save(tmp_path / "library")
        assert list_files(tmp_path / "library") == list_files(tmp_path / "command")

    def test_accepts_models_as_objects_and_as_files(self, small, reading):
        models = Path(pianta.__file__).parent / "models"
        (rooms,) = [file for file in models.glob("rooms.*") if file.suffix != ".md"]
        types = models / "building_types.json"
        by_file = pianta.read(small, room_model=rooms, building_model=str(types))
        options: Any = {"room_model": pianta.load_model(rooms), "building_model": pianta.load_model(types)}
        loaded = pianta.read(small, **options)
        assert by_file.floor == loaded.floor == reading.floor

    @pytest.mark.parametrize(
        ("options", "error", "expected"),
        [
            ({"input_kind": "photo"}, OptionError, "input_kind is 'photo', give one of map, plan, or None"),
            ({"input_kind": "map", "page": 3}, OptionError, "leave out page= or give input_kind='plan'"),
            ({"symbols": "symbols"}, OptionError, "leave out symbols= or give input_kind='plan'"),
            ({"method": "magic"}, OptionError, "method is 'magic', give one of structure, thesis"),
            ({"parameters": pianta.ThesisParameters()}, OptionError, "give StructureParameters"),
            ({"labels": False, "building_type": "school"}, OptionError, "labels=False makes building_type= useless"),
            ({"building_type": "school", "building_model": "m.json"}, OptionError, "makes building_model= useless"),
            ({"building_type": "castle"}, OptionError, "knows no building type 'castle'"),
            ({"room_model": small_model()}, OptionError, "room_model= is a TypeModel, give a RoomModel"),
            (
                {"building_model": small_model()},
                OptionError,
                "building_model= is a TypeModel, give a BuildingTypeModel",
            ),
            ({"room_model": "nowhere.model"}, ModelError, "'nowhere.model' does not exist"),
            ({"previous": "nowhere"}, FloorError, "'nowhere' does not exist"),
            ({"earlier": ["older"]}, OptionError, "earlier= is given without previous=, give the newest"),
            ({"earlier": "older", "previous": "old"}, OptionError, "earlier is 'older', give a list of floors"),
            ({"max_cells": 100}, MapError, "the limit is 100; lift it with max_cells="),
        ],
        ids=lambda value: "-".join(value) if isinstance(value, dict) else "",
    )
    def test_refuses_options_without_meaning(self, small, options, error, expected):
        with pytest.raises(error) as caught:
            pianta.read(small, **options)
        assert expected in str(caught.value)
        assert "\n" not in str(caught.value)

    def test_warns(self, tmp_path):
        path = write_suspicious_map(tmp_path / "map.yaml")
        with pytest.warns(MapWarning, match="grey 205"):
            pianta.read(path, labels=False)

    def test_parameters_are_not_for_plans(self, plan):
        with pytest.raises(OptionError, match="is no map, leave out parameters= or give input_kind='map'"):
            pianta.read(plan, parameters=pianta.StructureParameters())

    def test_reads_a_plan(self, plan, monkeypatch):
        monkeypatch.setattr("pianta.plan.read_plan.read_texts", lambda _: ())  # there is no text to be read
        plan_reading = pianta.read(plan, resolution=1 / 30, labels=False)
        assert len(plan_reading.floor) == 5
        assert plan_reading.scale is not None
        assert plan_reading.scale.resolution == pytest.approx(1 / 30)
        paper = plan_reading.storeys[0].paper
        assert paper is not None
        assert paper.shape[:2] == plan_reading.grid.shape
        assert plan_reading._repr_png_().startswith(b"\x89PNG")

    def test_its_options_are_those_of_read_all(self):
        _, *options = inspect.signature(pianta.read).parameters.values()
        assert [option.name for option in options if option.kind is option.KEYWORD_ONLY] == [
            option.name for option in options
        ]
        assert {option.name for option in options} == ReadOptions.__annotations__.keys()


def repeat_storey(reading: Reading, count: int) -> Reading:
    """A reading with the floor of another one on each of its storeys."""
    first = reading.storeys[0]
    names = [f"floor-{number}" for number in range(1, count + 1)]
    return replace(reading, storeys=tuple(StoreyReading(first.floor, first.grid, name=name) for name in names))


class TestReading:
    @pytest.mark.usefixtures("_hidden")
    def test_is_drawn_on_its_map(self, reading):
        ax = reading.plot(graph=True)
        assert len(ax.images) == 1
        assert reading.plot(ax=ax) is ax

    def test_is_shown_by_a_notebook_as_in_its_picture(self, reading, tmp_path):
        reading.save(tmp_path)
        assert reading._repr_png_() == (tmp_path / "picture.png").read_bytes()

    def test_storeys_are_written_into_a_folder_each(self, reading, tmp_path):
        first = reading.storeys[0]
        two = repeat_storey(reading, 2)
        assert two.floors == (first.floor, first.floor)
        assert two.save(tmp_path) == [tmp_path / "floor-1", tmp_path / "floor-2"]
        assert {path.parent.name for path in tmp_path.rglob("*.png")} == {"floor-1", "floor-2"}
        assert (tmp_path / "building.json").is_file()

    def test_storeys_and_a_single_floor_replace_each_other(self, reading, tmp_path):
        (tmp_path / "floor-9").mkdir()
        (tmp_path / "floor-9" / "notes.txt").write_text("a user's own")
        reading.save(tmp_path)
        for count in (3, 2):
            repeat_storey(reading, count).save(tmp_path)
        assert {path.name for path in tmp_path.iterdir()} == {"building.json", "floor-1", "floor-2", "floor-9"}
        reading.save(tmp_path)
        assert {path.name for path in tmp_path.iterdir()} == {*OUTPUTS, "floor-9"}

    def test_corrections_of_a_storey_that_goes_are_kept(self, reading, tmp_path):
        repeat_storey(reading, 2).save(tmp_path)
        corrections = [LabelRoom((1.0, 1.0), "KITCHEN")]
        save_corrections(corrections, tmp_path / "floor-2" / "corrections.json")
        with pytest.raises(OptionError, match="floor-2' has 1 correction, which would be lost"):
            reading.save(tmp_path)
        assert (tmp_path / "building.json").is_file()

    def test_files_of_a_user_beside_storeys_stay(self, reading, tmp_path):
        (tmp_path / "picture.png").write_text("a user's own")
        repeat_storey(reading, 2).save(tmp_path)
        assert (tmp_path / "picture.png").read_text(encoding="utf-8") == "a user's own"

    def test_does_not_replace_its_input(self, reading, tmp_path):
        from_picture = replace(reading, path=tmp_path / "rooms.png")
        with pytest.raises(OptionError, match="would be replaced by a result"):
            from_picture.save(tmp_path)
        assert list(tmp_path.iterdir()) == []


class TestReadAll:
    def test_gives_readings_and_failures_in_order(self, small, tmp_path):
        counts: list[tuple[int, int]] = []
        paths = ["nowhere.yaml", small, str(tmp_path)]
        first, second, third = pianta.read_all(paths, labels=False, progress=lambda *count: counts.append(count))
        assert isinstance(first, pianta.Failure)
        assert isinstance(second, Reading)
        assert isinstance(third, pianta.Failure)
        assert (first.path, str(first.error)) == (
            Path("nowhere.yaml"),
            "map 'nowhere.yaml' does not exist, check the path",
        )
        assert second.floor == pianta.read(small, labels=False).floor
        assert second.folder is None
        assert third.path == tmp_path
        assert counts == [(0, 3), (1, 3), (2, 3), (3, 3)]

    def test_reads_on_demand(self, small):
        counts: list[tuple[int, int]] = []
        results = pianta.read_all([small, "nowhere.yaml"], labels=False, progress=lambda *count: counts.append(count))
        assert counts == []
        next(results)
        assert counts == [(0, 2), (1, 2)]

    def test_no_files_are_no_error(self):
        assert list(pianta.read_all([])) == []

    def test_processes_change_nothing(self, small, tmp_path):
        """The same files, in the same order, and the same warnings, which point to the call of read_all."""
        other = write_suspicious_map(tmp_path / "other.yaml")
        paths = [small, "nowhere.yaml", other]
        outcomes = []
        for jobs in (1, 2):
            out = tmp_path / str(jobs)
            counts: list[tuple[int, int]] = []
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                results = list(
                    pianta.read_all(
                        paths,
                        out=out,
                        jobs=jobs,
                        labels=False,
                        progress=lambda *count, counts=counts: counts.append(count),
                    )
                )
            assert counts == [(0, 3), (1, 3), (2, 3), (3, 3)]
            kinds = [type(result) for result in results]
            floors = [result.floor for result in results if isinstance(result, Reading)]
            folders = [result.folder for result in results if isinstance(result, Reading)]
            assert folders == [out / "small", out / "other"]
            assert [warning.category for warning in caught] == [MapWarning]
            outcomes.append((kinds, floors, [str(warning.message) for warning in caught], list_files(out)))
        assert caught[0].filename == __file__
        assert outcomes[0] == outcomes[1]
        assert len(outcomes[0][3]) == 2 * len(OUTPUTS)

    def test_gives_the_files_of_the_command(self, small, tmp_path):
        other = write_map(tmp_path / "other.yaml", length=15)
        run_pianta("read", small, other, "-o", tmp_path / "command", "--no-labels", "--graph", "-q")
        results = list(pianta.read_all([small, other], out=tmp_path / "library", labels=False, graph=True))
        assert [len(result.floor) for result in results if isinstance(result, Reading)] == [5, 7]
        (tmp_path / "command" / "journal.sqlite").unlink()
        assert list_files(tmp_path / "library") == list_files(tmp_path / "command")

    @pytest.mark.parametrize(
        ("paths", "options", "expected"),
        [
            (["a.yaml", "b.yaml"], {"previous": "floor.geojson"}, "previous= is one floor and 2 files are given"),
            (["a.yaml"], {"jobs": 0}, "jobs is 0, give 1 to 256"),
            (["a.yaml"], {"method": "magic"}, "method is 'magic'"),
            ("a.yaml", {}, "paths is 'a.yaml', give a list of files, or use read for one"),
            (Path("a.yaml"), {}, "paths is 'a.yaml', give a list of files"),
        ],
    )
    def test_refuses_arguments_without_meaning_at_once(self, paths, options, expected):
        with pytest.raises(OptionError) as caught:
            pianta.read_all(paths, **options)
        assert expected in str(caught.value)

    def test_refuses_unknown_options(self):
        with pytest.raises(TypeError, match="there is no option colour="):
            pianta.read_all([], colour="red")  # type: ignore[call-arg]

    def test_refuses_a_folder_that_is_a_file(self, small):
        with pytest.raises(pianta.PiantaError, match="is a file, give another folder"):
            pianta.read_all([small], out=small)

    def test_a_result_that_would_replace_its_map_is_a_failure(self, tmp_path):
        picture = tmp_path / "rooms" / "rooms.png"
        picture.parent.mkdir()
        Image.fromarray(np.full((20, 30), 254, np.uint8)).save(picture)
        (failure,) = pianta.read_all([picture], out=tmp_path, input_kind="map", resolution=0.05)
        assert isinstance(failure, pianta.Failure)
        assert "would be replaced by a result" in str(failure.error)
