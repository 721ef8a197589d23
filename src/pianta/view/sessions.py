"""Session: a folder of a floor as the page sees it, with corrections that are not saved yet."""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from hashlib import file_digest, sha256
from pathlib import Path
from stat import S_ISREG
from threading import RLock
from typing import Any

from pianta.corrections.corrections_file import FILE_NAME, parse_correction, read_corrections
from pianta.corrections.kinds import Correction
from pianta.errors import CorrectionError, PiantaError
from pianta.floor.area_trust import AreaTrust
from pianta.io._files import one_line_reason, real_path, short_repr
from pianta.io._folders import only_writer
from pianta.io.building_folders import read_storey_folders
from pianta.io.floors import read_floor, read_scale_member
from pianta.reading.saved_reading import FLOOR, GRID, SavedReading
from pianta.view.background import draw_background
from pianta.view.edits import read_edit
from pianta.view.states import corners_of, describe_changes, describe_labels, describe_trust, name_type

# Files whose content is the version of a folder.
FILES = (FLOOR, FILE_NAME, GRID)
# Lists of corrections whose floors are kept, so that an edit and its undo take one step; chosen by hand.
KEPT_READINGS = 200
# Versions of the files on which edits can still be made after the files have changed.
KEPT_VERSIONS = 3
# How often a folder is read again that changes while it is read.
ATTEMPTS = 5

NOT_FOUND, CONFLICT, UNFIT, LOCKED = 404, 409, 422, 423


class RefusedError(PiantaError):
    """Why a request is not answered. status: of HTTP."""

    def __init__(self, status: int, message: str) -> None:
        """The message is one line for the user."""
        super().__init__(message)
        self.status = status


class Session:
    """A folder of a floor as the page sees it; safe to use from several threads.

    Corrections that are not saved belong to the page, which sends them with each request: two pages do not disturb
    each other, and a page that is loaded again loses nothing that it has kept.
    """

    def __init__(self, number: int, name: str, folder: Path, numbers: Mapping[Path, int] | None = None) -> None:
        """number: of the map on the page. numbers: those of all folders, to which stairs and lifts lead."""
        self.number, self.name, self.folder, self.numbers = number, name, folder, numbers or {}
        self._lock = RLock()
        self._hashes: dict[Path, tuple[tuple[int, ...], bytes]] = {}
        self._saved: OrderedDict[str, SavedReading] = OrderedDict()
        self._readings: OrderedDict[tuple[str, tuple[Correction, ...]], SavedReading] = OrderedDict()
        self._summary: tuple[str, dict[str, Any]] = ("", {})
        self._background: tuple[str, bytes | None] = ("", None)

    def version(self) -> str:
        """A hash of the files; raises RefusedError if there is no floor any more."""
        with self._lock:
            contents = [self._hash_file(self.folder / name) for name in FILES]
        if not contents[0]:
            raise RefusedError(
                NOT_FOUND, f"folder {short_repr(self.folder)} has no {FLOOR} any more, read the map again"
            )
        return sha256(b"".join(contents)).hexdigest()[:32]

    def summarize(self) -> dict[str, Any]:
        """The entry of a gallery; of a floor that cannot be read, the name and the `error`."""
        entry = {"map": self.number, "name": self.name}
        try:
            version = self.version()
            with self._lock:
                if self._summary[0] != version:
                    self._summary = version, self._read_summary()
                return entry | self._summary[1]
        except PiantaError as error:
            return entry | {"rooms": 0, "corrections": 0, "area": 0.0, "type": None, "error": str(error)}

    def describe(self) -> dict[str, Any]:
        """The state on disk, as in the contract of the page; raises RefusedError."""
        with self._lock:
            version, saved = self._open()
        problem = self._find_problem(saved)
        return {
            "map": self.number,
            "name": self.name,
            "version": version,
            "writable": problem is None,
            "problem": problem,
            "has_map": saved.grid is not None,
            "labels": describe_labels(saved.floor),
            "links": [*self._list_links()],
            **self._describe(version, saved),
        }

    def edit(self, version: str, corrections: Sequence[Mapping[str, Any]], edit: Mapping[str, Any]) -> dict[str, Any]:
        """What the page shows after one more edit; raises RefusedError if it does not fit, or changes nothing."""
        with self._lock:
            before = self._apply(version, _parse_all(corrections))
            try:
                correction = read_edit(before.floor, edit)
                after = before.add(correction)
            except CorrectionError as error:
                raise RefusedError(UNFIT, str(error)) from error
            if after is before:
                raise RefusedError(UNFIT, f"{correction}: the floor is so already")
            self._keep(version, after)
        return self._describe(version, after)

    def apply(self, version: str, corrections: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """What the page shows with a list of corrections; raises RefusedError."""
        with self._lock:
            reading = self._apply(version, _parse_all(corrections))
        return self._describe(version, reading)

    def save(self, version: str, corrections: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """Write the corrections, all files or none, and give the new state; raises RefusedError."""
        with self._lock, only_writer(self.folder):
            if self.version() != version:
                raise RefusedError(
                    CONFLICT, f"the files of {self.name} have changed on disk, so nothing was saved; load them"
                )
            reading = self._apply(version, _parse_all(corrections))
            problem = self._find_problem(reading)
            if problem:
                raise RefusedError(LOCKED, problem)
            try:
                reading.save()
            except PiantaError as error:
                raise RefusedError(LOCKED, f"nothing was saved: {error}") from error
            self._remember(self.version(), reading)
            return self.describe()

    def draw_background(self) -> bytes | None:
        """The picture below the floor as PNG, None without one; raises RefusedError."""
        with self._lock:
            version, saved = self._open()
            if self._background[0] != version:
                self._background = version, draw_background(saved)
            return self._background[1]

    def _describe(self, version: str, reading: SavedReading) -> dict[str, Any]:
        """What corrections change; the background too, whose corners a correction of the scale moves."""
        background = None
        if reading.grid is not None:
            url = f"api/maps/{self.number}/background.png?v={version}"
            background = {"url": url, "corners": corners_of(reading.grid)}
        return {"background": background, **describe_changes(reading)}

    def _list_links(self) -> Iterator[dict[str, Any]]:
        """The stairs and lifts from a room of this storey to a room of another one on the page."""
        folder = real_path(self.folder)
        building = None
        # A damaged file beside the folder does not hinder a look at the floor.
        with suppress(PiantaError):
            building = read_storey_folders(folder.parent)
        for link in building.links if building else ():
            for (storey, room), (other, upper) in (link.ends, link.ends[::-1]):
                number = self.numbers.get(folder.parent / other)
                if building and storey == folder.name and number is not None:
                    title = building.titles.get(other, other)
                    yield {"kind": link.kind, "room": room, "storey": title, "map": number, "to": upper}

    def _find_problem(self, reading: SavedReading) -> str | None:
        """Why corrections cannot be saved; None if they can."""
        if reading.grid is None:
            return f"folder {short_repr(self.folder)} has no {GRID}, read the map again to save corrections"
        if not os.access(self.folder, os.W_OK | os.X_OK):
            return f"folder {short_repr(self.folder)} may not be written, check its permissions"
        return None

    def _apply(self, version: str, corrections: tuple[Correction, ...]) -> SavedReading:
        """The reading of a version with a list of corrections, made from the longest list that has a reading."""
        if version not in self._saved and self._open()[0] != version:
            raise RefusedError(
                CONFLICT, f"the files of {self.name} have changed on disk, load them and apply the corrections"
            )
        saved = self._saved[version]
        for length in (len(corrections), len(corrections) - 1, len(saved.corrections)):
            start = self._readings.get((version, corrections[: max(length, 0)]))
            reading = start and _add_all(start, corrections[max(length, 0) :])
            if reading is not None:
                break
        else:
            reading = saved.keep(corrections)
        self._keep(version, reading)
        return reading

    def _open(self) -> tuple[str, SavedReading]:
        """The version of the files and their content, read if it is not known."""
        for _ in range(ATTEMPTS):
            version = self.version()
            if version in self._saved:
                return version, self._saved[version]
            failure = None
            try:
                reading = SavedReading.open(self.folder)
            except PiantaError as error:
                failure = RefusedError(UNFIT, str(error))
            # Another process may have written between two files.
            if self.version() == version:
                if failure:
                    raise failure
                self._remember(version, reading)
                return version, reading
        raise RefusedError(CONFLICT, f"the files of {self.name} are being written, try again")

    def _remember(self, version: str, saved: SavedReading) -> None:
        self._saved[version] = saved
        while len(self._saved) > KEPT_VERSIONS:
            self._saved.popitem(last=False)
        self._keep(version, saved)

    def _keep(self, version: str, reading: SavedReading) -> None:
        self._readings[version, reading.corrections] = reading
        self._readings.move_to_end((version, reading.corrections))
        while len(self._readings) > KEPT_READINGS:
            self._readings.popitem(last=False)

    def _read_summary(self) -> dict[str, Any]:
        floor, corrections = read_floor(self.folder / FLOOR), self.folder / FILE_NAME
        trust = AreaTrust.from_member(read_scale_member(self.folder / FLOOR))
        return {
            "rooms": len(floor),
            "corrections": len(read_corrections(corrections)) if corrections.exists() else 0,
            "area": sum(room.polygon.area for room in floor),
            "type": name_type(floor),
            **({} if trust is AreaTrust.EXACT else {"areas": describe_trust(trust)}),
        }

    def _hash_file(self, file: Path) -> bytes:
        """A hash of the content, computed again when the file is another one; empty without a file."""
        try:
            status = file.stat()
            key = status.st_mtime_ns, status.st_size, status.st_ino
            if self._hashes.get(file, ((), b""))[0] != key:
                self._hashes[file] = key, _hash(file, status)
            return self._hashes[file][1]
        except (FileNotFoundError, NotADirectoryError):
            return b""
        except OSError as error:
            raise RefusedError(NOT_FOUND, f"{short_repr(file)} cannot be read: {one_line_reason(error)}") from error


def _hash(file: Path, status: os.stat_result) -> bytes:
    """A hash of the content; of a device or a pipe, which would not end, and which is refused later, of its name."""
    if not S_ISREG(status.st_mode):
        return sha256(str(file).encode(errors="surrogateescape")).digest()
    with file.open("rb") as stream:
        return file_digest(stream, "sha256").digest()


def _add_all(start: SavedReading, corrections: Sequence[Correction]) -> SavedReading | None:
    """The reading with more corrections; None if one does not fit or changes nothing."""
    reading = start
    for correction in corrections:
        try:
            after = reading.add(correction)
        except CorrectionError:
            return None
        if after is reading:
            return None
        reading = after
    return reading


def _parse_all(corrections: Sequence[Mapping[str, Any]]) -> tuple[Correction, ...]:
    """The corrections that a page sends; what the server has added to them for reading is left out."""
    parsed = []
    for number, item in enumerate(corrections, start=1):
        members = {name: value for name, value in item.items() if name not in {"text", "problem"}}
        try:
            parsed.append(parse_correction(members))
        except CorrectionError as error:
            raise RefusedError(UNFIT, f"correction {number}: {error}") from error
    return tuple(parsed)
