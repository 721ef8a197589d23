"""Maps from rosbags: the nav_msgs/OccupancyGrid messages of a topic, with their updates.

Messages are read one after another and never held together, so that memory does not grow with the bag.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from pianta.errors import MapError, MapWarning, OptionError
from pianta.gridmap import GridMap
from pianta.io._bag_limits import check_metadata, limit_unpacking
from pianta.io._files import MAX_CELLS, check_input_file, count_noun, one_line_reason, short_repr
from pianta.io.grid_messages import MapBuilder

if TYPE_CHECKING:
    from rosbags.interfaces import Connection
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2
    from rosbags.typesys.store import Typestore

BAG_SUFFIXES = (".bag", ".mcap", ".db3")
METADATA_FILE = "metadata.yaml"
GRID_TYPE = "nav_msgs/msg/OccupancyGrid"
UPDATE_TYPE = "map_msgs/msg/OccupancyGridUpdate"
UPDATE_DEFINITION = "std_msgs/Header header\nint32 x\nint32 y\nuint32 width\nuint32 height\nint8[] data\n"
UPDATE_SUFFIX = "_updates"
MAX_LISTED = 10  # topics in a message

# "last", or the number of a message of the topic, from 1.
Message: TypeAlias = int | Literal["last"]


def check_message(message: object) -> None:
    """Raise OptionError unless a message is "last" or a number from 1."""
    is_number = isinstance(message, int) and not isinstance(message, bool) and message >= 1
    if not (is_number or message == "last"):
        raise OptionError(f"message is {short_repr(message)}, give 'last' or a number from 1")


def is_bag(path: str | Path) -> bool:
    """Whether a path is that of a bag: by its suffix, a folder by its metadata.yaml."""
    try:
        return Path(path).suffix.lower() in BAG_SUFFIXES or (Path(path) / METADATA_FILE).is_file()
    except (OSError, ValueError):
        return False


def read_bag(
    path: str | Path, *, topic: str | None = None, message: Message = "last", max_cells: int = MAX_CELLS
) -> GridMap:
    """A map of a bag: the last or the n-th grid of a topic, with the updates that follow it.

    path: a ROS 1 .bag, a .mcap, a .db3, or the folder of a ROS 2 bag. topic: None for the only one with grids.

    Raises MapError, in one line, for a damaged bag, for one without grids or without this message, and OptionError if
    several topics have grids or rosbags is not installed.
    """
    newest = None
    for each in _iterate_grids(path, topic, max_cells, message):
        newest = each
    if newest is None:
        raise MapError(f"bag {short_repr(path)} has the topic and no message of it, give another bag")
    if message not in ("last", newest.number):
        raise MapError(
            f"bag {short_repr(path)} has {count_noun(newest.number, 'map')}, not {message}; "
            f"give message= up to {newest.number}"
        )
    return newest.build(Path(path).name)


def iterate_bag(
    path: str | Path, *, topic: str | None = None, max_cells: int = MAX_CELLS
) -> Iterator[GridMap | MapError]:
    """All maps of a topic in the order of their time, as of read_bag; those equal to the one before are left out.

    A map that is damaged or too large is given as the error, so that those after it can be read.
    """
    last = None
    for unread in _iterate_grids(path, topic, max_cells, "all"):
        try:
            grid = unread.build(Path(path).name)
        except MapError as error:
            yield error
            continue
        if last is None or not is_same_map(grid, last):
            yield grid
        last = grid


def is_same_map(one: GridMap, other: GridMap) -> bool:
    """Whether two maps have the same cells at the same position."""
    frames = [(each.shape, each.resolution, each.origin) for each in (one, other)]
    return frames[0] == frames[1] and bool((one.cells == other.cells).all())


@dataclass
class _Grid:
    """A grid of a bag, decoded when it is needed; and how many of its updates did not lie on it."""

    bag: _Bag
    raw: bytes
    number: int
    builder: MapBuilder | None = None
    stray: int = 0

    def decode(self) -> MapBuilder:
        """The map of the message; raises MapError."""
        if self.builder is None:
            try:
                message = self.bag.decode(self.raw, GRID_TYPE)
                self.builder = MapBuilder.from_message(message, max_cells=self.bag.max_cells)
            except MapError as error:
                raise MapError(f"bag {short_repr(self.bag.path)}: map {self.number}: {error}") from None
            self.raw = b""
        return self.builder

    def update(self, raw: bytes) -> None:
        """Apply an update; one that is not on the map is counted."""
        try:
            self.decode().update(self.bag.decode(raw, UPDATE_TYPE))
        except MapError:
            self.stray += 1

    def build(self, source: str) -> GridMap:
        """The map; warns of updates that are not on it."""
        builder = self.decode()
        if self.stray:
            warnings.warn(
                f"bag {short_repr(self.bag.path)}: {count_noun(self.stray, 'update')} of map {self.number} left out, "
                "which are not on it or damaged",
                MapWarning,
                stacklevel=3,
            )
        return builder.build(source)


def _iterate_grids(
    path: str | Path, topic: str | None, max_cells: int, message: Message | Literal["all"]
) -> Iterator[_Grid]:
    """Each grid once all its updates are applied, where it is the message that is asked for."""
    with _open_bag(path, max_cells) as bag:
        chosen = bag.choose_topic(topic)
        grid, number = None, 0
        for message_type, raw in bag.iterate(chosen):
            if message_type == GRID_TYPE:
                if grid is not None:
                    yield grid
                if number == message:
                    return
                number += 1
                grid = _Grid(bag, raw, number)
            elif grid is not None and (message in ("last", "all") or number == message):
                grid.update(raw)
        if grid is not None:
            yield grid


@dataclass
class _Bag:
    """An open bag. types: of the messages. is_ros1: how they are encoded."""

    path: Path
    reader: Reader1 | Reader2
    types: Typestore
    is_ros1: bool
    max_cells: int

    def choose_topic(self, topic: str | None) -> str:
        """The topic that is given, or the only one with grids; raises OptionError or MapError, which list them."""
        grids = sorted({each.topic for each in self.reader.connections if each.msgtype == GRID_TYPE})
        name = f"bag {short_repr(self.path)}"
        if not grids:
            others = sorted({f"{each.topic} ({each.msgtype})" for each in self.reader.connections})
            raise MapError(f"{name} has no topic with nav_msgs/OccupancyGrid; it has {_list_names(others)}")
        if topic is None and len(grids) > 1:
            raise OptionError(f"{name} has {len(grids)} topics with maps, give topic= one of {_list_names(grids)}")
        for each in grids:
            if topic is None or each.strip("/") == topic.strip("/"):
                return each
        raise OptionError(f"{name} has no map on topic {short_repr(topic)}, give one of {_list_names(grids)}")

    def iterate(self, topic: str) -> Iterator[tuple[str, bytes]]:
        """The type and the bytes of each grid of a topic and of each update, in the order of their time."""
        chosen: list[Connection] = [
            each
            for each in self.reader.connections
            if (each.topic, each.msgtype) in {(topic, GRID_TYPE), (topic + UPDATE_SUFFIX, UPDATE_TYPE)}
        ]
        for connection, _, raw in self.reader.messages(chosen):
            yield connection.msgtype, raw

    def decode(self, raw: bytes, message_type: str) -> Any:  # noqa: ANN401
        """The message; raises MapError if its bytes are not of its type."""
        decode = self.types.deserialize_ros1 if self.is_ros1 else self.types.deserialize_cdr
        try:
            return decode(raw, message_type)
        # rosbags raises various exceptions for hostile bytes.
        except Exception as exception:
            raise MapError(f"the message is damaged: {one_line_reason(exception)}") from None


@contextmanager
def _open_bag(path: str | Path, max_cells: int) -> Iterator[_Bag]:
    """An open bag; whatever fails in the block becomes a MapError of one line."""
    check_installed()
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    is_folder = (Path(path) / METADATA_FILE).is_file()
    file = Path(path) if is_folder else check_input_file(path, "bag", MapError)
    is_ros1 = not is_folder and file.suffix.lower() == ".bag"
    types = get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.ROS2_HUMBLE)
    types.register(get_types_from_msg(UPDATE_DEFINITION, UPDATE_TYPE))
    if is_folder:
        check_metadata(file / METADATA_FILE)
    limit_unpacking()
    try:
        with Reader1(file) if is_ros1 else Reader2(file) as reader:
            yield _Bag(file, reader, types, is_ros1, max_cells)
    except (MapError, OptionError):
        raise
    # rosbags, sqlite3, struct and the decompressors raise various exceptions for damaged files.
    except Exception as exception:
        tool = "rosbag reindex" if is_ros1 else "ros2 bag reindex, or mcap recover"
        reason = one_line_reason(exception)
        raise MapError(
            f"bag {short_repr(path)} is damaged or was cut off: {reason}; repair it by {tool}"
        ) from exception


def check_installed() -> None:
    """Raise OptionError unless rosbags is installed."""
    if find_spec("rosbags") is None:
        raise OptionError("rosbags is not installed, install it with: pip install 'pianta[ros]'")


def _list_names(names: list[str]) -> str:
    more = f" and {len(names) - MAX_LISTED} more" if len(names) > MAX_LISTED else ""
    return (", ".join(names[:MAX_LISTED]) or "no topic") + more
