"""ResultSession: results that the page shows and does not change, such as predictions and explorations."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from threading import RLock
from typing import Any, ClassVar, Generic, NoReturn, TypeVar

from pianta.errors import PiantaError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io._files import one_line_reason, short_repr
from pianta.reading.saved_reading import SavedReading
from pianta.view.background import draw_background
from pianta.view.sessions import NOT_FOUND, UNFIT, RefusedError
from pianta.view.states import corners_of, describe_changes

Content = TypeVar("Content")
# Members of a floor's state that nothing else has.
PLAIN = {"building_type": {}, "corrections": [], "labels": [], "graph": [], "has_map": False, "background": None}


class ResultSession(ABC, Generic[Content]):
    """A folder of results as the page sees it, read-only; safe to use from several threads.

    It has the methods of a Session. Some have parts: steps, samples or buildings, numbered from 0, which the page loads
    when it needs them.
    """

    # What the page calls it; the pattern of the files that are its version.
    kind: ClassVar[str]
    patterns: ClassVar[tuple[str, ...]]

    def __init__(self, number: int, name: str, file: Path) -> None:
        """number: on the page. file: by which the results were recognised."""
        self.number, self.name, self.file, self.folder = number, name, file, file.parent
        self._lock = RLock()
        self._known: tuple[str, Content] | None = None
        self._parts: dict[int, dict[str, Any]] = {}

    @abstractmethod
    def _read(self) -> Content:
        """The results on disk; raises PiantaError."""

    @abstractmethod
    def _describe(self, content: Content, version: str) -> dict[str, Any]:
        """The members of the state that are its own."""

    @abstractmethod
    def _list_facts(self, content: Content) -> list[str]:
        """What a gallery says of the results, in a few words each."""

    @abstractmethod
    def _count_parts(self, content: Content) -> int:
        """The number of parts."""

    def _choose_part(self, content: Content) -> int:
        """The part whose picture the state has."""
        del content
        return 0

    @abstractmethod
    def _describe_part(self, content: Content, part: int, version: str) -> dict[str, Any]:
        """What the page shows of a part."""

    @abstractmethod
    def _open_picture(self, content: Content, part: int) -> GridMap | None:
        """The map below a part; None without one."""

    def version(self) -> str:
        """A hash of the names, sizes and times of the files; raises RefusedError if the results are gone."""
        try:
            files = sorted({file for pattern in self.patterns for file in self.folder.glob(pattern)} | {self.file})
            stats = [(file.name, (status := file.stat()).st_mtime_ns, status.st_size) for file in files]
        except OSError as error:
            reason = one_line_reason(error)
            raise RefusedError(NOT_FOUND, f"{short_repr(self.file)} cannot be read any more: {reason}") from error
        return sha256(repr(stats).encode()).hexdigest()[:32]

    def summarize(self) -> dict[str, Any]:
        """The entry of a gallery; of results that cannot be read, the name and the `error`."""
        entry = {"map": self.number, "name": self.name, "kind": self.kind, "rooms": 0, "corrections": 0, "area": 0.0}
        try:
            return {**entry, "type": None, "facts": [self.kind, *self._list_facts(self._open()[1])]}
        except PiantaError as error:
            return {**entry, "type": None, "error": str(error)}

    def describe(self) -> dict[str, Any]:
        """The state of the page; raises RefusedError."""
        version, content = self._open()
        return {
            "map": self.number,
            "name": self.name,
            "kind": self.kind,
            "heading": ", ".join([self.kind, *self._list_facts(content)]),
            "version": version,
            "writable": False,
            "problem": "results are shown as they were written",
            **PLAIN,
            **self._describe(content, version),
        }

    def part(self, number: int) -> dict[str, Any]:
        """A part of the results; raises RefusedError for an unknown number."""
        version, content = self._open()
        self._check_part(content, number)
        with self._lock:
            if number not in self._parts:
                self._parts[number] = self._describe_part(content, number, version)
            return self._parts[number]

    def list_parts(self) -> list[dict[str, Any]]:
        """All parts, for a report."""
        return [self.part(number) for number in range(self._count_parts(self._open()[1]))]

    def draw_background(self, part: int | None = None) -> bytes | None:
        """The picture below the floor of a part, or of the state, as PNG, None without one; raises RefusedError."""
        _, content = self._open()
        number = self._choose_part(content) if part is None else part
        self._check_part(content, number)
        grid = self._open_picture(content, number)
        return None if grid is None else draw_background(as_reading(self.folder, Floor(()), grid))

    def edit(self, version: str, corrections: Sequence[Mapping[str, Any]], edit: Mapping[str, Any]) -> NoReturn:
        """Refuse; these results have no corrections."""
        del version, corrections, edit
        raise RefusedError(UNFIT, f"{self.name} ({self.kind}) has no corrections, correct the floor of a map")

    def apply(self, version: str, corrections: Sequence[Mapping[str, Any]]) -> NoReturn:
        """Refuse, as `edit` does."""
        self.edit(version, corrections, {})

    def save(self, version: str, corrections: Sequence[Mapping[str, Any]]) -> NoReturn:
        """Refuse, as `edit` does."""
        self.edit(version, corrections, {})

    def _check_part(self, content: Content, part: int) -> None:
        if not 0 <= part < self._count_parts(content):
            raise RefusedError(NOT_FOUND, f"{self.name} has no part {part}")

    def _open(self) -> tuple[str, Content]:
        """The version and the results, read again if the files have changed."""
        with self._lock:
            version = self.version()
            if self._known is None or self._known[0] != version:
                try:
                    self._known = version, self._read()
                except PiantaError as error:
                    raise RefusedError(UNFIT, str(error)) from error
                self._parts = {}
            return self._known

    def _address_of(self, part: int, version: str) -> str:
        return f"api/maps/{self.number}/parts/{part}/background.png?v={version}"


def as_reading(folder: Path, floor: Floor, grid: GridMap | None) -> SavedReading:
    """A floor that is not the one of a folder of `pianta read`."""
    return SavedReading(folder, floor, floor, grid=grid)


def describe_shapes(floor: Floor, grid: GridMap | None = None, address: str = "") -> dict[str, Any]:
    """The members of a floor's state that are its shapes and its picture. address: of the picture of a grid."""
    background = None if grid is None else {"url": address, "corners": corners_of(grid)}
    return {**describe_changes(as_reading(Path(), floor, grid)), "background": background}
