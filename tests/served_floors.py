"""Folders as `pianta read` writes them, and servers that show them."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from http.client import HTTPConnection, HTTPResponse
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
from shapely import LineString, box
from shapely.affinity import translate

from pianta.floor import Door, Floor, Room
from pianta.generation.world import make_world
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.io.floors import save_floor
from pianta.labels import ALL_SCHEMAS
from pianta.reading.reading import write_floor
from pianta.view.folders import find_folders
from pianta.view.server import listen, make_app, make_server

TOKEN = "secret"  # noqa: S105 - of tests
# Two rooms of 4 m x 3 m with a wall of 0.2 m between them, north of a corridor; the second has an entrance.
FLOOR = Floor(
    (
        Room(1, box(0, 2, 4, 5), "OFFICE"),
        Room(2, box(4.2, 2, 8.2, 5), "KITCHEN", name="Bar"),
        Room(3, box(0, 0, 8.2, 1.8), "CORRIDOR"),
    ),
    (
        Door((1, 3), LineString([(1, 1.9), (2, 1.9)]), 1.0),
        Door((2, 3), LineString([(6, 1.9), (7, 1.9)]), 1.0),
        Door((2, None), LineString([(8.3, 3), (8.3, 4)]), 1.0),
    ),
    building_type={"office": 0.9, "school": 0.1},
    last_id=3,
)


def make_grid() -> GridMap:
    """The map of FLOOR: 60 x 90 cells of 0.1 m, from (-0.3, -0.3); unknown but for a free row and an occupied one."""
    cells = np.full((60, 90), UNKNOWN, np.int8)
    cells[0], cells[1] = FREE, OCCUPIED
    return GridMap(cells, 0.1, (-0.3, -0.3, 0.0))


def write_folder(folder: Path, floor: Floor = FLOOR) -> Path:
    """The folder of a floor that was read."""
    folder.mkdir(parents=True)
    grid = make_grid()
    grid.save(folder / "grid.npz")
    write_floor(floor, grid, folder, ALL_SCHEMAS)
    return folder


def write_large_folder(folder: Path) -> Path:
    """The folder of 20 offices of 30 rooms, on a map of 4000 x 4000 cells of 0.05 m."""
    folder.mkdir(parents=True)
    office, wing = make_world("office", seed=1, furniture=1.0, noise=0.2)
    cells = np.full((4000, 4000), UNKNOWN, np.int8)
    rooms: list[Room] = []
    doors: list[Door] = []
    height, width = wing.shape
    x, y = wing.origin[:2]
    for row, column in np.ndindex(4, 5):
        bottom, left = 1000 * row, 800 * column
        # Rows of cells are counted from the north.
        cells[4000 - bottom - height : 4000 - bottom, left : left + width] = wing.cells
        before = len(rooms)
        move = partial(translate, xoff=0.05 * left - x, yoff=0.05 * bottom - y)
        rooms += (replace(room, id=before + room.id, polygon=move(room.polygon)) for room in office.rooms)
        doors += (
            replace(
                door,
                rooms=(before + door.rooms[0], None if door.rooms[1] is None else before + door.rooms[1]),
                line=move(door.line),
            )
            for door in office.doors
        )
    GridMap(cells, 0.05, (0.0, 0.0, 0.0)).save(folder / "grid.npz")
    save_floor(Floor(tuple(rooms), tuple(doors), last_id=len(rooms)), folder / "floor.geojson")
    return folder


@dataclass(frozen=True)
class Answer:
    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)

    @property
    def error(self) -> str:
        """The message of a refusal, which is one line."""
        (message,) = self.json.values()
        assert self.status >= 400
        assert isinstance(message, str)
        assert "\n" not in message
        return message


@dataclass(frozen=True)
class Client:
    port: int

    def get(self, path: str, **headers: str) -> Answer:
        """The answer to a request below the token."""
        return self.ask("GET", f"/{TOKEN}/{path}", headers=headers)

    def post(self, path: str, body: object, **headers: str) -> Answer:
        content = body if isinstance(body, bytes) else json.dumps(body).encode()
        return self.ask("POST", f"/{TOKEN}/{path}", content, {"Content-Type": "application/json", **headers})

    def post_parts(self, path: str, parts: Iterator[bytes]) -> Answer:
        """The answer to a body without a length."""
        headers = {"Content-Type": "application/json", "Transfer-Encoding": "chunked"}
        return self.ask("POST", f"/{TOKEN}/{path}", parts, headers)

    def ask(self, method: str, path: str, body: Any = None, headers: dict[str, str] | None = None) -> Answer:
        connection = HTTPConnection("127.0.0.1", self.port, timeout=20)
        try:
            connection.request(method, path, body, headers or {}, encode_chunked=not isinstance(body, bytes))
            response: HTTPResponse = connection.getresponse()
            names = {name.lower(): value for name, value in response.getheaders()}
            return Answer(response.status, names, response.read())
        finally:
            connection.close()

    def version(self, number: int = 0) -> str:
        version: str = self.get(f"api/maps/{number}/version").json["version"]
        return version

    def edit(self, corrections: list[Any], number: int = 0, /, **edit: object) -> Answer:
        """The answer to an edit after a list of corrections."""
        body = {"version": self.version(number), "corrections": corrections, "edit": edit}
        return self.post(f"api/maps/{number}/edit", body)


@contextmanager
def serving(*folders: Path) -> Iterator[Client]:
    """A server of folders in a thread."""
    server = make_server(make_app(find_folders(folders), token=TOKEN))
    with listen() as listener:
        thread = Thread(target=server.run, kwargs={"sockets": [listener]})
        thread.start()
        try:
            yield Client(listener.getsockname()[1])
        finally:
            server.should_exit = True
            thread.join(20)
