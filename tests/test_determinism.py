"""The same command gives the same bytes, whatever hash seed, threads, working folder, time zone and jobs it has."""

import hashlib
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import pianta

# Two surroundings of a process that differ in all that must not matter
SURROUNDINGS = (
    {"PYTHONHASHSEED": "1", "OMP_NUM_THREADS": "1", "TZ": "UTC", "LC_ALL": "C"},
    {"PYTHONHASHSEED": "77", "OMP_NUM_THREADS": "2", "TZ": "Asia/Tokyo", "LC_ALL": "C.UTF-8", "COLUMNS": "200"},
)
JOBS = ("1", "2")
# Verb and arguments; {jobs} is another number each time. Outputs lie in "out".
COMMANDS = {
    "read": "read ../in/maps -o out --jobs {jobs} --json out/all.json --walls",
    "read thesis": "read ../in/maps/ring.npz -o out --method thesis --no-labels",
    "read a plan": "read ../in/plan.svg -o out",
    "convert to svg": "convert ../in/read --to svg -o out/floor.svg",
    "convert to dxf": "convert ../in/read --to dxf -o out/floor.dxf",
    "convert to geojson-layers": "convert ../in/read --to geojson-layers -o out",
    "convert to gazebo": "convert ../in/read --to gazebo -o out",
    "convert to ifc": "convert ../in/read --to ifc -o out/building.ifc",
    "convert to excel": "convert ../in/read --to excel -o out/rooms.xlsx",
    "convert to sweethome3d": "convert ../in/read --to sweethome3d -o out/building.sh3d",
    "convert to picture": "convert ../in/read --to picture -o out",
    "convert to scene-graph": "convert ../in/read --to scene-graph -o out/scene_graph.json",
    "world": "world office -o out --seed 4 --noise 0.5 --furniture 0.5",
    "explore": "explore ../in/maps/ring.npz --policy gain --stop 0.5 --steps 2 --animation none -o out",
    "evacuate": "evacuate ../in/read --exit 1 -o out",
    "patterns": "patterns ../in/read -o out",
    "realism": "realism ../in/read --type school -o out",
    "train": "train type ../in/floors -o out/model.json",
    "generate": "generate ../in/model.json -n 3 --jobs {jobs} -o out --seed 5",
    "generate worlds": "generate ../in/model.json -n 2 --scan --resolution 0.1 --jobs {jobs} -o out --seed 5",
    "predict": "predict ../in/seen.geojson ../in/model.json -n 20 -o out --seed 5",
    "view": "view ../in/read --html out/report.html",
}
# Files that state when they were made
TIMED = {"journal.sqlite"}


def run(words: str, folder: Path, surroundings: dict[str, str]) -> tuple[str, dict[str, str]]:
    """What a command prints, and the digests of its files."""
    (folder / "out").mkdir(parents=True)
    system = {name: os.environ[name] for name in ("PATH", "HOME", "LD_LIBRARY_PATH") if name in os.environ}
    done = subprocess.run(
        [sys.executable, "-m", "pianta", *words.split()],
        cwd=folder,
        env=system | surroundings,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    files = {
        str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted((folder / "out").rglob("*"))
        if file.is_file() and not file.name.startswith(tuple(TIMED))
    }
    assert files
    return done.stdout, files


def make_school(name: str, seed: int) -> pianta.Floor:
    """A floor with labels of schools."""
    floor = pianta.make_world(name, seed=seed)[0]
    rooms = tuple(replace(room, label="CLASSROOM" if room.label == "ROOM" else room.label) for room in floor)
    return pianta.Floor(rooms, floor.doors, building_type={"school": 1.0}, source=f"{name} {seed}")


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """A folder "in" with maps, floors, a plan and a model, beside which folders of runs lie."""
    folder = tmp_path_factory.mktemp("determinism")
    folder_in = folder / "in"
    (folder_in / "maps").mkdir(parents=True)
    (folder_in / "floors").mkdir()
    for name in ("ring", "corridor"):
        pianta.make_world(name, noise=0.3)[1].save(folder_in / "maps" / f"{name}.npz")
    for seed in range(3):
        make_school("corridor", seed).save(folder_in / "floors" / f"{seed}.geojson")
    discovered = make_school("corridor", 1)
    # The corridor goes on
    rooms = tuple(replace(room, partial=room.label == "CORRIDOR") for room in discovered)
    replace(discovered, rooms=rooms).save(folder_in / "seen.geojson")
    pianta.read(folder_in / "maps" / "corridor.npz").save(folder_in / "read")
    pianta.convert(folder_in / "read", folder_in / "plan.svg", to="svg")
    run_words = [
        sys.executable,
        "-m",
        "pianta",
        "train",
        "type",
        str(folder_in / "floors"),
        "-o",
        str(folder_in / "model.json"),
    ]
    subprocess.run(run_words, check=True, capture_output=True)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_surroundings_change_no_byte(inputs, name):
    slug = name.replace(" ", "-")
    first, second = (
        run(COMMANDS[name].format(jobs=jobs), inputs / f"{slug}-{jobs}", surroundings)
        for jobs, surroundings in zip(JOBS, SURROUNDINGS, strict=True)
    )
    assert first == second
