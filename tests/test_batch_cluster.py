"""Batches on a Dask cluster: workers that start as a user starts them, and that are killed."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

import pianta
from pianta.errors import OptionError
from pianta.generation.type_model import learn_type
from tests.command_line import list_files
from tests.generated_types import SCHOOL, make_schools

pytest.importorskip("distributed", reason="pianta[dask] is not installed")

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore::ResourceWarning")]


@contextmanager
def cluster(folder: Path, *, workers: int = 1, threads: int = 1):
    """A scheduler and workers, as programs; gives the scheduler's file and the worker program."""
    file, running = folder / "scheduler.json", []

    def start(*arguments: str) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli." + arguments[0], *arguments[1:]],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd=folder,
            env=os.environ | {"OMP_NUM_THREADS": "1"},
        )
        running.append(process)
        return process

    try:
        start("dask_scheduler", "--scheduler-file", str(file), "--port", "0", "--no-dashboard", "--host", "127.0.0.1")
        deadline = time.monotonic() + 60
        while not file.exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        options = ["--nthreads", str(threads), "--nworkers", str(workers), "--no-dashboard", "--local-directory"]
        worker = start("dask_worker", "--scheduler-file", str(file), *options, str(folder)) if workers else None
        if workers:
            _wait_for_workers(file, workers)
        yield file, worker
    finally:
        for process in reversed(running):
            process.terminate()
            process.wait(30)


def _wait_for_workers(file: Path, count: int) -> None:
    from distributed import Client

    with Client(scheduler_file=str(file), set_as_default=False) as client:
        client.wait_for_workers(count, timeout=60)


@pytest.fixture
def maps(tmp_path):
    """Three maps, and a broken one."""
    folder = tmp_path / "maps"
    folder.mkdir()
    grid = pianta.make_world("corridor")[1]
    for name in ("a", "b", "c"):
        grid.save(folder / f"{name}.npz")
    (folder / "broken.npz").write_bytes(b"no map")
    return folder


def test_workers_read_what_one_process_reads(maps, tmp_path, monkeypatch):
    here = {item.path.name: item for item in pianta.read_batch([maps], out=tmp_path / "here", labels=False)}
    with cluster(tmp_path) as (file, _):
        command = [sys.executable, "-m", "pianta", "read", str(maps), "-o", "there", "--scheduler", str(file)]
        done = subprocess.run(
            [*command, "--no-labels", "--json", "o.json"], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == 1, done.stderr
        assert "broken.npz" in done.stderr
        assert "3 of 4 files read" in done.stdout
        assert len(json.loads((tmp_path / "o.json").read_text())["files"]) == 3
        monkeypatch.chdir(tmp_path)
        again = list(pianta.read_batch([maps], out="there", scheduler=str(file), labels=False))
        assert [item.is_new for item in again] == [False, False, False, True]
        assert {item.folder.parent for item in again} == {Path("there")}
    for name in ("a", "b", "c"):
        own, other = (tmp_path / out / name / "floor.geojson" for out in ("here", "there"))
        assert own.read_bytes() == other.read_bytes()
    assert here["broken.npz"].fault == next(item.fault for item in again if item.fault)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system has no SIGKILL")
def test_a_worker_that_is_killed_loses_nothing(maps, tmp_path):
    import psutil

    with cluster(tmp_path, workers=2) as (file, worker):
        items = pianta.read_batch([maps], out=tmp_path / "out", scheduler=str(file), labels=False)
        first = next(items)
        processes = psutil.Process(worker.pid).children(recursive=True)
        max(processes, key=lambda process: process.memory_info().rss).kill()
        names = sorted(item.path.name for item in [first, *items] if item.fault is None)
    assert names == ["a.npz", "b.npz", "c.npz"]


# Works on one item: writes that it has begun, and after seconds that it has ended; its outcome is what it saw first
SLOW_PROGRAM = """
import sys, time
from pathlib import Path
from pianta.batch.cluster import run_on_cluster
def work(item):
    seen = sorted(file.name for file in Path(item).glob("*.mark"))
    (Path(item) / f"begun-{time.time()}.mark").touch()
    time.sleep(4)
    (Path(item) / f"ended-{time.time()}.mark").touch()
    return seen
for outcome in run_on_cluster(work, [sys.argv[1]], scheduler=sys.argv[2], batch="slow"):
    print([name.partition("-")[0] for name in outcome.result])
"""


def test_what_a_killed_program_has_begun_is_not_written_over_newer_results(tmp_path):
    marks = tmp_path / "marks"
    marks.mkdir()
    with cluster(tmp_path, workers=2) as (file, _):
        command = [sys.executable, "-c", SLOW_PROGRAM, str(marks), str(file)]
        with subprocess.Popen(command) as first:
            while not any(marks.iterdir()):
                time.sleep(0.05)
            first.kill()
        second = subprocess.run(command, capture_output=True, text=True, check=True)
    assert second.stdout.strip() == "['begun', 'ended']"


def test_a_scheduler_that_ends_is_one_line(maps, tmp_path):
    import psutil

    with cluster(tmp_path) as (file, worker):
        command = [sys.executable, "-m", "pianta", "read", str(maps), "-o", "out", "--scheduler", str(file)]
        process = subprocess.Popen([*command, "--no-labels"], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
        while not (tmp_path / "out" / "journal.sqlite").exists():
            time.sleep(0.05)
        for other in psutil.process_iter(["cmdline"]):
            if "distributed.cli.dask_scheduler" in (other.info["cmdline"] or ()) and str(file) in other.info["cmdline"]:
                other.kill()
        _, errors = process.communicate(timeout=120)
        worker.kill()
    assert process.returncode == 2
    assert "is gone, start it and its workers again" in errors or "does not answer" in errors
    assert "Traceback" not in errors


def test_clusters_that_do_not_fit_are_refused(maps, tmp_path, monkeypatch):
    from pianta.batch import cluster as module

    with cluster(tmp_path, threads=2) as (file, _), pytest.raises(OptionError, match="several threads"):
        list(pianta.read_batch([maps], out=tmp_path / "out", scheduler=str(file)))
    other = tmp_path / "other"
    other.mkdir()
    monkeypatch.setattr(module, "SECONDS_TO_CONNECT", 2)
    with cluster(other, workers=0) as (file, _), pytest.raises(OptionError, match="dask worker --scheduler-file"):
        list(pianta.read_batch([maps], out=tmp_path / "out", scheduler=str(file)))


@pytest.mark.parametrize("scheduler", ["tcp://127.0.0.1:1", "no such file", "", "x://y", "127.0.0.1"])
def test_a_scheduler_that_does_not_answer_is_one_line(maps, tmp_path, scheduler, monkeypatch):
    from pianta.batch import cluster as module

    monkeypatch.setattr(module, "SECONDS_TO_CONNECT", 2)
    with pytest.raises(OptionError, match="does not answer") as caught:
        list(pianta.read_batch([maps], out=tmp_path / "out", scheduler=scheduler))
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("content", ["", "{}", '{"address": 3}', '{"address": "inproc://x"}', "[1]"])
def test_a_damaged_file_of_a_scheduler_is_one_line(maps, tmp_path, content, monkeypatch):
    from pianta.batch import cluster as module

    monkeypatch.setattr(module, "SECONDS_TO_CONNECT", 2)
    (tmp_path / "scheduler.json").write_text(content)
    with pytest.raises(OptionError, match="does not answer") as caught:
        list(pianta.read_batch([maps], out=tmp_path / "out", scheduler=str(tmp_path / "scheduler.json")))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("options", [{"jobs": 2}, {"jobs": 2, "time_limit": 9.0}])
def test_jobs_and_schedulers_exclude_each_other(maps, tmp_path, options):
    with pytest.raises(OptionError, match="workers of its own"):
        pianta.read_batch([maps], out=tmp_path / "out", scheduler="tcp://127.0.0.1:1", **options)


def test_steps_of_a_bench_run_on_workers(tmp_path):
    from pianta_bench.harness.parallel import run_steps, use_scheduler

    steps = {name: partial(pow, 2, number) for number, name in enumerate("abc")}
    with cluster(tmp_path) as (file, _), use_scheduler(str(file)):
        assert [*run_steps(steps, jobs=None, track=iter)] == [1, 2, 4]


def test_workers_generate_what_one_process_generates(tmp_path):
    model = replace(learn_type(make_schools(), SCHOOL), sweeps=5, edge_moves=20, door_moves=5)
    here = [*pianta.generate_batch(model, 5, out=tmp_path / "here")]
    with cluster(tmp_path) as (file, _):
        there = [*pianta.generate_batch(model, 5, out=tmp_path / "there", scheduler=str(file))]
    assert [item.description for item in here] == [item.description for item in there]
    one, other = (list_files(tmp_path / name / "part-0001") for name in ("here", "there"))
    assert one == other
