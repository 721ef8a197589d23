"""The scale of a plan in its folder: corrections keep it, and a corrected one is certain."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import box

from pianta.corrections.kinds import NameRoom, ScaleToArea
from pianta.floor import Floor, Room
from pianta.gridmap import UNKNOWN, GridMap
from pianta.labels import ALL_SCHEMAS
from pianta.plan.sheets.sheet import PlanScale
from pianta.reading._reader import Reader
from pianta.reading.read import read
from pianta.reading.reading import OUTPUTS, StoreyReading, write_floor
from pianta.reading.saved_reading import SavedReading

SCALE = PlanScale(0.05, "the look of the drawing", 0.3, (0.04, 0.06), (0.02, 0.1), is_look=True)


@pytest.fixture
def folder(tmp_path):
    """A room of 4 m x 3 m, as `pianta read` writes it."""
    grid = GridMap(np.full((100, 120), UNKNOWN, np.int8), 0.05)
    write_floor(Floor((Room(1, box(1, 1, 5, 4)),)), grid, tmp_path, ALL_SCHEMAS, scale=SCALE)
    grid.save(tmp_path / OUTPUTS[-1])
    return tmp_path


def read_scale(folder: Path) -> dict[str, Any]:
    member: dict[str, Any] = json.loads((folder / "floor.geojson").read_text())["scale"]
    return member


def test_a_correction_keeps_the_scale(folder):
    SavedReading.open(folder).add(NameRoom((2, 2), "Kitchen")).save()
    assert PlanScale.from_json(read_scale(folder)) == SCALE
    assert SavedReading.open(folder).scale == SCALE


def test_a_corrected_scale_is_certain_and_can_be_undone(folder):
    """48 m² are four times as many, so that lengths are doubled."""
    SavedReading.open(folder).add(ScaleToArea((2, 2), 48.0)).save()
    scale = read_scale(folder)
    assert (scale["metres_per_pixel"], scale["sources"]) == (pytest.approx(0.1), ["a correction"])
    assert not scale["is_rough"]
    SavedReading.open(folder).keep([]).save()
    assert PlanScale.from_json(read_scale(folder)) == SCALE


@pytest.mark.parametrize(
    ("correction", "resolution", "is_rough"),
    [(NameRoom((2, 2), "Kitchen"), 0.05, True), (ScaleToArea((2, 2), 48.0), 0.1, False)],
)
def test_a_plan_that_is_read_again_keeps_both_scales(folder, monkeypatch, correction, resolution, is_rough):
    """That of the plan is in uncorrected.geojson, on which every later correction is made."""
    SavedReading.open(folder).add(correction).save()
    grid = GridMap(np.full((100, 120), UNKNOWN, np.int8), 0.05)
    read_anew = StoreyReading(Floor((Room(1, box(1, 1, 5, 4)),)), grid, scale=SCALE)
    monkeypatch.setattr(Reader, "_open", lambda *_: [read_anew])
    read("plan.png", previous=folder, labels=False).save(folder)
    assert read_scale(folder)["metres_per_pixel"] == pytest.approx(resolution)
    assert SavedReading.open(folder).scale == SCALE
    SavedReading.open(folder).add(NameRoom((2, 2), "Bath")).save()
    assert read_scale(folder)["metres_per_pixel"] == pytest.approx(resolution)
    assert read_scale(folder)["is_rough"] == is_rough
    SavedReading.open(folder).keep([]).save()
    assert PlanScale.from_json(read_scale(folder)) == SCALE


@pytest.mark.parametrize(
    "member",
    [
        None,
        [],
        "0.05",
        {},
        SCALE.as_json() | {"metres_per_pixel": -1},
        SCALE.as_json() | {"metres_per_pixel": "wide"},
        SCALE.as_json() | {"interval": [0.1]},
        SCALE.as_json() | {"interval": [0.1, -0.1]},
        SCALE.as_json() | {"sources": 3},
    ],
)
def test_a_damaged_scale_is_none(member):
    assert PlanScale.from_json(member) is None


def test_a_damaged_scale_in_a_folder_is_dropped(folder):
    path = folder / "floor.geojson"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"scale": {"metres_per_pixel": [1]}}))
    SavedReading.open(folder).add(NameRoom((2, 2), "Kitchen")).save()
    assert "scale" not in json.loads(path.read_text())
