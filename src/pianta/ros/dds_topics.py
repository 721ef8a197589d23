"""Maps from a ROS 2 topic by DDS, without ROS installed: experimental."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

from pianta.errors import MapError, OptionError
from pianta.gridmap import GridMap
from pianta.io._files import MAX_CELLS, one_line_reason, short_repr
from pianta.io.grid_messages import MapBuilder

MAX_DOMAIN = 232  # of DDS, whose ports end there
LOOPBACK = (
    "<General><Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address='127.0.0.1'/></Peers></Discovery>"
)
NAMED = "<General><Interfaces><NetworkInterface name='{name}'/></Interfaces></General>"
_TOPIC = re.compile(r"^/?[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*$")
_INTERFACE = re.compile(r"^[A-Za-z0-9][A-Za-z0-9_.:@-]{0,63}$")
# Between two looks at Ctrl+C, seconds.
PATIENCE = 0.5


def check_topic(topic: str, interface: str | None, domain: int) -> None:
    """Raise OptionError for names that ROS and the system do not have, or if cyclonedds is not installed."""
    if not _TOPIC.match(topic):
        raise OptionError(f"topic is {short_repr(topic)}, give a name such as /map")
    if interface is not None and not _INTERFACE.match(interface):
        raise OptionError(f"interface is {short_repr(interface)}, give a name such as eth0")
    if not 0 <= domain <= MAX_DOMAIN:
        raise OptionError(f"domain is {domain}, give 0 to {MAX_DOMAIN}, as in ROS_DOMAIN_ID")
    if find_spec("cyclonedds") is None:
        raise OptionError("cyclonedds is not installed, install it with: pip install 'pianta[dds]'")


def iterate_topic(
    topic: str, *, interface: str | None = None, domain: int = 0, max_cells: int = MAX_CELLS
) -> Iterator[GridMap | MapError | None]:
    """The maps of a topic as they arrive, without end; the error of one that is damaged; None for each half second.

    interface: the name of the network interface; None for the loopback of this computer alone. domain: of ROS.

    Raises OptionError for impossible options, and MapError, in one line, if DDS cannot be started.
    """
    check_topic(topic, interface, domain)
    from cyclonedds.core import DDSException

    try:
        reader = _subscribe(topic, interface, domain)
    except DDSException as exception:
        where = f"interface {short_repr(interface)}" if interface else "the loopback"
        raise MapError(f"DDS cannot be started on {where}: {one_line_reason(exception)}") from None
    return _iterate_messages(reader, topic, max_cells)


def _subscribe(topic: str, interface: str | None, domain: int) -> Any:  # noqa: ANN401
    """A reader of the topic that gets the last map that was published, even before it started."""
    from cyclonedds.core import Policy, Qos
    from cyclonedds.domain import Domain, DomainParticipant
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic
    from cyclonedds.util import duration

    from pianta.ros.dds_messages import OccupancyGrid

    settings = LOOPBACK if interface is None else NAMED.format(name=interface)
    # It lives as long as the reader, which holds it
    started = Domain(domain, f"<CycloneDDS><Domain Id='any'>{settings}</Domain></CycloneDDS>")
    participant = DomainParticipant(domain)
    qos = Qos(
        Policy.Reliability.Reliable(max_blocking_time=duration(seconds=1)),
        Policy.Durability.TransientLocal,
        Policy.History.KeepLast(1),
    )
    # ROS 2 puts rt before the names of topics
    reader: Any = DataReader(participant, Topic(participant, "rt/" + topic.strip("/"), OccupancyGrid, qos=qos), qos=qos)
    reader.pianta_domain = started
    return reader


def _iterate_messages(reader: Any, topic: str, max_cells: int) -> Iterator[GridMap | MapError | None]:  # noqa: ANN401
    from cyclonedds.util import duration

    from pianta.ros.dds_messages import OccupancyGrid

    while True:
        arrived = False
        for message in reader.take_iter(timeout=duration(milliseconds=int(PATIENCE * 1000))):
            # Others say that a publisher is gone
            if isinstance(message, OccupancyGrid):
                arrived = True
                try:
                    yield MapBuilder.from_message(message, max_cells=max_cells).build(topic)
                except MapError as error:
                    yield MapError(f"topic {short_repr(topic)}: {error}")
        if not arrived:
            yield None
