"""The thresholds of the methods, in metres or in the thesis' own unit."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite
from typing import TypeVar

from pianta.errors import OptionError

P = TypeVar("P", bound="Parameters")


@dataclass(frozen=True, kw_only=True)
class Parameters:
    """The thresholds of a method that finds rooms; each method has its own."""


@dataclass(frozen=True, kw_only=True)
class ThesisParameters(Parameters):
    """Thresholds of the layout method of the thesis (section 3.1); nobody should need to change them.

    Parameters
    ----------
    working_resolution
        Metres per cell at which the image operations run; the authors' pixel values belong to it.
    clutter_size
        Groups of cells that are not free, smaller than this across, are furniture (section 3.2); metres.
    canny_low, canny_high
        The minVal and maxVal of the Canny detector, grey levels of the binary image.
    hough_votes
        Edge length that a line must collect in the Hough transform; metres.
    hough_angle
        Angular step of the Hough transform; degrees.
    segment_length, segment_gap
        Shortest segment, and widest gap that a segment may bridge; metres.
    hough_passes
        Times that the transform is run, each on the edges that the former ones left unexplained.
    angle_bandwidth
        The bandwidth h of eq. 3.2.
    line_distance
        Distance from which parallel lines are kept apart; metres (the text's 90 cm).
    line_support
        Length of segments below which a cluster is no wall; metres.
    filled_gap
        Gaps between two segments of a line up to this length are doors, and count as wall; metres.
    courtyard_area
        Smaller unknown spots inside the contour count as inside; m².
    inside_share
        The δ as a share of the face; a face with less of its area inside the contour is external.
    partial_weight
        A face whose edge to an external face weighs less is partial.
    sigma
        Softness of the affinity exp(-w / σ). The authors' 0.1 splits corridors at a hint of wall.
    epsilon
        The ε of DBSCAN.
    room_area
        Free area below which a cluster of faces is no room; m².
    door_width
        Wider passages are openings; metres.
    passage_width
        Narrower passages lead nowhere; metres.

    Raises
    ------
    OptionError
        Values are not positive finite numbers; the message names all of them.

    References
    ----------
    M. Luperto, PhD thesis, sections 3.1 and 3.2.

    Examples
    --------
    >>> import pianta
    >>> pianta.ThesisParameters(door_width=1.6).line_distance
    0.9
    """

    working_resolution: float = 0.05
    clutter_size: float = 1.5
    canny_low: float = 90.0
    canny_high: float = 100.0
    hough_votes: float = 0.5
    hough_angle: float = 1.0
    segment_length: float = 0.25
    segment_gap: float = 0.15
    hough_passes: int = 3
    angle_bandwidth: float = 0.023
    line_distance: float = 0.9
    line_support: float = 2.0
    filled_gap: float = 1.5
    courtyard_area: float = 1.0
    inside_share: float = 0.3
    partial_weight: float = 0.2
    sigma: float = 0.15
    epsilon: float = 0.85
    room_area: float = 1.0
    door_width: float = 2.0
    passage_width: float = 0.3

    def __post_init__(self) -> None:
        _check_positive(self)


@dataclass(frozen=True, kw_only=True)
class StructureParameters(Parameters):
    """Thresholds of the method `structure`, in metres; nobody should need to change them.

    Parameters
    ----------
    working_resolution
        Metres per cell at which the map is cut.
    clutter_size
        Groups of cells that are not free, smaller than this across, are furniture (section 3.2).
    patch_area
        Free space apart from the rest that is smaller than this is noise; m².
    passage_width
        Narrower passages lead nowhere.
    gap_width
        To rooms that cannot be reached otherwise a gap as wide as this leads.
    saddle_ratio
        A place is a neck when its clearance is less than this share of that on both sides.
    mouth_ratio
        So is a place where one side has less than this share of the clearance of the other.
    neck_distance
        Of two necks with both ends nearer than this the shorter one stays.
    wall_reach
        How far beyond the jambs of a neck the wall in line with it is followed.
    room_area
        A smaller room belongs to its neighbour, or is none; m².
    closed_room_area
        A smaller room without a passage belongs to its neighbour; m².
    smoothing
        Side of the square whose area an outline may leave out at a corner.
    notch_depth, notch_width
        Furniture along a wall is no deeper and no wider than this.
    door_width
        Wider passages are openings.
    unseen_width
        Thinner unknown space is wall, or between the beams of the scanner.
    frontier
        A room that borders as much unseen space is partial.
    split_share
        Two parts of a room are rooms when at most this share of the wall line between them is open.
    split_wall
        Wall between two such parts, at least.
    split_opening
        Widest opening between them, as a multiple of the width of the narrower one, at most.
    split_clearance
        Width of each such part, the diameter of the largest circle in it, at least.
    split_area
        Area of each such part, at least; m².
    longest_opening
        A wider opening of a wall line is not closed.
    line_reach
        How far a wall line is followed both ways.

    Raises
    ------
    OptionError
        Values are not positive finite numbers; the message names all of them.

    References
    ----------
    M. Luperto, PhD thesis, chapters 3 and 9.

    Examples
    --------
    >>> import pianta
    >>> _, grid = pianta.make_world("corridor")
    >>> floor = pianta.reconstruct(grid, parameters=pianta.StructureParameters(door_width=0.5))
    >>> {door.kind for door in floor.doors}
    {'opening'}
    """

    working_resolution: float = 0.05
    clutter_size: float = 1.5
    patch_area: float = 0.25
    passage_width: float = 0.3
    gap_width: float = 0.1
    saddle_ratio: float = 0.92
    mouth_ratio: float = 0.65
    neck_distance: float = 0.35
    wall_reach: float = 3.0
    room_area: float = 0.5
    closed_room_area: float = 0.8
    smoothing: float = 0.1
    notch_depth: float = 1.0
    notch_width: float = 3.0
    door_width: float = 2.0
    unseen_width: float = 0.5
    frontier: float = 0.5
    split_share: float = 0.65
    split_wall: float = 1.8
    split_opening: float = 1.1
    split_clearance: float = 1.65
    split_area: float = 3.0
    longest_opening: float = 6.0
    line_reach: float = 12.0

    def __post_init__(self) -> None:
        _check_positive(self)


def _check_positive(parameters: ThesisParameters | StructureParameters) -> None:
    values = {field.name: getattr(parameters, field.name) for field in fields(parameters)}
    faults = [f"{name} is {value}" for name, value in values.items() if not (isfinite(value) and value > 0)]
    if faults:
        raise OptionError("; ".join(faults) + "; give positive numbers")


def check_parameters(given: Parameters | None, kind: type[P]) -> P:
    """The parameters of a method: those given, or the default ones for None.

    Raises OptionError when they belong to another method.
    """
    if given is None:
        return kind()
    if not isinstance(given, kind):
        raise OptionError(f"parameters are {type(given).__name__}, give {kind.__name__}")
    return given
