"""Mapper: a robot's hypothesis of a building, which grows with its map."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._arguments import check_argument
from pianta._types import Floats, Mask
from pianta.building import Building, Storey
from pianta.building_types.growing_map_types import GrowingMapTypeModel
from pianta.building_types.map_types import MapTypeModel
from pianta.errors import FloorError, MapError, MapWarning, OptionError
from pianta.floor import Floor, round_floor
from pianta.gridmap import OCCUPIED, UNKNOWN, GridMap
from pianta.labels import standard_building_type
from pianta.layout.reconstruct import DEFAULT_METHOD, find_rooms
from pianta.layout.room_ids import find_frame_motion, keep_room_ids
from pianta.mapping.beliefs import choose_type, update_labels, update_type
from pianta.mapping.changed_parts import (
    EMPTY_FLOOR,
    Box,
    choose_windows,
    classify_cells,
    forget_cells,
    have_same_frame,
    list_cuts,
    list_windows,
    measure_seen_area,
    measure_wall_agreement,
    put_on_grid,
    read_windows,
)
from pianta.mapping.events import Event, list_events
from pianta.mapping.partial_shapes import predict_shapes, strip_predictions
from pianta.mapping.state import EARLIER_FILES, MapState, read_state, save_state
from pianta.rooms.features import describe_rooms
from pianta.rooms.model import RoomModel

if TYPE_CHECKING:
    from pianta.generation.type_model import TypeModel
    from pianta.prediction.prediction import OpenEnd, Prediction
    from pianta.prediction.unexplored_part import FloorSampler

# All chosen by hand.
MAX_READ_SHARE = 0.5  # of the seen cells in windows: from here on the whole map is read
SAME_WALL_SHARE = 0.5  # of the wall cells are near one still, on a map of the same building in the same frame
SAME_MOVED_SHARE = 0.65  # of the wall cells, as far as a loop closure may have moved them
MAX_READ_AREA = 300.0  # m² that an update reads: less than a second on one core as a rule, in cells of 0.05 m


@dataclass(frozen=True)
class MapUpdate:
    """What a mapper has made of a map.

    Attributes
    ----------
    building
        One storey, with the map. The probabilities of its labels are beliefs; another label or type is announced once
        it is clearly more probable than the one announced before. A room without an announced label has None as
        `label`, and its likeliest answers in `labels`.
    events
        What has changed in the building.
    types
        The belief over types, with "other" for a building of none of them; also if the type was given. The type that
        is announced, or was given, is in `floor.building_type`.
    read_share
        The share of the seen cells that were read again, 0 … 1.
    ends
        With a model of the building's type: unopened doors and open corridors, as `predict` describes them. Their
        labels are beliefs too, calibrated, but seldom certain (docs/methods/mapping.md).
    prediction
        With such a model, the expected size of the floor, and the samples; None if nothing is open.
    waiting_share
        The share of the seen cells that have changed and were not read yet, 0 … 1. The next updates read them, also
        those with the same map; while more changes than they can read, small changes come last.
    """

    building: Building
    events: tuple[Event, ...]
    types: Mapping[str, float]
    read_share: float
    ends: tuple[OpenEnd, ...] = ()
    prediction: Prediction | None = None
    waiting_share: float = 0.0

    @property
    def floor(self) -> Floor:
        """The floor of the building."""
        return self.building.storeys[0].floor


@dataclass(frozen=True)
class _NewReading:
    """The floor of a map, with the ids of before.

    share: of the seen cells, that was read. area: with what windows see around them, m²; inf for the whole map.
    changed: x, y of the changed cells that were read, shape (N, 2); None for all. as_read: the map, with the cells that
    wait to be read as they were before; None if none wait.
    """

    floor: Floor
    share: float = 1.0
    area: float = np.inf
    changed: Floats | None = None
    is_same_building: bool = True
    is_same_frame: bool = True
    as_read: GridMap | None = None
    tried: frozenset[tuple[int, int]] = frozenset()


class Mapper:
    """A robot's hypothesis of a building: rooms, doors, labels and type, which each update of its map changes.

    Only what has changed on the map is read again, so that an update costs much less than `read`. Rooms keep their ids.

    Parameters
    ----------
    building_type
        The type of the building, such as "school"; None if unknown, and with a model for its type. Rooms get the labels
        of this type.
    model
        Model of the building's type, of `train_type`, by which what lies behind open ends is predicted; None without.
    room_model
        Model of `train_rooms` or `load_model`; None for the one that comes with pianta.
    type_model
        Model of the types of maps, or of growing maps; None for the one that comes with pianta.
    predict_partial
        Whether to predict the whole shape of rooms that were seen in part.
    labels
        Whether to predict the labels of rooms and the type of the building.
    previous
        The floor of an earlier run, whose ids rooms keep; None without one. `load` continues a run with its
        beliefs.
    max_read_area
        The largest area, m² of seen cells, that an update reads, so that its time has a limit: what has changed
        besides waits for the next updates. None for no limit. Without effect on the first map of a building and on a
        map in another frame, which are read as a whole. A square of 8 m, with what is around it, is always read.

    Raises
    ------
    LabelError
        The type is not a name.
    ModelError
        The model is of another type, or by "ncut".
    OptionError
        An argument is of a wrong type, or the area is not above 0.

    References
    ----------
    M. Luperto, PhD thesis, chapters 8 and 9.

    Examples
    --------
    >>> import pianta
    >>> _, grid = pianta.make_world("corridor")
    >>> mapper = pianta.Mapper()
    >>> update = mapper.update(grid)
    >>> len(update.floor), str(update.events[0])
    (19, 'type changed: unknown → office')
    >>> mapper.update(grid).events
    ()
    """

    def __init__(
        self,
        *,
        building_type: str | None = None,
        model: TypeModel | None = None,
        room_model: RoomModel | None = None,
        type_model: MapTypeModel | GrowingMapTypeModel | None = None,
        predict_partial: bool = True,
        labels: bool = True,
        previous: Floor | None = None,
        max_read_area: float | None = MAX_READ_AREA,
    ) -> None:
        check_argument(room_model, (RoomModel, type(None)), "room_model", "a model of train_rooms or load_model")
        check_argument(previous, (Floor, type(None)), "previous", "a Floor of read_floor")
        if max_read_area is not None and not max_read_area > 0:
            raise OptionError(f"max_read_area is {max_read_area} m², give an area above 0, or None for no limit")
        self.building_type = None if building_type is None else standard_building_type(building_type)
        self._sampler = None if model is None else _make_sampler(model, self.building_type)
        if model is not None:
            self.building_type = model.building_type
        self.room_model, self.type_model = room_model, type_model
        self.predict_partial, self.labels, self.previous = predict_partial, labels, previous
        self.max_read_area = max_read_area
        self.state: MapState | None = None

    def update(self, grid: GridMap, *, time: float | None = None) -> MapUpdate:
        """Take the newest map of the robot.

        Parameters
        ----------
        grid
            The map. It may be larger or smaller than the last one, and its frame may have moved.
        time
            When it was made, seconds; None if unknown. A map that is older than the last one with a time changes
            nothing.

        Returns
        -------
        MapUpdate
            The building, and what has changed.

        Raises
        ------
        MapError
            The map shows no room, or cannot be read. The mapper stays as it was, and the next map may be better.
        OptionError
            The time is no number.

        Warns
        -----
        MapWarning
            The map is older than the last one.
        """
        check_argument(grid, GridMap, "grid", "a GridMap of read_map")
        _check_time(time)
        before = self.state
        if before is not None and time is not None and before.time is not None and time < before.time:
            message = (
                f"a map of {time:g} s came after one of {before.time:g} s and is left out; send maps in their order"
            )
            warnings.warn(MapWarning(message), stacklevel=2)
            return _describe(before, (), 0.0)
        # Rooms, doors and walls of what has changed (chapter 3); rooms keep their ids
        reading = self._read(grid)
        if not reading.is_same_building:
            before = None
        # The whole shape of rooms that were seen in part (section 8.2)
        floor, types = reading.floor, {} if before is None else before.types
        waiting: tuple[int, ...] = ()
        if self.predict_partial:
            area = None if self.max_read_area is None else reading.area
            floor, waiting = predict_shapes(floor, reading.as_read or grid, before, reading.changed, area)
        # What kind of building it is (chapter 6), and what each room is for (chapters 4 and 5): beliefs over readings
        if self.labels and reading.share:
            floor, types = self._believe(floor, before)
        # What lies behind its open ends (section 8.3)
        ends, prediction = self._predict_ends(floor, before, has_changed=reading.share > 0)
        previous = EMPTY_FLOOR if before is None else before.floor
        events = list_events(floor, previous, is_new_building=not reading.is_same_building)
        old = [self.state.floor, *self.state.earlier] if self.state is not None and reading.is_same_frame else []
        self.state = MapState(
            grid,
            floor,
            tuple(old[: len(EARLIER_FILES)]),
            types,
            self.state.time if time is None and self.state is not None else time,
            self.building_type,
            waiting,
            reading.as_read,
            {end.name: end.labels for end in ends},
            reading.tried,
        )
        return replace(_describe(self.state, events, reading.share), ends=ends, prediction=prediction)

    def update_patch(self, patch: GridMap, *, time: float | None = None) -> MapUpdate:
        """Take a part of the map that has changed, as of map_msgs/OccupancyGridUpdate.

        Parameters
        ----------
        patch
            Cells of the last map: of the same size, in the same directions, from a corner of one of them, and inside
            the map.
        time
            As of `update`.

        Returns
        -------
        MapUpdate
            As of `update`.

        Raises
        ------
        MapError
            There is no map yet, or the patch is not inside it, or has other cells; or as of `update`.

        Examples
        --------
        The patch has the first 100 rows, from the left to column 200.

        >>> import pianta
        >>> _, grid = pianta.make_world("corridor")
        >>> mapper = pianta.Mapper()
        >>> _ = mapper.update(grid)
        >>> x, y = grid.pixel_to_map(100, 0)
        >>> patch = pianta.GridMap(grid.cells[:100, :200], grid.resolution, (float(x), float(y), 0.0))
        >>> mapper.update_patch(patch).events
        ()
        """
        check_argument(patch, GridMap, "patch", "a GridMap")
        if self.state is None:
            raise MapError("a patch came before the first map; give the whole map to update")
        grid = self.state.grid
        if not have_same_frame(grid, patch):
            patch_cells, map_cells = (
                f"of {each.resolution:g} m from {', '.join(f'{value:g}' for value in each.origin)}"
                for each in (patch, grid)
            )
            raise MapError(f"the patch has cells {patch_cells} (x, y, yaw), give cells of the map, {map_cells}")
        row, col = (round(float(each)) for each in grid.map_to_pixel(*patch.pixel_to_map(0.0, 0.0)))
        rows, cols = patch.shape
        if not (0 <= row <= grid.shape[0] - rows and 0 <= col <= grid.shape[1] - cols):
            where = f"{rows} × {cols} cells from row {row}, column {col}"
            raise MapError(f"the patch, {where}, is not inside the map of {grid.shape[0]} × {grid.shape[1]} cells")
        cells = grid.cells.copy()
        cells[row : row + rows, col : col + cols] = patch.cells
        return self.update(replace(grid, cells=cells), time=time)

    def finish(self) -> MapUpdate:
        """Read all that waits of the last map, without a limit of time, such as at the end of a run.

        Returns
        -------
        MapUpdate
            As of `update`.

        Raises
        ------
        MapError
            There was no map yet; or as of `update`.

        Examples
        --------
        >>> import pianta
        >>> mapper = pianta.Mapper(max_read_area=50.0)
        >>> _, grid = pianta.make_world("corridor")
        >>> cells = grid.cells.copy()
        >>> cells[:, 300:] = -1
        >>> _ = mapper.update(pianta.GridMap(cells, grid.resolution, grid.origin))
        >>> mapper.update(grid).waiting_share > 0, mapper.finish().waiting_share
        (True, 0.0)
        """
        if self.state is None:
            raise MapError("there was no map yet; call update first")
        limit, self.max_read_area = self.max_read_area, None
        try:
            return self.update(self.state.grid, time=self.state.time)
        finally:
            self.max_read_area = limit

    def save(self, folder: str | Path) -> None:
        """Write what the mapper knows; after a kill at any moment the folder has the last state that was saved.

        Parameters
        ----------
        folder
            Created if necessary. Its floor.geojson is the floor, as `read` writes it.

        Raises
        ------
        MapError
            There was no map yet.
        WriteError
            The folder cannot be written.

        Examples
        --------
        >>> import pianta
        >>> mapper = pianta.Mapper()
        >>> _ = mapper.update(pianta.make_world("corridor")[1])
        >>> mapper.save("mapper")
        >>> len(pianta.Mapper.load("mapper").floor)
        19
        """
        if self.state is None:
            raise MapError("there was no map yet; call update first")
        save_state(self.state, Path(folder))

    @classmethod
    def load(
        cls,
        folder: str | Path,
        *,
        model: TypeModel | None = None,
        room_model: RoomModel | None = None,
        type_model: MapTypeModel | GrowingMapTypeModel | None = None,
        predict_partial: bool = True,
        labels: bool = True,
        max_read_area: float | None = MAX_READ_AREA,
    ) -> Mapper:
        """Go on from a folder of `save`.

        Parameters
        ----------
        folder
            That of `save`.
        model, room_model, type_model, predict_partial, labels, max_read_area
            As of `Mapper`.

        Returns
        -------
        Mapper
            It continues as the one that was saved would have, if it gets the same options: a state has the map, the
            floor with ids and beliefs, the time and the building's type, but neither models nor other options.

        Raises
        ------
        MapError, FloorError
            A file of the folder is missing or damaged.
        ModelError
            The model is of another type than the building.
        """
        state = read_state(Path(folder))
        mapper = cls(
            building_type=state.building_type,
            model=model,
            room_model=room_model,
            type_model=type_model,
            predict_partial=predict_partial,
            labels=labels,
            max_read_area=max_read_area,
        )
        mapper.state = state
        return mapper

    @property
    def floor(self) -> Floor:
        """The floor, with beliefs; without rooms before the first map."""
        return EMPTY_FLOOR if self.state is None else self.state.floor

    def _read(self, grid: GridMap) -> _NewReading:
        """The floor of a map, of which only changes are read if most of it is as before."""
        read, state = partial(find_rooms, method=DEFAULT_METHOD), self.state
        if state is None:
            floor = read(grid)
            return _NewReading(round_floor(keep_room_ids(floor, self.previous) if self.previous else floor))
        cells, before = classify_cells(grid), None
        if have_same_frame(grid, state.grid):
            before = put_on_grid(state.as_read or state.grid, grid)
            is_changed = cells != before
            windows = list_windows(grid, is_changed, state.floor)
            if not windows:
                return _NewReading(state.floor, 0.0, 0.0, np.zeros((0, 2)), tried=state.tried)
            if self._has_parts(grid, cells, before, windows):
                return self._read_parts(grid, cells, before, windows, state)
        floor = read(grid)
        is_same_frame = before is not None and _has_same_walls(cells, before)
        if is_same_frame or _is_same_building(floor, state.floor):
            floor = keep_room_ids(floor, state.floor, earlier=state.earlier, is_same_frame=is_same_frame)
            return _NewReading(round_floor(floor), is_same_frame=is_same_frame)
        # No id is used again in another building
        last_id = max(each.last_id for each in (state.floor, *state.earlier))
        floor = keep_room_ids(floor, replace(EMPTY_FLOOR, last_id=last_id))
        return _NewReading(round_floor(floor), is_same_building=False, is_same_frame=False)

    def _read_parts(
        self,
        grid: GridMap,
        cells: NDArray[np.int8],
        before: NDArray[np.int8],
        windows: Sequence[Box],
        state: MapState,
    ) -> _NewReading:
        """The floor before, of which windows are read again, or parts of them that are not above the limit."""
        read, is_changed = partial(find_rooms, method=DEFAULT_METHOD), cells != before
        parts = choose_windows(grid, is_changed, state.floor, windows, self.max_read_area or np.inf)
        is_read = _mark(parts, grid.shape)
        # What waits is seen as it was before, so that all windows see the same
        as_read = replace(grid, cells=np.where(is_read, cells, before))
        bare = replace(state.floor, rooms=tuple(map(strip_predictions, state.floor)))
        floor = read_windows(as_read, parts, bare, read)
        floor = keep_room_ids(floor, state.floor, earlier=state.earlier, is_same_frame=True)
        has_rest = bool((is_changed & ~is_read).any())
        # Where a room may have been read as two, the next update reads it again, once
        cuts = {} if self.max_read_area is None else list_cuts(floor, as_read, parts, without=state.tried)
        if cuts:
            as_read = forget_cells(as_read, np.concatenate([*cuts.values()]))
        return _NewReading(
            round_floor(floor),
            _measure_share(cells, parts),
            measure_seen_area(grid, parts),
            _list_points(grid, is_changed, parts),
            as_read=as_read if has_rest or cuts else None,
            tried=state.tried | cuts.keys(),
        )

    def _has_parts(
        self, grid: GridMap, cells: NDArray[np.int8], before: NDArray[np.int8], windows: Sequence[Box]
    ) -> bool:
        """Whether changes are read in windows, instead of the whole map."""
        share = _measure_share(cells, windows)
        # A map that is unknown everywhere is read as a whole, which says what is wrong with it
        if 0 < share <= MAX_READ_SHARE:
            return True
        area = np.count_nonzero(cells != UNKNOWN) * grid.resolution**2
        if self.max_read_area is None or area <= self.max_read_area:
            return False
        return measure_wall_agreement(cells, before, grid.resolution) >= SAME_MOVED_SHARE

    def _believe(self, floor: Floor, before: MapState | None) -> tuple[Floor, Mapping[str, float]]:
        """The floor with beliefs, and the belief over types."""
        context = describe_rooms(floor)
        types = update_type(before.types if before else None, floor, self.type_model, context)
        announced = next(iter(before.floor.building_type), None) if before else None
        name = choose_type(types, announced)
        probabilities = {} if name is None else {name: types[name]}
        floor = replace(floor, building_type={self.building_type: 1.0} if self.building_type else probabilities)
        return update_labels(floor, before.floor if before else EMPTY_FLOOR, self.room_model, context), types

    def _predict_ends(
        self, floor: Floor, before: MapState | None, *, has_changed: bool
    ) -> tuple[tuple[OpenEnd, ...], Prediction | None]:
        """The open ends of the floor, with beliefs over what lies behind them, and what the whole floor may be."""
        if self._sampler is None:
            return (), None
        # Imported late, because its imports are slow
        from pianta.mapping.end_beliefs import predict_ends

        beliefs = {} if before is None else before.ends
        return predict_ends(floor, self._sampler, beliefs, is_new=has_changed)


def _make_sampler(model: TypeModel, building_type: str | None) -> FloorSampler:
    """The sampler of whole floors of a model of the building's type."""
    # Imported late, because their imports are slow
    from pianta.generation.type_model import TypeModel, check_model_type
    from pianta.prediction.unexplored_part import FloorSampler

    check_argument(model, TypeModel, "model", "a model of train_type or load_model")
    check_model_type(building_type, model, "the building")
    return FloorSampler(model)


def _check_time(time: float | None) -> None:
    check_argument(time, (int, float, type(None)), "time", "seconds, or None")
    if time is not None and not isfinite(time):
        raise OptionError(f"time is {time}, give seconds, or None if it is unknown")


def _describe(state: MapState, events: Sequence[Event], read_share: float) -> MapUpdate:
    building = Building((Storey(state.floor, grid=state.grid),))
    return MapUpdate(building, tuple(events), state.types, read_share, waiting_share=state.measure_waiting_share())


def _mark(windows: Sequence[Box], shape: tuple[int, int]) -> Mask:
    """The cells of windows, shape (H, W)."""
    inside = np.zeros(shape, bool)
    for top, left, bottom, right in windows:
        inside[top:bottom, left:right] = True
    return inside


def _list_points(grid: GridMap, cells: Mask, windows: Sequence[Box]) -> Floats:
    """x, y of the middles of cells in windows, shape (N, 2)."""
    inside = [
        np.argwhere(cells[top:bottom, left:right]) + np.array([top + 0.5, left + 0.5])
        for top, left, bottom, right in windows
    ]
    return np.column_stack(grid.pixel_to_map(*np.concatenate(inside).T))


def _measure_share(cells: NDArray[np.int8], windows: Sequence[Box]) -> float:
    """The share of the seen cells that lie in windows."""
    is_seen = cells != UNKNOWN
    inside = sum(np.count_nonzero(is_seen[top:bottom, left:right]) for top, left, bottom, right in windows)
    return float(inside) / max(int(np.count_nonzero(is_seen)), 1)


def _has_same_walls(cells: NDArray[np.int8], before: NDArray[np.int8]) -> bool:
    """Whether most walls are where they were, as far as the map has seen.

    cells, before: free, occupied or unknown, in one frame, shape (H, W).
    """
    was_wall = (before == OCCUPIED) & (cells != UNKNOWN)
    near = cv2.dilate((cells == OCCUPIED).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    return bool(was_wall.any() and near[was_wall].mean() >= SAME_WALL_SHARE)


def _is_same_building(floor: Floor, previous: Floor) -> bool:
    """Whether rooms fit to those before, in any frame."""
    try:
        find_frame_motion(floor, previous)
    except FloorError:
        return False
    return True
