"""Corrections of a floor by the ids of its rooms: what `pianta correct` does, as methods of Floor."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Literal, Self

if TYPE_CHECKING:
    from pianta.corrections.kinds import XY, Correction

Points = Iterable[tuple[float, float]]


class Correctable:
    """A floor that can be corrected; each method returns another floor."""

    def merge(self, *rooms: int) -> Self:
        """Merge rooms that are one; the oldest id stays.

        Parameters
        ----------
        *rooms
            The ids of two rooms or more that are neighbours.

        Returns
        -------
        Floor
            The floor with one room in their position. Doors between them are gone.

        Raises
        ------
        CorrectionError
            There is no room with an id, or the rooms are more than 1 m apart.

        Examples
        --------
        >>> import pianta
        >>> floor, _ = pianta.make_world("corridor")
        >>> len(floor), len(floor.merge(2, 3))
        (19, 18)
        """
        from pianta.corrections.by_id import merge_by_id

        return self.correct(merge_by_id(self._floor, rooms))

    def split(self, room: int, line: Points) -> Self:
        """Split a room along a line; the largest part keeps the id, and an opening joins the parts.

        Parameters
        ----------
        room
            The id of the room.
        line
            x, y of two points or more, metres in the map frame, from wall to wall. An end may be 0.6 m before the wall.

        Returns
        -------
        Floor
            The floor with the parts; new ids follow `last_id`.

        Raises
        ------
        CorrectionError
            There is no room with the id, or the line does not divide it.

        Examples
        --------
        >>> import pianta
        >>> from shapely import box
        >>> floor = pianta.Floor((pianta.Room(1, box(0, 0, 8, 3)),)).split(1, [(5, 0), (5, 3)])
        >>> [(room.id, room.polygon.area) for room in floor]
        [(1, 15.0), (2, 9.0)]
        """
        from pianta.corrections.by_id import split_by_id

        return self.correct(split_by_id(self._floor, room, tuple(line)))

    def draw_room(self, outline: Points) -> Self:
        """Add a room where no room is.

        Parameters
        ----------
        outline
            x, y of its corners, metres in the map frame; what lies in other rooms is left out.

        Returns
        -------
        Floor
            The floor with the room, whose id follows `last_id`.

        Raises
        ------
        CorrectionError
            The outline crosses itself, or half of it lies in other rooms.

        Examples
        --------
        >>> import pianta
        >>> from shapely import box
        >>> floor = pianta.Floor((pianta.Room(1, box(0, 0, 4, 3)),))
        >>> len(floor.draw_room([(4, 0), (6, 0), (6, 3), (4, 3)]))
        2
        """
        from pianta.corrections.kinds import DrawRoom

        return self.correct(DrawRoom(tuple(outline)))

    def delete_room(self, room: int) -> Self:
        """Delete a room and its doors.

        Parameters
        ----------
        room
            Its id, which is not used again.

        Returns
        -------
        Floor
            The floor without it.

        Raises
        ------
        CorrectionError
            There is no room with the id.
        """
        from pianta.corrections.kinds import DeleteRoom

        return self.correct(DeleteRoom(self._position(room)))

    def mark_outside(self, area: int | Points) -> Self:
        """Mark an area as outside of the building; doors to it are entrances.

        Parameters
        ----------
        area
            The id of a room, or the corners of an outline, metres in the map frame.

        Returns
        -------
        Floor
            The floor without the area.

        Raises
        ------
        CorrectionError
            There is no room with the id, or the outline crosses itself.
        """
        from pianta.corrections.by_id import outline_of
        from pianta.corrections.kinds import MarkOutside

        outline = outline_of(self._floor, area) if isinstance(area, int) else tuple(area)
        return self.correct(MarkOutside(outline))

    def rename(self, room: int, name: str | None) -> Self:
        """Name a room.

        Parameters
        ----------
        room
            Its id.
        name
            Its name in the building; None for no name.

        Returns
        -------
        Floor
            The floor with the name.

        Raises
        ------
        CorrectionError
            There is no room with the id, or the name is too long or cannot be printed.

        Examples
        --------
        >>> import pianta
        >>> floor, _ = pianta.make_world("corridor")
        >>> floor.rename(3, "Kitchen")[3].name
        'Kitchen'
        """
        from pianta.corrections.kinds import NameRoom

        return self.correct(NameRoom(self._position(room), name))

    def renumber(self, room: int, number: str | None) -> Self:
        """Give a room the number that stands on its door.

        Parameters
        ----------
        room
            Its id, which stays.
        number
            Such as "204"; None for no number.

        Returns
        -------
        Floor
            The floor with the number.

        Raises
        ------
        CorrectionError
            There is no room with the id, or the number is too long or cannot be printed.

        Examples
        --------
        >>> import pianta
        >>> floor, _ = pianta.make_world("corridor")
        >>> floor.rename(3, "French").renumber(3, "204")[3].title
        '204 French'
        """
        from pianta.corrections.kinds import NumberRoom

        return self.correct(NumberRoom(self._position(room), number))

    def relabel(self, room: int, label: str | None) -> Self:
        """Label a room by hand; `label_rooms` keeps the label.

        Parameters
        ----------
        room
            Its id.
        label
            A label of a schema, or of another room, in any case; None for an unknown purpose.

        Returns
        -------
        Floor
            The floor with the label.

        Raises
        ------
        CorrectionError
            There is no room with the id, or no schema has the label.
        """
        from pianta.corrections.by_id import label_by_id

        return self.correct(label_by_id(self._floor, room, label))

    def draw_door(self, line: Points, *, door_kind: Literal["door", "opening"] = "door") -> Self:
        """Add a door or an opening between the rooms on both sides of a line, or an entrance.

        Parameters
        ----------
        line
            x, y of both jambs, metres in the map frame.
        door_kind
            "door" or "opening".

        Returns
        -------
        Floor
            The floor with the door.

        Raises
        ------
        CorrectionError
            There is no room beside the line, or the same one on both sides.
        """
        from pianta.corrections.kinds import DrawDoor

        return self.correct(DrawDoor(tuple(line), door_kind))

    def move_door(self, position: XY, line: Points) -> Self:
        """Move the door at a position.

        Parameters
        ----------
        position
            x, y on the door, metres in the map frame.
        line
            x, y of both jambs where it belongs.

        Returns
        -------
        Floor
            The floor with the door there.

        Raises
        ------
        CorrectionError
            There is no door at the position, or no room beside the line.
        """
        from pianta.corrections.kinds import MoveDoor

        return self.correct(MoveDoor(position, tuple(line)))

    def delete_door(self, position: XY) -> Self:
        """Delete the door or opening at a position.

        Parameters
        ----------
        position
            x, y on it, metres in the map frame.

        Returns
        -------
        Floor
            The floor without it.

        Raises
        ------
        CorrectionError
            There is no door at the position.
        """
        from pianta.corrections.by_id import delete_door_at

        return self.correct(delete_door_at(self._floor, position))

    def correct(self, correction: Correction) -> Self:
        """Apply a correction.

        Parameters
        ----------
        correction
            One of `pianta.corrections`, such as those in a corrections.json.

        Returns
        -------
        Floor
            The corrected floor; this one if it is as the correction says already.

        Raises
        ------
        CorrectionError
            The correction does not fit the floor.
        """
        from pianta.corrections.correct import correct

        corrected: Any = correct(self._floor, correction)
        return corrected  # type: ignore[no-any-return]

    @property
    def _floor(self) -> Any:  # noqa: ANN401 - Floor, whose module imports this one
        """The floor itself."""
        return self

    def _position(self, room: int) -> XY:
        from pianta.corrections.by_id import position_of

        return position_of(self._floor, room)
