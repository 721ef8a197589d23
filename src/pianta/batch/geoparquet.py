"""GeoParquet tables that are written in row groups, so that memory does not grow with them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pianta.errors import OptionError

if TYPE_CHECKING:
    from pyarrow.parquet import ParquetWriter

ROW_GROUP = 20_000  # rows that are held at once
Row = dict[str, Any]
# Columns of each table besides the geometry, with the types that pandas gives them also where all values are missing
COLUMNS: Mapping[str, Mapping[str, str]] = {
    "buildings": {
        "building": "string",
        "storey": "string",
        "file": "string",
        "building_type": "string",
        "probability": "float64",
        "rooms": "int64",
        "doors": "int64",
        "area": "float64",
        "area_trust": "string",
        "seconds": "float64",
        "version": "string",
    },
    "rooms": {
        "building": "string",
        "storey": "string",
        "id": "int64",
        "number": "string",
        "name": "string",
        "label": "string",
        "label_probability": "float64",
        "area": "float64",
        "partial": "bool",
        "probability": "float64",
        "flag": "string",
        "global_id": "string",
    },
    "doors": {
        "building": "string",
        "storey": "string",
        "room": "int64",
        "other_room": "Int64",
        "width": "float64",
        "kind": "string",
        "probability": "float64",
        "global_id": "string",
    },
}
TABLES = tuple(COLUMNS)
METADATA = b"geo"  # the key of what GeoParquet says of geometries, by version 1.1.0 of its specification


@dataclass
class TableWriter:
    """Writes the rows of a table, one of TABLES.

    writer: None before the first row group. geo: the metadata of the geometries that were written.
    """

    table: str
    file: Path
    rows: list[Row] = field(default_factory=list)
    writer: ParquetWriter | None = None
    geo: dict[str, Any] = field(default_factory=dict)

    def write(self, rows: Iterable[Row]) -> None:
        """Add rows."""
        self.rows += rows
        if len(self.rows) >= ROW_GROUP:
            self.flush()

    def flush(self) -> None:
        """Write the rows that are held."""
        from geopandas import GeoDataFrame
        from pyarrow import parquet

        columns = COLUMNS[self.table]
        frame = GeoDataFrame(self.rows, columns=[*columns, "geometry"], geometry="geometry").astype(dict(columns))
        buffer = BytesIO()
        frame.to_parquet(buffer, index=False)
        # With threads, as of parquet.read_table, pyarrow 26 often aborts the process when it ends
        group = parquet.ParquetFile(buffer).read(use_threads=False)
        metadata = dict(group.schema.metadata)
        self.geo = _join_metadata(self.geo, json.loads(metadata.pop(METADATA)))
        group = group.replace_schema_metadata(metadata)
        if self.writer is None:
            self.writer = parquet.ParquetWriter(self.file, group.schema, compression="snappy")
        self.writer.write_table(group)
        self.rows = []

    def close(self) -> None:
        """Write what is left, and what all geometries are."""
        if self.rows or self.writer is None:
            self.flush()
        if self.writer is not None:
            self.writer.add_key_value_metadata({METADATA: json.dumps(self.geo).encode()})
            self.writer.close()


@contextmanager
def open_table(table: str, file: Path) -> Iterator[TableWriter]:
    """What writes a table into a file; raises OptionError if geopandas is not installed."""
    try:
        import geopandas  # noqa: F401
    except ImportError:
        raise OptionError("geopandas is not installed, install it with: pip install 'pianta[geo]'") from None
    writer = TableWriter(table, file)
    try:
        yield writer
        writer.close()
    finally:
        if writer.writer is not None:
            writer.writer.close()


def _join_metadata(one: Mapping[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """The metadata of two row groups: kinds of geometries and the box around all."""
    if not one:
        return other
    first, second = one["columns"]["geometry"], other["columns"]["geometry"]
    kinds = sorted({*first["geometry_types"], *second["geometry_types"]})
    boxes = [each["bbox"] for each in (first, second) if "bbox" in each]
    joined = {**second, "geometry_types": kinds}
    if boxes:
        joined["bbox"] = [*(min(box[axis] for box in boxes) for axis in (0, 1))]
        joined["bbox"] += [*(max(box[axis] for box in boxes) for axis in (2, 3))]
    return {**other, "columns": {**other["columns"], "geometry": joined}}
