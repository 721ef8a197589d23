"""What is fuzzed: every reader of files, and the command line; and valid inputs that mutations start from."""

from __future__ import annotations

import shlex
import shutil
import warnings
from collections.abc import Callable, Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
from PIL import Image

import pianta
from pianta.cli import main
from pianta.corrections.corrections_file import read_corrections
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io.buildings.read import read_building
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.cloud_maps import read_cloud_map
from pianta.io.drawings.dxf import read_dxf_plan
from pianta.io.drawings.ifc import read_ifc_plan
from pianta.io.drawings.pdf import read_document
from pianta.io.drawings.svg import read_svg_plan
from pianta.io.drawings.sweethome3d import read_sweethome3d
from pianta.io.floors import read_floor
from pianta.io.georeference import read_georeference
from pianta.io.graphml import read_graphml
from pianta.io.graphs import read_graph, read_room_graphs
from pianta.io.images import read_picture
from pianta.io.label_schemas import read_label_schema, save_label_schema
from pianta.io.maps import read_map
from pianta.io.outlines import read_outline
from pianta.io.ros_maps import read_ros_map
from pianta.io.valetudo import read_valetudo_map
from pianta.io.writers.nav2_route import read_route_graph
from pianta.labels import SCHOOL
from pianta.relational.fact_files import read_interpretations, save_interpretations
from pianta.relational.interpretation import interpret_floor
from pianta.rooms.name_dictionary import read_room_name_dictionary

KTH = """<?xml version="1.0"?><floor BuildingName="0510" FloorName="2"><Domain name="KTH"/>
<Scale PixelDistance="100" RealDistance="5"/><space name="A" type="Kontor"><contour><centroid x="0" y="0"/>
<linesegment x1="0" y1="0" x2="100" y2="0" type="Wall" target=""/>
<linesegment x1="100" y1="0" x2="100" y2="80" type="Wall" target=""/>
<linesegment x1="100" y1="80" x2="60" y2="80" type="Wall" target=""/>
<linesegment x1="60" y1="80" x2="40" y2="80" type="Portal" target="K"/>
<linesegment x1="40" y1="80" x2="0" y2="80" type="Wall" target=""/>
<linesegment x1="0" y1="80" x2="0" y2="0" type="Wall" target=""/></contour></space></floor>"""
MIT = """<?xml version="1.0"?><MITquest><floor name="FLOORCONTOUR"><space name="1-A" type="OFF"><contour>
<centroid x="5" y="5"/><extent maxx="10" maxy="10" minx="0" miny="0"/><point x="0" y="0"/><point x="10" y="0"/>
<point x="10" y="10"/><point x="0" y="10"/></contour><portal class="horizontal" target="1-C"><edge minx="2" maxx="5"
miny="10" maxy="10"/></portal></space></floor></MITquest>"""
THESIS = (
    "<building><scale><represented_distance><value>9</value><um>pixel</um></represented_distance><real_distance>"
    "<value>90</value><um>cm</um></real_distance></scale><building_type><main_type>OFFICE</main_type></building_type>"
    '<floor><spaces><space id="a"><labels><type>R</type><label>OFFICE</label></labels><bounding_polygon>'
    '<point x="0" y="0"/><point x="40" y="0"/><point x="40" y="30"/><point x="0" y="30"/></bounding_polygon>'
    '<space_representation><linesegment id="p"><point x="40" y="15"/><point x="40" y="15"/><class>PORTAL</class>'
    "</linesegment></space_representation><portals><portal><linesegment>p</linesegment><type>EXPLICIT</type><target>"
    '<id>a</id><id>b</id></target></portal></portals></space><space id="b"><labels><type>R</type>'
    '<label>CORRIDOR</label></labels><bounding_polygon><point x="40" y="0"/><point x="99" y="0"/>'
    '<point x="99" y="30"/><point x="40" y="30"/></bounding_polygon></space></spaces></floor></building>'
)
HOUSE_EXPO = (
    '{"verts": [[0,0],[8,0],[8,4],[0,4]], "id": "1", "room_category": {"Bedroom": [[0,0,4,4]], "Kitchen": '
    '[[4,0,8,4]]}, "bbox": {"min": [0,0], "max": [8,4]}, "room_num": 2}'
)
VALETUDO = (
    '{"__class": "ValetudoMap", "metaData": {"version": 2}, "size": {"x": 5120, "y": 5120}, "pixelSize": 5, '
    '"layers": [{"__class": "MapLayer", "type": "floor", "pixels": [], "compressedPixels": [10,10,40,10,11,40], '
    '"metaData": {}}, {"type": "wall", "compressedPixels": [9,9,42]}, {"type": "segment", "metaData": '
    '{"segmentId": "1", "name": "Bath"}, "compressedPixels": [10,10,40]}], "entities": []}'
)
SVG = (
    "<svg xmlns='http://www.w3.org/2000/svg' width='90' height='90' viewBox='0 0 9 9'><style>.w {stroke: black}</style>"
    "<g id='walls' transform='translate(1 2) rotate(5)'><path class='w' d='M0 0H9V9Q3 4 2 1A3 3 0 0 1 5 5Z'/></g>"
    "<defs><rect id='r' width='2' height='3'/></defs><use href='#r' x='1'/><text x='2' y='3'>Bath</text></svg>"
)
OUTLINE = (
    '{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", '
    '"coordinates": [[[0, 0], [20, 0], [20, 9.5], [0, 9]], [[4, 4], [9, 4], [9, 8], [4, 8]]]}}]}'
)
GEOREFERENCE = """crs: EPSG:32632
points:
  - {map: [0, 0], world: [500000, 5000000]}
  - {map: [10, 0], world: [500000, 5000020]}
  - {map: [0, 5], world: [499990, 5000000]}
"""
ROOM_GRAPHS = (
    '{"building_type": "SCHOOL", "source": "thesis", "graphs": [{"id": "g", "nodes": [{"id": 0, "code": 3, "label": '
    '"Classroom"}, {"id": 1, "code": 10, "label": "MEDIUM SERVICE"}], "edges": [[0, 1]]}]}'
)
WORDS_OF_ROOMS = (
    '{"format": "pianta room words", "version": "1.0", "kinds": [{"function": "SERVICE", "words": {"en": ["wc"]}}]}'
)
PDF = (
    b"%PDF-1.4\n1 0 obj<</Type/Catalog/Pages 2 0 R>>endobj 2 0 obj<</Type/Pages/Kids[3 0 R]/Count 1>>endobj\n"
    b"3 0 obj<</Type/Page/Parent 2 0 R/MediaBox[0 0 200 200]/Contents 4 0 R/Resources<</Font<</F 5 0 R>>>>>>endobj\n"
    b"4 0 obj<</Length 120>>stream\n1 w 10 10 m 90 10 l 90 90 l 10 90 l s 20 20 50 50 re S BT /F 9 Tf 30 30 Td (Bath "
    b"1:100) Tj ET 0 g 5 5 m 9 9 1 2 3 4 c f\nendstream endobj\n5 0 obj<</Type/Font/Subtype/Type1/BaseFont/Helvetica>>"
    b"endobj\ntrailer<</Root 1 0 R>>"
)
COMMANDS = (
    "read map.npz -o out",
    "read map.npz -o out --json j.json --walls --no-labels --method thesis",
    "read map.yaml -o out --resolution 0.05 --type school --previous floor.geojson",
    "read . -o out --jobs 1 --shard 1/2 --retry-failed",
    "read plan.svg -o out --as plan --page 1 --max-cells 1000",
    "read map.npz map.yaml -o out --storey 0:0 --storey 1:3 --stairs 1:2",
    "collect out",
    "correct read --name 1 Bath --undo",
    "correct read --merge 1 2 --split 1 0,0 1,1 --label 1 OFFICE",
    "convert read --to svg -o f.svg",
    "convert read --to dxf --straight -o f.dxf",
    "score read floor.geojson --align",
    "realism floor.geojson --type office",
    "patterns floor.geojson --no-labels",
    "evacuate floor.geojson --exit 1 -o out",
    "world home -o out --seed 3 --noise 0.5",
    "explore map.yaml --stop 0.1 --animation none --max-distance 3",
    "explore corridor --policy gain --robots 2 --max-distance 3 --steps 0",
    "view read --html v.html",
    "generate model.json -n 1 -o out",
    "predict floor.geojson model.json -n 1 -o out",
    "train --help",
    "bench cost --help",
    "--version",
)
_PLAIN_WORDS = "-1 0 1 2 nan inf 1e300 -0 00 . .. / /dev/null floor.geojson map.npz map.yaml plan.svg read all none"
_ODD_WORDS = "'' ' ' 1/2 3/2 0/0 a/b 1,2 1,, :: 1:2 é \x1b[31m [red] [/x] {} %s * ** ~ http://x file:///etc/passwd --"
WORDS = (*_PLAIN_WORDS.split(), *_ODD_WORDS.split())
MAX_WORDS = 25
# Which would wait for a person, a robot or an hour
LEFT_OUT = frozenset({"watch", "view", "bench", "train"})


@dataclass(frozen=True)
class Target:
    """A reader, or the command line.

    suffix: of the file that gets the input. read: called with the file. seeds: valid inputs.
    """

    suffix: str
    read: Callable[[Path], Any]
    seeds: tuple[bytes, ...]


def list_targets(folder: Path) -> Mapping[str, Target]:
    """All targets; folder: empty, for what seeds are made from and commands find."""
    floor, grid = pianta.make_world("corridor")
    small = GridMap(grid.cells[::4, ::4], 0.2, grid.origin, "map.npz")
    small.save(folder / "map.npz")
    small.save(folder / "map.yaml")
    floor.save(folder / "floor.geojson")
    (folder / "plan.svg").write_text(SVG, encoding="utf-8")
    saved = _convert_all(floor, folder)

    def seeds(*names: str) -> tuple[bytes, ...]:
        return tuple(saved[name] for name in names if name in saved)

    texts = {
        "kth": (".xml", KTH),
        "mit": (".xml", MIT),
        "house_expo": (".json", HOUSE_EXPO),
    }
    buildings = {name: Target(suffix, read_building, (text.encode(),)) for name, (suffix, text) in texts.items()}
    picture = saved["map.png"]
    inputs = frozenset(path.name for path in folder.iterdir())
    return {
        **buildings,
        "floor": Target(".geojson", read_floor, seeds("floor.geojson")),
        "outline": Target(".geojson", read_outline, (OUTLINE.encode(),)),
        "thesis_xml": Target(".xml", read_building_xml, (THESIS.encode(),)),
        "map_yaml": Target(".yaml", _with_image(read_ros_map, picture), seeds("map.yaml")),
        "npz": Target(".npz", read_map, seeds("map.npz")),
        "png": Target(".png", read_picture, (picture,)),
        "pgm": Target(".pgm", read_picture, (b"P5 3 2 255\n\x00\x80\xff\x00\x80\xff", b"P2 2 1 9\n3 4\n")),
        "valetudo": Target(".json", read_valetudo_map, (VALETUDO.encode(),)),
        "svg": Target(".svg", read_svg_plan, (SVG.encode(), *seeds("floor.svg"))),
        "dxf": Target(".dxf", read_dxf_plan, seeds("floor.dxf")),
        "ifc": Target(".ifc", read_ifc_plan, seeds("building.ifc")),
        "pdf": Target(".pdf", read_document, (PDF,)),
        "sh3d": Target(".sh3d", read_sweethome3d, seeds("building.sh3d")),
        "graph": Target(".json", read_graph, seeds("graph.json")),
        "room_graphs": Target(".json", read_room_graphs, (ROOM_GRAPHS.encode(),)),
        "graphml": Target(".graphml", read_graphml, seeds("graph.graphml")),
        "route_graph": Target(".geojson", read_route_graph, seeds("route_graph.geojson")),
        "georeference": Target(".yaml", read_georeference, (GEOREFERENCE.encode(),)),
        "label_schema": Target(".yaml", read_label_schema, seeds("schema.yaml")),
        "words": Target(".json", read_room_name_dictionary, (WORDS_OF_ROOMS.encode(),)),
        "corrections": Target(".json", read_corrections, seeds("corrections.json")),
        "facts": Target(".pl", read_interpretations, seeds("facts.pl")),
        "pcd": Target(".pcd", read_cloud_map, (_make_pcd(),)),
        "commands": Target(".txt", _RunCommand(folder, inputs), tuple(command.encode() for command in COMMANDS)),
    }


def _convert_all(floor: Floor, folder: Path) -> dict[str, bytes]:
    """The content of files in many formats, by name."""
    saved = {name: (folder / name).read_bytes() for name in ("map.npz", "map.yaml", "floor.geojson")}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        reading = pianta.read(folder / "map.npz")
        reading.save(folder / "read")
        for name, wanted in (("svg", "floor.svg"), ("dxf", "floor.dxf"), ("ifc", "building.ifc"),
                             ("sweethome3d", "building.sh3d"), ("nav2-route", "route_graph.geojson")):  # fmt: skip
            pianta.convert(folder / "read", folder / wanted, to=name)
            saved[wanted] = (folder / wanted).read_bytes()
    save_label_schema(SCHOOL, folder / "schema.yaml")
    save_interpretations(folder / "facts.pl", [interpret_floor(floor)])
    for name in ("schema.yaml", "facts.pl"):
        saved[name] = (folder / name).read_bytes()
    main_quietly(["correct", str(folder / "read"), "--name", "1", "Bath"])
    for path in (folder / "read").iterdir():
        saved.setdefault(path.name, path.read_bytes())
    nx.write_graphml(nx.Graph([(1, 2)]), folder / "graph.graphml")
    saved["graph.graphml"] = (folder / "graph.graphml").read_bytes()
    Image.fromarray(np.full((6, 5), 254, np.uint8)).save(folder / "image.png")
    saved["map.png"] = (folder / "image.png").read_bytes()
    return saved


def _with_image(read: Callable[[Path], Any], image: bytes) -> Callable[[Path], Any]:
    """A reader of YAML beside which the image lies that it names."""

    def read_beside(path: Path) -> Any:  # noqa: ANN401  # as the reader
        for name in ("map.png", "map.pgm"):
            path.with_name(name).write_bytes(image)
        return read(path)

    return read_beside


def _make_pcd() -> bytes:
    """A cloud of points: floor, ceiling and walls of a room of 2 m × 1 m, dense enough for their heights."""
    x, y = (each.ravel() for each in np.meshgrid(np.arange(0, 2, 0.08), np.arange(0, 1, 0.08)))
    along, up = (each.ravel() for each in np.meshgrid(np.arange(0, 2, 0.08), np.arange(0, 2.4, 0.08)))
    planes = [np.column_stack([x, y, np.full(len(x), height)]) for height in (0.0, 2.4)]
    planes += [np.column_stack([along, np.full(len(along), across), up]) for across in (-0.03, 1.03)]
    planes += [np.column_stack([np.full(len(along), across), along / 2, up]) for across in (-0.03, 2.03)]
    points = np.concatenate(planes)
    head = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
    head += f"WIDTH {len(points)}\nHEIGHT 1\nPOINTS {len(points)}\nDATA ascii\n"
    return (head + "\n".join(f"{a:.2f} {b:.2f} {c:.2f}" for a, b, c in points)).encode()


@dataclass(frozen=True)
class _RunCommand:
    """Runs the words of a file as a command in a folder with small inputs; bytes above 127 stand for WORDS.

    What a command writes is removed: a later one may read all files of the folder. inputs: the names in it.
    """

    folder: Path
    inputs: frozenset[str]

    def __call__(self, path: Path) -> None:
        content = path.read_bytes()[:2000]
        text = "".join(f" {WORDS[byte % len(WORDS)]} " if byte > 127 else chr(byte) for byte in content)
        try:
            words = shlex.split(text.replace("\0", ""))[:MAX_WORDS]
        except ValueError:
            return
        if not words or words[0] in LEFT_OUT:
            return
        try:
            code = main_quietly(words)
        finally:
            self._remove_results()
        if code not in (0, 1, 2, None):
            raise AssertionError(f"exit code {code}")

    def _remove_results(self) -> None:
        for path in self.folder.iterdir():
            if path.name in self.inputs or path.name.startswith(("input", "last_input")):
                continue
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)


def main_quietly(words: list[str]) -> Any:  # noqa: ANN401  # a code
    """The exit code of a command; its exceptions are raised."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        try:
            main(words)
        except SystemExit as end:
            return end.code
    return 0
