"""How fast the page of `pianta view` is in Chromium.

    python benchmarks/time_view.py [--repeats N]

first picture: from the request of the page until the rooms and the map of a floor of 60 rooms are drawn, of a server
    that is up, in a new browser profile each time.
edit: from the request of a merge on that floor until the page has drawn the answer.
frames: that the browser draws in a second while a floor of 500 rooms zooms and pans, and the longest pause between two.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from time import perf_counter
from typing import Any

import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright
from shapely import LineString, box

import pianta
from pianta.floor import Door, Floor, Room
from pianta.gridmap import FREE, OCCUPIED, GridMap
from pianta.io.floors import save_floor
from pianta.view.folders import find_folders
from pianta.view.server import listen, make_app, make_server

TOKEN = "benchmark"  # noqa: S105 - of a server that ends with this script
# Metres: from room to room, and the side of a room.
STEP, SIDE = 4.0, 3.8
RESOLUTION = 0.05
READY = "Boolean(globalThis.pianta?.session?.state && document.querySelector('img.background.loaded'))"
TWO_FRAMES = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
# Milliseconds from the request until the answer is drawn.
EDIT = """async (rooms) => {
    const start = performance.now();
    await pianta.session.edit({kind: "merge", rooms});
    await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
    return performance.now() - start;
}"""
# Frames a second and the longest pause, while the map zooms in and out and pans for some seconds.
FRAMES = """async (seconds) => {
    const {map} = pianta.floorMap;
    const times = [];
    const note = (time) => {times.push(time); if (time < times[0] + seconds * 1000) requestAnimationFrame(note);};
    requestAnimationFrame(note);
    for (let turn = 0; turn < seconds * 2; turn += 1) {
        if (turn % 3 === 2) map.panBy([turn % 2 ? 150 : -150, 80]);
        else map.setZoom(map.getZoom() + (turn % 3 ? -1 : 1));
        await new Promise((done) => setTimeout(done, 500));
    }
    const pauses = times.slice(1).map((time, index) => time - times[index]);
    return [(pauses.length * 1000) / (times.at(-1) - times[0]), Math.max(...pauses)];
}"""


def write_floor(folder: Path, rows: int, columns: int) -> Path:
    """A folder with a grid of square rooms and a door between each two of a row."""
    folder.mkdir()
    positions = [(row, column) for row in range(rows) for column in range(columns)]
    rooms = [
        Room(number, box(STEP * column, STEP * row, STEP * column + SIDE, STEP * row + SIDE), "OFFICE")
        for number, (row, column) in enumerate(positions, start=1)
    ]
    doors = [
        Door((number, number + 1), LineString([(STEP * (column + 1) - 0.1, STEP * row + y) for y in (1.0, 2.0)]), 1.0)
        for number, (row, column) in enumerate(positions, start=1)
        if column + 1 < columns
    ]
    cells = np.full((round(rows * STEP / RESOLUTION), round(columns * STEP / RESOLUTION)), FREE, np.int8)
    wall = round(STEP / RESOLUTION)
    cells[::wall], cells[:, ::wall] = OCCUPIED, OCCUPIED
    GridMap(cells, RESOLUTION).save(folder / "grid.npz")
    save_floor(Floor(tuple(rooms), tuple(doors), last_id=len(rooms)), folder / "floor.geojson")
    return folder


@contextmanager
def serving(folder: Path) -> Iterator[str]:
    """The address of a server of a folder."""
    server = make_server(make_app(find_folders([folder]), token=TOKEN))
    with listen() as listener:
        thread = Thread(target=server.run, kwargs={"sockets": [listener]})
        thread.start()
        try:
            yield f"http://127.0.0.1:{listener.getsockname()[1]}/{TOKEN}/"
        finally:
            server.should_exit = True
            thread.join()


def wait_until(page: Page, condition: str) -> None:
    """Wait without eval, which the page forbids."""
    while not page.evaluate(condition):
        page.wait_for_timeout(5)


@contextmanager
def opened(browser: Browser, address: str) -> Iterator[tuple[Page, float]]:
    """The page in a profile of its own, and the seconds until its first picture."""
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    page = context.new_page()
    start = perf_counter()
    page.goto(address, wait_until="commit")
    wait_until(page, READY)
    page.evaluate(TWO_FRAMES)
    yield page, perf_counter() - start
    context.close()


def measure_small_floor(browser: Browser, folder: Path, repeats: int) -> tuple[list[float], list[float]]:
    """Seconds until the first picture, and milliseconds of an edit, of 60 rooms."""
    pictures, edits = [], []
    for number in range(repeats):
        # A new server each time: the first one has read nothing yet.
        with serving(folder) as address, opened(browser, address) as (page, seconds):
            pictures.append(seconds)
            edits += [
                page.evaluate(EDIT, [first, first + 1]) for first in (1 + 10 * (number % 3), 5 + 10 * (number % 3))
            ]
    return pictures, edits


def measure_large_floor(browser: Browser, folder: Path, repeats: int) -> tuple[list[float], list[float], list[float]]:
    """Seconds until the first picture, frames a second, and milliseconds of the longest pause, of 500 rooms."""
    pictures, frames, pauses = [], [], []
    with serving(folder) as address:
        for _ in range(repeats):
            with opened(browser, address) as (page, seconds):
                rate, pause = page.evaluate(FRAMES, 9)
            pictures.append(seconds)
            frames.append(rate)
            pauses.append(pause)
    return pictures, frames, pauses


def describe(values: list[float], unit: str) -> str:
    """Mean, standard deviation and largest value."""
    return f"{statistics.mean(values):.3g} ± {statistics.stdev(values):.2g} {unit}, at most {max(values):.3g} {unit}"


def main() -> None:
    """Measure, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=10, help="2 at least; 10 unless given")
    repeats = parser.parse_args().repeats
    with tempfile.TemporaryDirectory() as name, sync_playwright() as playwright:
        options: dict[str, Any] = {"executable_path": shutil.which("chromium"), "args": ["--no-sandbox"]}
        browser = playwright.chromium.launch(**options)
        pictures, edits = measure_small_floor(browser, write_floor(Path(name) / "small", 6, 10), repeats)
        large, frames, pauses = measure_large_floor(browser, write_floor(Path(name) / "large", 20, 25), repeats)
        browser.close()
    print(f"pianta {pianta.__version__}, {repeats} repeats")
    print(f"first picture of 60 rooms: {describe(pictures, 's')}")
    print(f"edit of 60 rooms: {describe(edits, 'ms')}")
    print(f"first picture of 500 rooms: {describe(large, 's')}")
    print(f"frames of 500 rooms: {statistics.mean(frames):.3g} ± {statistics.stdev(frames):.2g} a second")
    print(f"longest pause of 500 rooms: {describe(pauses, 'ms')}")


if __name__ == "__main__":
    main()
