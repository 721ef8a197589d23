"""Photos of plans that were taken from an angle: the vanishing points of their lines, and the straightened picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Colors, Floats, Mask
from pianta.plan.sheets.binarization import Greys

Matrix = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class PerspectiveParameters:
    """Thresholds of `straighten`. Chosen by hand, so that no scan or render of the data is taken for a photo."""

    working_px: int = 1000  # of the longer side, on which lines and the paper are looked for
    min_segment: float = 0.03  # share of the longer side: shorter lines are letters and furniture
    max_segments: int = 600  # the longest ones, for time
    min_segments: int = 12  # of each of the two families
    family_degrees: float = 25.0  # of lines of a family from its main direction
    aim_degrees: float = 0.7  # of a line from the vanishing point, or direction, of its family
    trials: int = 400  # pairs of lines whose vanishing point is tried
    min_convergence: float = 2.0  # degrees by which the lines of a family differ over the picture
    max_convergence: float = 75.0  # degrees; beyond, far rooms are too small to be read
    min_aimed: float = 0.6  # share of the length of all lines that agree with the vanishing points
    min_gain: float = 0.15  # by which it is larger than the share that agrees with parallel lines
    min_paper_gain: float = 0.1  # the same of the lines that converge most, as the edges of the paper say
    min_paper: float = 0.25  # share of the picture that is paper on a darker table
    min_fit: float = 0.96  # share of the paper that its four corners enclose, and the other way round
    min_step: float = 25.0  # grey levels between the paper and the table
    edge: float = 0.01  # share of the longer side: lines nearer to the edges of the paper are these
    trim: float = 0.006  # share of the sides of the paper that is cut off, with its shadow
    focal_length: float = 0.75  # of phones, in longer sides of the picture: 27 mm on 36 mm
    max_growth: float = 2.5  # of the number of pixels
    min_side_px: int = 100  # of the shorter side
    max_side_px: int = 32_000  # of the longer side, before and after: OpenCV warps no larger pictures


PARAMETERS = PerspectiveParameters()


@dataclass(frozen=True, eq=False)
class StraightPicture:
    """A straightened picture.

    colors: shape (H, W, 3). by: what it was straightened by, in a few words.
    matrix: 3 × 3, from x and y in the picture that was given to x and y in this one.
    """

    colors: Colors
    by: str
    matrix: Matrix


def straighten(colors: Colors) -> StraightPicture | None:
    """The picture as seen from straight above, if its lines clearly converge as in a photo from an angle; else None.

    colors: shape (H, W, 3). The corners of the paper on a darker table give the vanishing points, or without them the
    two families of lines; in both cases the lines have to agree. A paper is cut out.
    """
    p, longest = PARAMETERS, max(colors.shape[:2])
    if min(colors.shape[:2]) < p.min_side_px or longest > p.max_side_px:
        return None
    factor = min(1.0, p.working_px / longest)
    small = cv2.resize(colors, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA) if factor < 1 else colors
    grey = np.asarray(cv2.cvtColor(small, cv2.COLOR_RGB2GRAY), np.uint8)
    paper = _find_paper(grey)
    families = _find_families(_find_segments(grey), grey.shape, within=paper)
    if families is None:
        return None
    points, by = None, ""
    if paper is not None and _is_perspective(families, _points_of_paper(paper), grey.shape, by_paper=True):
        points, by = _points_of_paper(paper), "the edges of its paper"
    elif _is_perspective(families, _points_of_lines(families), grey.shape, by_paper=False):
        points, by = _points_of_lines(families), "the directions of its lines"
    if points is None:
        return None
    view = np.diag([factor, factor, 1.0])
    corners = paper if paper is not None else _corners_of((grey.shape[0], grey.shape[1]))
    matrix = _matrix_from_above(points, grey.shape, corners, factor, is_paper=paper is not None)
    return None if matrix is None else _warp(colors, matrix[0] @ view, matrix[1], by)


def _find_segments(grey: Greys) -> Floats:
    """The straight lines of a picture, the longest first: ends x and y, shape (N, 2, 2)."""
    # The stubs of OpenCV do not know that there may be no lines
    answer: Any = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD).detect(grey)[0]
    if answer is None:
        return np.zeros((0, 2, 2))
    segments = np.asarray(answer, float).reshape(-1, 2, 2)
    lengths = _lengths(segments)
    order = np.argsort(-lengths, kind="stable")[: PARAMETERS.max_segments]
    return np.asarray(segments[order[lengths[order] >= PARAMETERS.min_segment * max(grey.shape)]])


def _lengths(segments: Floats) -> Floats:
    return np.asarray(np.hypot(*(segments[:, 1] - segments[:, 0]).T))


def _find_families(segments: Floats, shape: tuple[int, ...], *, within: Floats | None) -> tuple[Floats, Floats] | None:
    """The lines that run more across and more down the sheet, each shape (N, 2, 2); None if either are few.

    within: the corners of the paper, whose own edges, and whatever lies on the table, do not count; None without paper.
    """
    if within is not None:
        inner = within + (within.mean(axis=0) - within) * 2 * PARAMETERS.trim
        outline = inner.astype(np.float32)
        middles = segments.mean(axis=1)
        depths = [cv2.pointPolygonTest(outline, (float(x), float(y)), measureDist=True) for x, y in middles]
        is_inside = [depth > PARAMETERS.edge * max(shape) for depth in depths]
        segments = segments[np.array(is_inside, bool)]
    if len(segments) < 2 * PARAMETERS.min_segments:
        return None
    steps = segments[:, 1] - segments[:, 0]
    angles, lengths = np.degrees(np.arctan2(steps[:, 1], steps[:, 0])), _lengths(segments)
    # Four times the angle is the same for lines at right angles
    turn = np.angle((lengths * np.exp(4j * np.radians(angles))).sum()) / 4
    main = float(np.degrees(turn))
    across, down = (_turn_between(angles, main + right) <= PARAMETERS.family_degrees for right in (0, 90))
    if abs(main) > 45:
        across, down = down, across
    if min(across.sum(), down.sum()) < PARAMETERS.min_segments:
        return None
    return segments[across], segments[down]


def _turn_between(angles: Floats, other: Floats | float) -> Floats:
    """Degrees, 0 … 90, between lines without a direction."""
    return np.asarray(np.abs((angles - other + 90) % 180 - 90))


def _points_of_lines(families: tuple[Floats, Floats]) -> Matrix:
    """The vanishing points of two families, homogeneous, shape (2, 3)."""
    return np.array([_vanishing_point(segments) for segments in families])


def _vanishing_point(segments: Floats) -> Floats:
    """The point, homogeneous, shape (3,), at which the most length of lines aims."""
    lines, lengths = _lines_through(segments), _lengths(segments)
    rng = np.random.default_rng(0)
    # Long lines know their direction best
    chosen = rng.choice(len(lines), (PARAMETERS.trials, 2), p=lengths / lengths.sum())
    points = np.cross(lines[chosen[:, 0]], lines[chosen[:, 1]])
    points = points[np.abs(points).max(axis=1) > 0]
    points = np.vstack([points, _parallel_point(segments)])
    scores = [float(lengths[_aims_at(segments, point)].sum()) for point in points]
    best = points[int(np.argmax(scores))]
    for _ in range(3):
        near = _aims_at(segments, best)
        # The point nearest to the lines by least squares, long lines first
        weighted = lines[near] * lengths[near, None]
        weighted /= np.hypot(lines[near, 0], lines[near, 1])[:, None]
        unit = np.array([1, 1, max(1.0, float(np.abs(segments).max()))])
        fitted = np.linalg.svd(weighted * unit)[2][-1] * unit
        if lengths[_aims_at(segments, fitted)].sum() < lengths[near].sum():
            break
        best = fitted
    return np.asarray(best)


def _parallel_point(segments: Floats) -> Floats:
    """The point at infinity of the main direction of lines, homogeneous, shape (3,)."""
    steps = segments[:, 1] - segments[:, 0]
    angles, lengths = np.degrees(np.arctan2(steps[:, 1], steps[:, 0])), _lengths(segments)
    tried = np.concatenate([angles, angles[:1]])
    scores = [float(lengths[_turn_between(angles, each) <= PARAMETERS.aim_degrees].sum()) for each in tried]
    best = np.radians(tried[int(np.argmax(scores))])
    return np.array([np.cos(best), np.sin(best), 0.0])


def _lines_through(segments: Floats) -> Floats:
    """Homogeneous lines, shape (N, 3)."""
    ends = np.concatenate([segments, np.ones((len(segments), 2, 1))], axis=2)
    return np.asarray(np.cross(ends[:, 0], ends[:, 1]))


def _aims_at(segments: Floats, point: Floats) -> Mask:
    """Which lines aim at a vanishing point, shape (N,)."""
    middles, steps = segments.mean(axis=1), segments[:, 1] - segments[:, 0]
    toward = point[:2] - point[2] * middles
    angles, aims = np.arctan2(steps[:, 1], steps[:, 0]), np.arctan2(toward[:, 1], toward[:, 0])
    return np.asarray(_turn_between(np.degrees(angles), np.degrees(aims)) <= PARAMETERS.aim_degrees)


def _is_perspective(families: tuple[Floats, Floats], points: Matrix, shape: tuple[int, ...], *, by_paper: bool) -> bool:
    """Whether lines clearly converge at two vanishing points, and do not fit parallel lines nearly as well.

    by_paper: whether the points are those of the edges of the paper, so that fewer lines suffice.
    """
    p = PARAMETERS
    convergence = [_convergence(point, shape) for point in points]
    if not p.min_convergence <= max(convergence) <= p.max_convergence:
        return False
    parallel = np.array([_parallel_point(segments) for segments in families])
    totals = np.array([float(_lengths(segments).sum()) for segments in families])
    aimed = _aimed_lengths(families, points)
    gains = aimed - _aimed_lengths(families, parallel)
    if aimed.sum() < p.min_aimed * totals.sum():
        return False
    if not by_paper:
        return bool(gains.sum() >= p.min_gain * totals.sum())
    steepest = int(np.argmax(convergence))
    return bool(gains[steepest] >= p.min_paper_gain * totals[steepest])


def _aimed_lengths(families: tuple[Floats, Floats], points: Matrix) -> Floats:
    """The length of lines that aim at the point of their family, shape (2,)."""
    pairs = zip(families, points, strict=True)
    return np.array([float(_lengths(segments)[_aims_at(segments, point)].sum()) for segments, point in pairs])


def _convergence(point: Floats, shape: tuple[int, ...]) -> float:
    """Degrees between the directions to a vanishing point over the picture; 180 if it lies within."""
    height, width = shape[:2]
    aims = [point[:2] - point[2] * corner for corner in _corners_of((height, width))]
    middle = point[:2] - point[2] * np.array([width, height]) / 2
    turns = [np.arctan2(middle[0] * y - middle[1] * x, middle[0] * x + middle[1] * y) for x, y in aims]
    return float(np.degrees(max(turns) - min(turns)))


def _corners_of(shape: tuple[int, int]) -> Floats:
    """The corners of a picture, x and y, from the upper left one clockwise, shape (4, 2)."""
    height, width = shape
    return np.array([(0, 0), (width, 0), (width, height), (0, height)], float)


def _find_paper(grey: Greys) -> Floats | None:
    """The corners of the paper on a darker table, x and y, from the upper left one clockwise, shape (4, 2)."""
    p = PARAMETERS
    # Drawn lines are closed, so that the paper is one bright piece
    side = max(3, round(0.02 * max(grey.shape))) | 1
    closed = cv2.morphologyEx(cv2.medianBlur(grey, 5), cv2.MORPH_CLOSE, np.ones((side, side), np.uint8))
    bright = cv2.threshold(closed, 0, 255, cv2.THRESH_OTSU)[1]
    levels = [float(np.median(grey[part])) if part.any() else 0.0 for part in (bright > 0, bright == 0)]
    if levels[0] - levels[1] < p.min_step:
        return None
    outlines = cv2.findContours(np.asarray(bright, np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    hull = cv2.convexHull(max(outlines, key=cv2.contourArea))
    if cv2.contourArea(hull) < p.min_paper * grey.size:
        return None
    corners = _four_corners(np.asarray(hull, np.int32))
    if corners is None:
        return None
    inside = np.zeros(grey.shape, np.uint8)
    cv2.fillConvexPoly(inside, np.rint(corners).astype(np.int32), 255)
    filled = np.zeros(grey.shape, np.uint8)
    cv2.drawContours(filled, [max(outlines, key=cv2.contourArea)], -1, 255, cv2.FILLED)
    both, either = np.count_nonzero(inside & filled), np.count_nonzero(inside | filled)
    on_border = np.count_nonzero((corners <= 2).any(axis=1) | (corners >= np.array(grey.shape[::-1]) - 3).any(axis=1))
    return corners if both >= p.min_fit * either and on_border <= 1 else None


def _four_corners(hull: NDArray[np.int32]) -> Floats | None:
    """The corners of a hull that is nearly a quadrilateral, from the upper left one clockwise, shape (4, 2)."""
    around = cv2.arcLength(hull, closed=True)
    for share in (0.01, 0.02, 0.03, 0.05):
        corners = cv2.approxPolyDP(hull, share * around, closed=True).reshape(-1, 2).astype(float)
        if len(corners) == 4:
            corners = corners[::-1] if cv2.contourArea(corners.astype(np.float32), oriented=True) < 0 else corners
            return np.roll(corners, -int(corners.sum(axis=1).argmin()), axis=0)
    return None


def _points_of_paper(corners: Floats) -> Matrix:
    """The vanishing points of the upper and lower, and of the left and right edges, homogeneous, shape (2, 3)."""
    edges = _lines_through(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1))
    return np.array([np.cross(edges[0], edges[2]), np.cross(edges[1], edges[3])])


def _matrix_from_above(
    points: Matrix, shape: tuple[int, ...], corners: Floats, factor: float, *, is_paper: bool
) -> tuple[Matrix, tuple[int, int]] | None:
    """The matrix from the working picture to the one from above, and the height and width of that.

    points: the vanishing points across and down. corners: of what is shown. factor: of the working picture; the result
    has the pixels of the full one in its middle. None if the picture would grow too much.
    """
    p = PARAMETERS
    middle = corners.mean(axis=0)
    focal = p.focal_length * max(shape[:2])
    camera = np.array([[focal, 0, shape[1] / 2], [0, focal, shape[0] / 2], [0, 0, 1]])
    axes = np.linalg.solve(camera, points.T).T
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    origin = np.linalg.solve(camera, np.append(middle, 1.0))
    plane = camera @ np.column_stack([axes[0], axes[1], origin])
    # x to the right and y down, in pixels of the picture in its middle
    jacobian = (plane[:2, :2] - middle[:, None] * plane[2, :2]) / plane[2, 2]
    flips = np.sign([jacobian[0, 0], jacobian[1, 1]])
    scale = np.sqrt(abs(np.linalg.det(jacobian)))
    if not (flips.all() and scale > 0):
        return None
    above = np.diag([*(flips * scale / factor), 1.0]) @ np.linalg.inv(plane)
    low, high = _bounds(above, corners)
    margin = p.trim * (high - low) if is_paper else np.zeros(2)
    low, high = low + margin, high - margin
    width, height = np.ceil(high - low)
    most = p.max_growth * shape[0] * shape[1] / factor**2
    if not (0 < width * height <= most and p.min_side_px <= min(width, height) <= max(width, height) <= p.max_side_px):
        return None
    shift = np.array([[1, 0, -low[0]], [0, 1, -low[1]], [0, 0, 1.0]])
    return shift @ above, (int(height), int(width))


def _bounds(matrix: Matrix, corners: Floats) -> tuple[Floats, Floats]:
    """The lowest and highest x and y of corners after a matrix; infinite if one lies behind the horizon."""
    moved = np.column_stack([corners, np.ones(4)]) @ matrix.T
    if not (moved[:, 2] * moved[0, 2] > 0).all():
        return np.zeros(2), np.full(2, np.inf)
    moved = moved[:, :2] / moved[:, 2:]
    return moved.min(axis=0), moved.max(axis=0)


def _warp(colors: Colors, matrix: Matrix, size: tuple[int, int], by: str) -> StraightPicture:
    """The picture after a matrix; size: height and width. What the photo does not show is of the colour of its edge."""
    edge = np.concatenate([colors[0], colors[-1], colors[:, 0], colors[:, -1]])
    straight = cv2.warpPerspective(
        colors,
        matrix,
        size[::-1],
        flags=cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=np.median(edge, axis=0).tolist(),
    )
    return StraightPicture(np.asarray(straight, np.uint8), by, matrix)
