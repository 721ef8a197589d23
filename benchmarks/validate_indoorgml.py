"""Validate the IndoorGML of real buildings by a schema.

    python benchmarks/validate_indoorgml.py indoorgmlcore.xsd

The schema is OGC's `indoorgml/1.0/indoorgmlcore.xsd`, version 1.0.3 or later, with the schema of GML 3.2.1 where it
imports it. It is not part of the project. Maps of the survey, homes of vacuums, IFC and DXF files are read, without
labels, and written; the first fault of each invalid file is printed, and the exit code is 1 if there is one.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from pathlib import Path
from tempfile import TemporaryDirectory

from lxml import etree

import pianta
from pianta.errors import PiantaError
from pianta_bench.data.folders import find_data

# Of the maps of the survey, metres per cell.
RESOLUTION = 0.05


def main() -> int:
    """Print how many files are valid."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("schema", type=Path)
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
    arguments = parser.parse_args()
    schema = etree.XMLSchema(etree.parse(arguments.schema))
    valid, faults = 0, []
    for path in _list_buildings(find_data(arguments.data)):
        try:
            reading = pianta.read(path, labels=False, resolution=RESOLUTION if path.suffix == ".png" else None)
        except PiantaError as error:
            print(f"not read: {error}")
            continue
        with TemporaryDirectory() as folder:
            target = Path(folder) / "building.gml"
            reading.to_file(target)
            is_valid = schema.validate(etree.parse(target))
        valid += is_valid
        faults += [] if is_valid else [f"{path.name}: {schema.error_log[0].message}"]
    print(*faults, f"{valid} of {valid + len(faults)} files are valid", sep="\n")
    return bool(faults)


def _list_buildings(data: Path) -> list[Path]:
    patterns = ("survey/*_scan.png", "vacuum/*.json", "planfiles/ifc/*.ifc", "planfiles/dxf/*.dxf")
    return [path for pattern in patterns for path in sorted(data.glob(pattern))]


if __name__ == "__main__":
    sys.exit(main())
