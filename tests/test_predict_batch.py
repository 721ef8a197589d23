"""Predictions of many floors: a folder each, a journal of what is done, and no floor that stops the others."""

import json
from pathlib import Path

import pytest

import pianta
from pianta.batch.predict_batch import list_floors
from pianta.errors import OptionError
from pianta.generation.type_model import TypeModel, learn_type
from pianta.generation.type_model_file import save_type_model
from pianta.io.floors import save_floor
from tests.command_line import list_files, run_pianta
from tests.generated_types import SCHOOL, join_wings, make_schools
from tests.test_cli_generate import draw_floor
from tests.test_cli_predict import write_floor


@pytest.fixture(scope="module")
def model():
    return learn_type(make_schools()[:5], SCHOOL)


@pytest.fixture
def floors(tmp_path):
    """Two explored floors in folders as `pianta read` writes them, and a damaged one."""
    folder = tmp_path / "floors"
    for number, name in enumerate(("a", "b"), start=1):
        (folder / name).mkdir(parents=True)
        graph = join_wings(("CCCCS", "CT"[:number]), ((0, 1),), source=name)
        floor = draw_floor(graph)
        rooms = tuple(
            pianta.Room(room.id, room.polygon, label=room.label, partial=room.id == 7) for room in floor.rooms
        )
        save_floor(pianta.Floor(rooms, floor.doors, building_type={"school": 1.0}), folder / name / "floor.geojson")
    (folder / "broken").mkdir()
    (folder / "broken" / "floor.geojson").write_text("{")
    return folder


def predict(floors: Path, model: TypeModel, out: Path, **options) -> dict[str, pianta.BatchItem]:
    items = pianta.predict_batch([floors], model, out=out, count=4, **options)
    return {item.path.parent.name: item for item in items}


class TestListFloors:
    def test_folders_stand_for_the_floors_in_them(self, floors):
        assert [path.parent.name for path in list_floors([floors])] == ["a", "b", "broken"]
        assert list_floors([floors / "a"]) == [floors / "a" / "floor.geojson"]
        assert list_floors([f"{floors}/[ab]", floors / "a" / "floor.geojson"]) == [
            floors / "a" / "floor.geojson",
            floors / "b" / "floor.geojson",
        ]

    def test_a_folder_without_floors_and_a_pattern_without_match_are_refused(self, tmp_path):
        (tmp_path / "empty").mkdir()
        with pytest.raises(OptionError, match=r"has no floor\.geojson"):
            list_floors([tmp_path / "empty"])
        with pytest.raises(OptionError, match="nothing matches"):
            list_floors([f"{tmp_path}/*.xml"])


class TestPredictBatch:
    def test_each_floor_has_its_prediction_and_a_damaged_one_stops_nothing(self, floors, model, tmp_path):
        items = predict(floors, model, tmp_path / "out")
        assert {name: item.folder.name for name, item in items.items()} == {"a": "a", "b": "b", "broken": "broken"}
        assert {name: item.group for name, item in items.items() if item.fault} == {"broken": "floor"}
        content = json.loads((tmp_path / "out" / "a" / "prediction.json").read_text())
        assert items["a"].description == {
            "known": len(content["known"]),
            "open_ends": len(content["open_ends"]),
            "rooms": content["rooms"],
            "area": content["area"],
        }
        alone = pianta.predict(pianta.read_floor(floors / "a" / "floor.geojson"), model, count=4)
        assert content["rooms"]["mean"] == pytest.approx(alone.rooms.mean, abs=1e-4)

    def test_what_is_done_is_not_done_again(self, floors, model, tmp_path):
        out = tmp_path / "out"
        predict(floors, model, out)
        again = predict(floors, model, out)
        assert {name: item.is_new for name, item in again.items()} == {"a": False, "b": False, "broken": True}
        save_floor(pianta.read_floor(floors / "b" / "floor.geojson"), floors / "a" / "floor.geojson")
        changed = predict(floors, model, out)
        assert {name for name, item in changed.items() if item.is_new} == {"a", "broken"}
        assert {name for name, item in predict(floors, model, out, seed=1).items() if item.is_new} == {*changed}

    @pytest.mark.slow
    def test_the_command_predicts_several_floors_as_one_alone(self, floors, model, tmp_path):
        save_type_model(model, tmp_path / "school.json")
        out = tmp_path / "out"
        code, printed, err = run_pianta(
            "predict", floors, tmp_path / "school.json", "-n", 4, "-o", out, "--json", tmp_path / "all.json"
        )
        assert code == 1, err
        assert printed.splitlines()[-1] == "2 of 3 floors predicted"
        assert [line for line in err.splitlines() if "broken" in line] == err.splitlines()
        described = json.loads((tmp_path / "all.json").read_text())["files"]
        assert [file["folder"] for file in described] == [str(out / "a"), str(out / "b")]
        alone = run_pianta("predict", floors / "a", tmp_path / "school.json", "-n", 4, "-o", tmp_path / "alone")
        assert alone.code == 0, alone.err
        assert list_files(tmp_path / "alone") == {
            name.removeprefix("a/"): content for name, content in list_files(out).items() if name.startswith("a/")
        }

    @pytest.mark.slow
    def test_one_floor_is_not_predicted_into_the_folder_of_a_batch(self, floors, model, tmp_path):
        save_type_model(model, tmp_path / "school.json")
        predict(floors, model, tmp_path / "out")
        command = ("predict", floors / "a", tmp_path / "school.json", "-n", 4, "-o")
        code, out, err = run_pianta(*command, tmp_path / "out")
        assert (code, out) == (2, "")
        assert "has the results of a batch; give" in err
        code, out, err = run_pianta(*command, floors / "a")
        assert (code, out) == (2, "")
        assert f"floor '{floors / 'a'}' is in the output folder, whose files would be replaced" in err

    @pytest.mark.slow
    def test_several_floors_need_a_folder(self, floors, model, tmp_path):
        save_type_model(model, tmp_path / "school.json")
        code, printed, err = run_pianta("predict", floors / "a", floors / "b", tmp_path / "school.json")
        assert (code, printed) == (2, "")
        assert "give a folder for them with -o" in err

    @pytest.mark.parametrize(
        ("options", "fault"),
        [
            ({"paths": "floors"}, "paths is 'floors', give a list of files and folders"),
            ({"model": "school.json"}, "model= is a str, give a model of train_type"),
            ({"explored": 0}, "explored is 0, give 1 corridor or more"),
            ({"count": 0}, "0 samples are wanted"),
        ],
    )
    def test_what_fits_no_floor_is_refused_before_the_first_one(self, floors, model, tmp_path, options, fault):
        arguments = {"paths": [floors], "model": model, **options}
        with pytest.raises(OptionError, match=fault):
            pianta.predict_batch(**arguments, out=tmp_path / "out")
        assert not (tmp_path / "out").exists()

    def test_results_over_a_floor_or_beside_other_samples_are_refused_before_the_first_one(
        self, floors, model, tmp_path
    ):
        before = list_files(floors)
        with pytest.raises(OptionError, match=r"a/floor.geojson' is in folder .*a', in which the results of"):
            predict(floors, model, floors)
        assert list_files(floors) == before
        predict(floors, model, tmp_path / "out")
        before = list_files(tmp_path / "out")
        with pytest.raises(OptionError, match="has other samples, sample-003, sample-004; remove them or"):
            [*pianta.predict_batch([floors], model, out=tmp_path / "out", count=2)]
        assert list_files(tmp_path / "out") == before

    def test_a_folder_keeps_its_dots_and_the_map_of_another_floor_goes(self, floors, model, tmp_path):
        (floors / "a").rename(floors / "house.2")
        pianta.make_world("corridor")[1].save(floors / "house.2" / "grid.npz")
        items = predict(floors, model, tmp_path / "out")
        assert items["house.2"].folder.name == "house.2"
        assert (items["house.2"].folder / "explored.npz").is_file()
        (floors / "house.2" / "grid.npz").unlink()
        predict(floors, model, tmp_path / "out", resume=False)
        assert not (items["house.2"].folder / "explored.npz").exists()

    def test_a_whole_floor_is_explored_in_part(self, model, tmp_path):
        write_floor(make_schools()[6], tmp_path / "whole.json", building_type="school")
        (item,) = pianta.predict_batch([tmp_path / "whole.json"], model, out=tmp_path / "out", count=3, explored=1)
        assert item.fault is None
        assert "truth" in json.loads((item.folder / "prediction.json").read_text())
