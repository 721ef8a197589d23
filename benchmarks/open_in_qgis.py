"""Open a converted floor in QGIS: what layers, fields and coordinate systems it finds, and a picture of the rooms.

Run it with the Python of QGIS, which is that of the system on Debian and Ubuntu, on a folder in which `pianta convert`
has written files:

    /usr/bin/python3 benchmarks/open_in_qgis.py building --picture rooms.png
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from pathlib import Path

try:
    from osgeo import ogr
    from qgis.core import (
        Qgis,
        QgsApplication,
        QgsCategorizedSymbolRenderer,
        QgsFillSymbol,
        QgsMapRendererParallelJob,
        QgsMapSettings,
        QgsPalLayerSettings,
        QgsRendererCategory,
        QgsVectorLayer,
        QgsVectorLayerSimpleLabeling,
        QgsWkbTypes,
    )
    from qgis.PyQt.QtCore import QSize
except ImportError:
    sys.exit("QGIS has no module here, run this with the Python of QGIS, such as /usr/bin/python3")

SUFFIXES = {".gpkg", ".geojson", ".gml", ".dxf", ".osm", ".parquet"}
SEPARATOR = "!!::!!"  # between the parts of the description of a layer, in QGIS
COLORS = ("#8dd3c7", "#fdb462", "#bebada", "#80b1d3", "#fb8072", "#b3de69", "#fccde5", "#d9d9d9")
PICTURE = QSize(1200, 1000)  # pixels
MARGIN = 1.05


def main() -> int:
    """Print a line for each layer; exit code 1 if a file is not opened, or has an invalid layer or geometry."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--picture", type=Path, help="PNG of the rooms of floor.gpkg, by label")
    arguments = parser.parse_args()
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    application = QgsApplication([], False)  # noqa: FBT003 - of QGIS
    application.initQgis()
    print(f"QGIS {Qgis.QGIS_VERSION}")
    files = sorted(file for file in arguments.folder.rglob("*") if file.suffix in SUFFIXES)
    is_good = True
    if ogr.GetDriverByName("Parquet") is None:
        print("GDAL has no driver of GeoParquet here, left out")
        files = [file for file in files if file.suffix != ".parquet"]
    for file in files:
        layers = [*list_layers(file)]
        print(
            "\n".join(
                [describe(file.relative_to(arguments.folder), layer) for layer in layers] or [f"{file}: NOT OPENED"]
            )
        )
        is_good &= bool(layers) and all(layer.isValid() and not count_invalid(layer) for layer in layers)
    if arguments.picture:
        draw_rooms(arguments.folder / "floor.gpkg", arguments.picture)
    return 0 if is_good else 1


def list_layers(file: Path) -> Iterator[QgsVectorLayer]:
    """The layers of a file that QGIS would offer, those without features left out."""
    opened = QgsVectorLayer(str(file), file.stem, "ogr")
    parts = [part.split(SEPARATOR) for part in opened.dataProvider().subLayers()] if opened.isValid() else []
    for _, name, _, geometry, *_ in parts:
        layer = QgsVectorLayer(f"{file}|layername={name}|geometrytype={geometry}", name, "ogr")
        if next(layer.getFeatures(), None) is not None:
            yield layer


def describe(file: Path, layer: QgsVectorLayer) -> str:
    """File, layer, number and type of its features, coordinate system and fields, on one line."""
    geometry = QgsWkbTypes.displayString(layer.wkbType())
    crs = layer.crs().authid() or layer.crs().description() or "no coordinate system"
    fields = ", ".join(field.name() for field in layer.fields())
    count = sum(1 for _ in layer.getFeatures())
    invalid = count_invalid(layer)
    faults = f"; {invalid} INVALID" if invalid else ""
    return f"{file} {layer.name()}: {count} {geometry}{faults}; {crs}; {fields}"


def count_invalid(layer: QgsVectorLayer) -> int:
    """How many geometries GEOS calls invalid."""
    return sum(not feature.geometry().isGeosValid() for feature in layer.getFeatures())


def draw_rooms(file: Path, picture: Path) -> None:
    """The layer of rooms by label, with ids, as a PNG."""
    rooms = QgsVectorLayer(f"{file}|layername=rooms", "rooms", "ogr")
    labels = sorted({feature["label"] or "" for feature in rooms.getFeatures()})
    categories = [
        QgsRendererCategory(label, QgsFillSymbol.createSimple({"color": COLORS[index % len(COLORS)]}), label)
        for index, label in enumerate(labels)
    ]
    rooms.setRenderer(QgsCategorizedSymbolRenderer("label", categories))
    text = QgsPalLayerSettings()
    text.fieldName = "coalesce(name, to_string(room)) || '\n' || round(area, 1) || ' m²'"
    text.isExpression = True
    # Inside of rooms that are bent
    text.placement = QgsPalLayerSettings.Horizontal
    rooms.setLabeling(QgsVectorLayerSimpleLabeling(text))
    rooms.setLabelsEnabled(True)
    settings = QgsMapSettings()
    walls = QgsVectorLayer(f"{file}|layername=walls", "walls", "ogr")
    doors = QgsVectorLayer(f"{file}|layername=doors", "doors", "ogr")
    settings.setLayers([layer for layer in (doors, walls, rooms) if layer.isValid()])
    settings.setDestinationCrs(rooms.crs())
    extent = rooms.extent()
    extent.scale(MARGIN)
    settings.setExtent(extent)
    settings.setOutputSize(PICTURE)
    job = QgsMapRendererParallelJob(settings)
    job.start()
    job.waitForFinished()
    job.renderedImage().save(str(picture))


if __name__ == "__main__":
    sys.exit(main())
