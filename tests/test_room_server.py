"""What a ROS node gives to others, without ROS; and the node itself with stand-ins for ROS."""

import importlib.util
import json
import re
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from defusedxml import ElementTree

import pianta
from pianta.ros.room_server import RoomServer

ROS2 = Path(__file__).parents[1] / "ros2"
NODE = ROS2 / "pianta_ros" / "pianta_ros" / "rooms_node.py"
MAX_NODE_LINES = 150


def make_message(grid: pianta.GridMap) -> Any:
    """A nav_msgs/OccupancyGrid, as far as it is read."""
    position = SimpleNamespace(x=grid.origin[0], y=grid.origin[1], z=0.0)
    origin = SimpleNamespace(position=position, orientation=SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0))
    height, width = grid.shape
    info = SimpleNamespace(resolution=grid.resolution, width=width, height=height, origin=origin)
    return SimpleNamespace(header="header", info=info, data=np.flipud(grid.cells).ravel())


@pytest.fixture(scope="module")
def world() -> tuple[pianta.Floor, pianta.GridMap]:
    return pianta.make_world("corridor")


@pytest.fixture(scope="module")
def server(world) -> RoomServer:
    room_server = RoomServer.make()
    assert room_server.update(make_message(world[1]))
    return room_server


class TestRoomServer:
    def test_it_reads_a_map_once(self, server, world):
        assert len(server.floor) == 19
        assert not server.update(make_message(world[1]))

    def test_ids_stay_when_the_map_changes(self, world):
        server = RoomServer.make(labels=False)
        grid = world[1]
        assert server.update(make_message(grid))
        before = {room.id: room.polygon for room in server.floor}
        cells = grid.cells.copy()
        cells[:, : grid.shape[1] // 2] = -1
        assert server.update(make_message(pianta.GridMap(cells, grid.resolution, grid.origin)))
        assert 5 <= len(server.floor) < len(before)
        for room in server.floor:
            if not room.partial:
                assert room.polygon.intersection(before[room.id]).area > 0.9 * room.polygon.area

    def test_a_map_that_cannot_be_read_changes_nothing(self, server):
        lines: list[str] = []
        floor = server.floor
        assert not server.update(make_message(pianta.GridMap(np.full((9, 9), -1), 0.05)), lines.append)
        (line,) = lines
        assert line.startswith("map 'map': ")
        assert server.floor is floor

    def test_the_room_of_a_position(self, server):
        for room in server.floor:
            inside = room.polygon.representative_point()
            assert server.find_room(inside.x, inside.y) == room

    def test_positions_beside_rooms(self):
        from shapely import box

        server = RoomServer.make(labels=False)
        floor = pianta.Floor((pianta.Room(1, box(0, 0, 2, 2)), pianta.Room(2, box(2.2, 0, 4, 2))))
        server.reading = SimpleNamespace(floor=floor)  # type: ignore[assignment]
        rooms = [server.find_room(x, 1.0) for x in (2.05, 2.15, -0.5, -0.51, float("nan"))]
        assert [room and room.id for room in rooms] == [1, 2, 1, None, None]

    def test_rooms_as_json(self, server):
        rooms = json.loads(server.list_rooms())
        assert [room["id"] for room in rooms] == [room.id for room in server.floor]
        assert rooms[0].keys() == {"id", "name", "label", "area", "x", "y"}
        same = server.find_room(rooms[3]["x"], rooms[3]["y"])
        assert same is not None
        assert same.id == rooms[3]["id"]

    def test_floor_as_geojson(self, server, tmp_path):
        (tmp_path / "floor.geojson").write_text(server.describe_floor(), encoding="utf-8")
        assert pianta.read_floor(tmp_path / "floor.geojson") == server.floor

    def test_labels_are_32_bits(self, server, world):
        image = server.label_image()
        assert image.dtype == np.int32
        assert image.shape == world[1].shape
        assert set(np.unique(image)) == {0, *(room.id for room in server.floor)}

    def test_markers(self, server):
        markers = server.list_markers()
        assert [marker.id for marker in markers] == [room.id for room in server.floor]
        first = markers[0]
        assert first.outline[0] == first.outline[-1]
        assert all(0 <= channel <= 1 for channel in first.color)
        assert first.text == server.floor[first.id].label

    def test_before_the_first_map(self):
        server = RoomServer.make(labels=False)
        assert (len(server.floor), server.list_rooms(), server.list_markers()) == (0, "[]", [])
        assert server.find_room(0, 0) is None
        assert server.label_image().size == 0
        with pytest.raises(pianta.PiantaError, match="no map has arrived"):
            _ = server.grid

    def test_an_unknown_type(self):
        with pytest.raises(pianta.PiantaError, match="castle"):
            RoomServer.make("castle")


class Recorder:
    """A publisher that keeps what is published."""

    def __init__(self) -> None:
        self.messages: list[Any] = []

    def publish(self, message: Any) -> None:
        self.messages.append(message)


class StandInNode:
    """rclpy.node.Node, as far as the node needs it."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.publishers: dict[str, Recorder] = {}
        self.services: dict[str, Any] = {}
        self.lines: list[str] = []

    def declare_parameter(self, name: str, value: Any) -> None:
        self.parameters = {name: value}

    def get_parameter(self, name: str) -> Any:
        return SimpleNamespace(value=self.parameters[name])

    def create_publisher(self, _: Any, topic: str, __: Any) -> Recorder:
        return self.publishers.setdefault(topic, Recorder())

    def create_subscription(self, _: Any, topic: str, callback: Any, __: Any) -> None:
        self.subscription = (topic, callback)

    def create_service(self, _: Any, name: str, callback: Any) -> None:
        self.services[name] = callback

    def get_logger(self) -> Any:
        return SimpleNamespace(info=self.lines.append, error=self.lines.append, warning=self.lines.append)


def make_message_type(**constants: Any) -> Any:
    """A type of messages whose fields spring into being, as nested namespaces."""

    class Message(SimpleNamespace):
        def __getattr__(self, name: str) -> Any:
            if name.startswith("__"):
                raise AttributeError(name)
            setattr(self, name, Message())
            return vars(self)[name]

    for name, value in constants.items():
        setattr(Message, name, value)
    return Message


@pytest.fixture
def node(monkeypatch):
    """The node, with stand-ins for ROS."""
    policies = SimpleNamespace(RELIABLE=1, TRANSIENT_LOCAL=1)
    marker = make_message_type(DELETEALL=3, LINE_STRIP=4, TEXT_VIEW_FACING=9, ADD=0)
    modules: dict[str, dict[str, Any]] = {
        "rclpy": {},
        "rclpy.node": {"Node": StandInNode},
        "rclpy.qos": {"DurabilityPolicy": policies, "QoSProfile": dict, "ReliabilityPolicy": policies},
        "geometry_msgs.msg": {"Point": make_message_type()},
        "nav_msgs.msg": {"OccupancyGrid": make_message_type()},
        "sensor_msgs.msg": {"Image": make_message_type()},
        "std_msgs.msg": {"String": make_message_type()},
        "visualization_msgs.msg": {"Marker": marker, "MarkerArray": make_message_type()},
        "pianta_interfaces.srv": {"ListRooms": make_message_type(), "RoomAt": make_message_type()},
    }
    for name, members in modules.items():
        parent = name.split(".", maxsplit=1)[0]
        if parent not in modules:
            monkeypatch.setitem(sys.modules, parent, ModuleType(parent))
        module = ModuleType(name)
        vars(module).update(members)
        monkeypatch.setitem(sys.modules, name, module)
    return load_node().RoomsNode()


def load_node() -> Any:
    spec = importlib.util.spec_from_file_location("rooms_node", NODE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class TestNode:
    def test_without_ros_there_is_one_line(self):
        with pytest.raises(SystemExit, match="pianta_ros needs ROS 2"):
            load_node()

    def test_a_map_becomes_rooms(self, node, world):
        topic, callback = node.subscription
        assert topic == "map"
        callback(make_message(world[1]))
        callback(make_message(world[1]))
        (floor,), (image,), (markers,) = (
            node.publishers[name].messages for name in ("~/floor", "~/room_ids", "~/markers")
        )
        assert len(json.loads(floor.data)["features"]) > 19
        assert (image.encoding, image.step, len(image.data)) == ("32SC1", 4 * 646, 4 * 646 * 334)
        # One that deletes the old ones, and a line and a text of each room
        assert len(markers.markers) == 1 + 2 * 19
        assert node.lines == ["19 rooms"]

    def test_services(self, node, world):
        node.subscription[1](make_message(world[1]))
        response = node.services["~/list_rooms"](None, SimpleNamespace())
        rooms = json.loads(response.rooms)
        request = SimpleNamespace(x=rooms[0]["x"], y=rooms[0]["y"])
        answer = node.services["~/room_at"](request, SimpleNamespace())
        assert (answer.found, answer.id, answer.label) == (True, rooms[0]["id"], rooms[0]["label"])
        assert not node.services["~/room_at"](SimpleNamespace(x=1e3, y=0.0), SimpleNamespace()).found

    def test_it_is_short_and_names_its_limits(self):
        text = NODE.read_text(encoding="utf-8")
        assert len(text.splitlines()) < MAX_NODE_LINES
        assert "Untested against a real ROS" in text


class TestPackages:
    @pytest.mark.parametrize("name", ["pianta_ros", "pianta_interfaces"])
    def test_versions_and_names_agree(self, name):
        package = ElementTree.parse(ROS2 / name / "package.xml").getroot()
        assert package.findtext("name") == name
        assert package.findtext("version") == pianta.__version__
        assert package.findtext("license") == "Apache-2.0"

    def test_setup_names_files_that_exist(self):
        folder = ROS2 / "pianta_ros"
        text = (folder / "setup.py").read_text(encoding="utf-8")
        assert (folder / "resource" / "pianta_ros").exists()
        assert (folder / "launch" / "rooms.launch.py").exists()
        assert re.search(r'version="([\d.]+)"', text).group(1) == pianta.__version__  # type: ignore[union-attr]

    def test_services_have_the_fields_that_the_node_uses(self):
        fields = re.findall(
            r"^(?:bool|\w+\d+|string) (\w+)$", (ROS2 / "pianta_interfaces" / "srv" / "RoomAt.srv").read_text(), re.M
        )
        assert fields == ["x", "y", "found", "id", "name", "label"]
