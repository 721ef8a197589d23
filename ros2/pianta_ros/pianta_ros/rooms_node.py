"""The node `rooms`: a map in; out the rooms as GeoJSON, as an image of ids and as markers, and two services.

Untested against a real ROS: the tests of pianta run it with stand-ins for rclpy and the messages. What it answers is
computed by pianta.ros.room_server, which is tested. It needs ROS 2 Humble or newer, and pianta from pip.
"""

from __future__ import annotations

import sys

from pianta.ros.room_server import RoomMarker, RoomServer

try:
    import rclpy
    from geometry_msgs.msg import Point
    from nav_msgs.msg import OccupancyGrid
    from rclpy.node import Node
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
    from sensor_msgs.msg import Image
    from std_msgs.msg import String
    from visualization_msgs.msg import Marker, MarkerArray
except ImportError as exception:
    sys.exit(f"pianta_ros needs ROS 2, source its setup.bash first: {exception}")

try:
    from pianta_interfaces.srv import ListRooms, RoomAt
except ImportError:  # the package of the services is not built: the topics are enough for many
    ListRooms = RoomAt = None

# Published once, and given to those who come later, as maps are.
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
LINE_WIDTH, TEXT_HEIGHT = 0.05, 0.4  # metres


class RoomsNode(Node):
    """Reads each map that differs from the last one; rooms keep their ids."""

    def __init__(self) -> None:
        super().__init__("pianta_rooms")
        self.declare_parameter("building_type", "")
        self.server = RoomServer.make(self.get_parameter("building_type").value)
        self.floors = self.create_publisher(String, "~/floor", LATCHED)
        self.images = self.create_publisher(Image, "~/room_ids", LATCHED)
        self.markers = self.create_publisher(MarkerArray, "~/markers", LATCHED)
        self.create_subscription(OccupancyGrid, "map", self.read_map, LATCHED)
        if RoomAt is None:
            self.get_logger().warning("pianta_interfaces is not built, there are no services")
        else:
            self.create_service(RoomAt, "~/room_at", self.answer_room_at)
            self.create_service(ListRooms, "~/list_rooms", self.answer_list_rooms)

    def read_map(self, message: OccupancyGrid) -> None:
        """Read a map and publish its rooms, if it differs from the last one."""
        if not self.server.update(message, self.get_logger().error):
            return
        self.floors.publish(String(data=self.server.describe_floor()))
        self.images.publish(self.make_image(message))
        markers = [Marker(action=Marker.DELETEALL)]
        for marker in self.server.list_markers():
            markers += self.make_markers(marker, message)
        self.markers.publish(MarkerArray(markers=markers))
        self.get_logger().info(f"{len(self.server.floor)} rooms")

    def make_image(self, message: OccupancyGrid) -> Image:
        """The ids of rooms on the cells of the map, its first row at the top."""
        ids = self.server.label_image()
        height, width = ids.shape
        image = Image(height=height, width=width, encoding="32SC1", step=4 * width)
        image.is_bigendian = int(sys.byteorder == "big")
        image.header = message.header
        image.data = ids.tobytes()
        return image

    def make_markers(self, room: RoomMarker, message: OccupancyGrid) -> list[Marker]:
        """The outline of a room and its text."""
        line = Marker(header=message.header, ns="outlines", id=room.id, type=Marker.LINE_STRIP, action=Marker.ADD)
        line.points = [Point(x=x, y=y, z=0.0) for x, y in room.outline]
        line.scale.x = LINE_WIDTH
        text = Marker(header=message.header, ns="names", id=room.id, type=Marker.TEXT_VIEW_FACING, action=Marker.ADD)
        text.text = room.text
        text.pose.position.x, text.pose.position.y = room.middle
        text.scale.z = TEXT_HEIGHT
        for marker in (line, text):
            marker.pose.orientation.w = 1.0
            marker.color.r, marker.color.g, marker.color.b = room.color
            marker.color.a = 1.0
        return [line, text]

    def answer_room_at(self, request: RoomAt.Request, response: RoomAt.Response) -> RoomAt.Response:
        """The room of a position."""
        room = self.server.find_room(request.x, request.y)
        response.found = room is not None
        if room is not None:
            response.id, response.name, response.label = room.id, room.name or "", room.label or ""
        return response

    def answer_list_rooms(self, _: ListRooms.Request, response: ListRooms.Response) -> ListRooms.Response:
        """All rooms, as JSON."""
        response.rooms = self.server.list_rooms()
        return response


def main() -> None:
    """Run the node until Ctrl+C."""
    rclpy.init()
    node = RoomsNode()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
