"""The thresholds of the methods, in metres or in the thesis' own unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import isfinite
from typing import Any, TypeVar

from pianta.errors import OptionError

P = TypeVar("P", bound="Parameters")


@dataclass(frozen=True, kw_only=True)
class Parameters:
    """The thresholds of a method of layout reconstruction; each method has its own class."""


# Our departures from Algorithm 1 as the thesis prints it, in the order of the algorithm; each with the values that undo
# it: those of the text, else those of the experiments of its authors (pixels of 0.05 m).
CLUTTER = "small groups removed from bare maps too"
DEPARTURES: Mapping[str, Mapping[str, Any]] = {
    CLUTTER: {"remove_clutter": False},
    "a normal pose": {"normal_pose": False},
    "shorter segments": {"hough_votes": 1.0, "segment_length": 0.35},
    "three Hough passes": {"hough_passes": 1},
    "clusters of lines by their means": {"chain_lines": True},
    "weak lines dropped": {"drop_weak_lines": False},
    "door gaps filled": {"fill_gaps": False},
    "σ = 0.15": {"sigma": 0.1},
    "small clusters dropped": {"drop_small_rooms": False},
    "partial faces need an open edge": {"need_open_edge": False},
}


@dataclass(frozen=True, kw_only=True)
class ThesisParameters(Parameters):
    """Thresholds of the layout method of the thesis (section 3.1); the defaults fit most buildings.

    Sources: [1] the thesis, [2] the experiments of its authors, [3] trial on the 11 survey maps and 13 schools of the
    benches and on synthetic maps (docs/methods/layout.md). Values without a number were chosen by hand.

    Parameters
    ----------
    working_resolution
        Metres per cell at which the image operations run: that of the survey's maps, for which [2] gives pixels.
    clutter_size
        Groups of cells that are not free, smaller than this across, are furniture (section 3.2); metres [3].
    canny_low, canny_high
        The minVal and maxVal of the Canny detector; grey levels of the binary image [2].
    hough_votes
        Edge length that supports a line in the Hough transform, at least; metres [3].
    hough_angle
        Angular step of the Hough transform; degrees [2].
    segment_length, segment_gap
        Shortest segment, and widest gap that a segment may bridge; metres [3].
    hough_passes
        How often the transform is run, each time on the edges that earlier passes left unexplained [3].
    angle_bandwidth
        The bandwidth h of eq. 3.2 [1].
    line_distance
        Parallel lines at least this far apart are different walls; metres [1].
    line_support
        A cluster with a smaller total length of segments is not a wall; metres [3].
    filled_gap
        Gaps between two segments of a line up to this length are doors, and count as wall; metres [3].
    courtyard_area
        Smaller unknown spots inside the contour count as inside; m².
    inside_share
        The δ of the thesis, as a share of the face; a face with less of its area inside the contour is external [3].
    partial_weight
        A face whose edge to an external face has a lower weight is partial [2].
    sigma
        Softness of the affinity exp(-w / σ) [3]. The 0.1 of [2] splits corridors at the slightest trace of a wall.
    epsilon
        The ε of DBSCAN [1].
    room_area
        A cluster of faces with less free area is not a room; m².
    door_width
        Wider passages are openings; metres.
    passage_width
        Narrower passages are ignored; metres.
    remove_clutter
        Whether groups below clutter_size become free. The thesis does so on maps with furniture only.
    normal_pose
        Whether the map is turned so that it gives the same rooms in every pose. The thesis does not say so.
    chain_lines
        Whether any two segments nearer than line_distance are on one line, as [1] prints; else lines whose means are.
    drop_weak_lines
        Whether clusters below line_support give no line. The thesis does not say so.
    fill_gaps
        Whether gaps up to filled_gap count as wall. The thesis does so on floor plans only (section 3.3).
    drop_small_rooms
        Whether clusters of faces below room_area are left out. The thesis does not say so.
    need_open_edge
        Whether a partial face needs free space along its open edge. The thesis does not say so.

    Raises
    ------
    OptionError
        Values are not positive finite numbers, or switches not True or False; the message names all of them.

    References
    ----------
    M. Luperto, PhD thesis, sections 3.1 and 3.2.

    Examples
    --------
    >>> import pianta
    >>> pianta.ThesisParameters(door_width=1.6).line_distance
    0.9
    >>> printed = pianta.ThesisParameters.as_printed()
    >>> printed.sigma, printed.fill_gaps
    (0.1, False)
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
    remove_clutter: bool = True
    normal_pose: bool = True
    chain_lines: bool = False
    drop_weak_lines: bool = True
    fill_gaps: bool = True
    drop_small_rooms: bool = True
    need_open_edge: bool = True

    def __post_init__(self) -> None:
        _check_values(self)

    @classmethod
    def as_printed(cls, *, furnished: bool = True) -> ThesisParameters:
        """Algorithm 1 as the thesis prints it, without any of our departures.

        Parameters
        ----------
        furnished
            Whether small groups of cells are removed, as the thesis does on maps with furniture (section 3.2).

        Returns
        -------
        ThesisParameters
            Where the thesis gives no value, that of the experiments of its authors.

        Examples
        --------
        >>> import pianta
        >>> pianta.ThesisParameters.as_printed(furnished=False).remove_clutter
        False
        """
        printed: dict[str, Any] = {}
        for name, values in DEPARTURES.items():
            printed |= {} if furnished and name == CLUTTER else values
        return cls(**printed)


@dataclass(frozen=True, kw_only=True)
class StructureParameters(Parameters):
    """Thresholds of the method `structure`, in metres; the defaults fit most buildings.

    Chosen by hand on synthetic maps and on those of the benches (survey, furniture, schools, clutter); no value was
    fitted. Limits of probabilities are constants of the modules (docs/methods/structure.md).

    Parameters
    ----------
    working_resolution
        Metres per cell of the grid on which rooms are cut. Larger cells of a map stay up to 0.1 m, the size of those of
        the network.
    clutter_size
        Groups of cells that are not free, smaller than this across, are furniture (section 3.2) unless the network
        takes them for wall.
    patch_area
        Disconnected floor that is smaller than this is noise; m².
    passage_width
        Narrower passages are not cut as necks.
    gap_width
        Rooms that cannot be reached otherwise may be reached through gaps at least this wide.
    saddle_ratio
        A point is a neck if its clearance is less than this share of the clearance on both sides.
    mouth_ratio
        It is also a neck if one side has less than this share of the clearance of the other.
    neck_distance
        Of two necks with both ends nearer to each other than this the shorter one stays.
    room_area
        A smaller room is joined to its neighbour, or left out if it has none; m².
    room_width
        So is a narrower room, as between a wall and its ghost.
    smoothing
        Tolerance of the simplified outlines: an outline may leave out a square of this side at a corner.
    notch_depth, notch_width
        Furniture along a wall is no deeper and no wider than this.
    door_width
        Wider passages are openings.
    unseen_width
        Thinner unknown space is a wall, or a gap between two beams of the scanner.
    frontier
        A room with at least this length of frontier to unknown space is partial, unless it is large.
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
    room_area: float = 0.5
    room_width: float = 0.5
    smoothing: float = 0.1
    notch_depth: float = 1.0
    notch_width: float = 3.0
    door_width: float = 2.0
    unseen_width: float = 0.5
    frontier: float = 0.5
    line_reach: float = 12.0

    def __post_init__(self) -> None:
        _check_values(self)


def _check_values(parameters: ThesisParameters | StructureParameters) -> None:
    switches, numbers = [], []
    for field in fields(parameters):
        value = getattr(parameters, field.name)
        if isinstance(field.default, bool):
            switches += [f"{field.name} is {value}"] * (not isinstance(value, bool))
        elif not (isfinite(value) and value > 0):
            numbers.append(f"{field.name} is {value}")
    remedies = [("give True or False", switches), ("give positive numbers", numbers)]
    faults = [f"{'; '.join(faults)}; {remedy}" for remedy, faults in remedies if faults]
    if faults:
        raise OptionError("; ".join(faults))


def check_parameters(parameters: Parameters | None, parameter_class: type[P]) -> P:
    """The parameters, or the default ones of a method for None; raises OptionError if they are another method's."""
    if parameters is None:
        return parameter_class()
    if not isinstance(parameters, parameter_class):
        raise OptionError(f"parameters are {type(parameters).__name__}, give {parameter_class.__name__}")
    return parameters
