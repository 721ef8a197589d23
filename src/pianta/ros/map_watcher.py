"""MapWatcher: reads a map again when it has changed, keeps the ids of its rooms, and writes its folder."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Unpack

from pianta.gridmap import GridMap
from pianta.io.bags import is_same_map
from pianta.io.graphs import FLOOR_FILE
from pianta.reading._reader import Reader, ReadOptions, open_corrected, read_previous
from pianta.reading.reading import Reading


@dataclass
class MapWatcher:
    """What is done with each map that arrives.

    reader: the options of reading. out: the folder for the results; a floor in it is the previous one, also one of an
    earlier run. source: where the maps come from, for messages.
    """

    reader: Reader
    out: Path
    source: str
    last: GridMap | None = field(default=None, init=False)

    @classmethod
    def make(cls, out: str | Path, source: str, **options: Unpack[ReadOptions]) -> MapWatcher:
        """A watcher with checked options, as of `read`; raises PiantaError."""
        return cls(Reader.make(**options), Path(out), source)

    def update(self, grid: GridMap) -> Reading | None:
        """The building of a map, once its folder is written; None for a map like the last one.

        Raises PiantaError for a map that cannot be read, such as one without rooms; the next one may be.
        """
        if self.last is not None and is_same_map(grid, self.last):
            return None
        self.last = grid
        reader = self.reader
        if (self.out / FLOOR_FILE).is_file():
            # What people have corrected meanwhile stays
            reader = replace(reader, previous=read_previous(self.out), corrected=open_corrected(self.out))
        reading = reader.read_grid(grid, self.source)
        reading.save(self.out)
        return replace(reading, folder=self.out)
