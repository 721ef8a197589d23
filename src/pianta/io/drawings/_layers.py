"""Layers of vector plans: roles by the names of layers, the pieces of a drawing, and the doors that pieces draw."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import import_module
from itertools import pairwise
from pathlib import Path

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from pianta._types import Floats
from pianta.errors import PlanError
from pianta.floor.polygons import list_polygons
from pianta.io._files import check_input_file, one_line_reason, short_repr
from pianta.io.drawings._clips import Clip, area_of_rings, clip_chain, clip_rings
from pianta.io.drawings._drawing import ROLES, DrawnOutline, DrawnStamp, DrawnText, PlanDrawing, Role

# Limits against hostile files.
MAX_LINES = 1_000_000
MAX_TEXTS = 50_000
MAX_CORNERS = 5000  # of an area with holes; beyond, each of its rings is filled
MAX_CLIPPED_CORNERS = 20_000_000  # of clips, counted again for each piece that one clips
MAX_ARCS = 1000  # among which unnamed doors of a DXF are looked for
MAX_WEDGES = 5000  # among which doors of a PDF or SVG are looked for
_MAX_LEAVES = 100  # lines at a hinge
MAX_COORDINATE = 1e12  # beyond, a double cannot represent tenths of a millimetre

# Chosen by hand on drawings of the tests:
DARK = 0.6  # of the brightest of red, green and blue, 0 … 1, up to which a fill is poché, as the usual greys of CAD are
PAPER = 0.95  # luminance 0 … 1 from which a colour is invisible on white
_SPLINE_PIECES = 16  # straight lines for a Bézier curve
_TOUCHING_GAP = 0.02  # share of the diagonal of a piece
_END_TOLERANCE = 0.15  # share of the radius of a swing
_LONG_SIDE_RATIO = 1.2  # height to width of a door symbol from which its height is the door
# A quarter circle as a chain of lines:
_MIN_ARC_POINTS = 5
_MAX_RADIUS_SPREAD = 0.06  # share of the mean radius
_MAX_ARC_STEP = 40  # degrees between two points
_MAX_ARC_REVERSAL = 1  # degrees turned back, in all
_ARC_RANGE = (60, 120)  # degrees
_WEDGE_RANGE = (20, 120)  # degrees of an arc that has a leaf; on plans of estate agents leaves are little open
_MAX_TURN_IN_ARC = 25  # degrees between two steps of one arc
_MAX_STEP_RATIO = 3  # of the lengths of two steps of one arc
_USUAL_WIDTHS = (0.6, 1.7)  # of doors, in those of the usual door
_DOUBLE_LEAF_ANGLE = 150  # degrees between the two leaves of a double door, at least


def words_in(text: str) -> frozenset[str]:
    return frozenset(text.split())


# Words of layer names without accents, in English, Italian, German, French and Spanish; door wins over window and wall.
_WORDS: dict[Role, frozenset[str]] = {
    "door": words_in(
        "door doors doorway doorways doorleaf tur ture turen tuer tuere tueren tuerblatt tuerfluegel "
        "porta porte portes portone puerta puertas"
    ),
    "window": words_in("window windows wndw glaz glazing fenster finestra finestre fenetre fenetres ventana ventanas"),
    "wall": words_in(
        "wall walls partition partitions wand wande waende mauer mauern mauerwerk muro muri muros parete pareti "
        "muratura murature tramezzo tramezzi tamponamento mur murs cloison cloisons muret pared paredes tabique "
        "tabiques mamparas poche"
    ),
}
# Endings of compounds, which are common in German and in names without a hyphen.
_ENDINGS: dict[Role, tuple[str, ...]] = {
    "door": ("door", "doors", "tuer", "tueren"),
    "window": ("window", "windows", "fenster"),
    "wall": ("wall", "walls", "wand", "wande", "waende", "mauer", "mauern"),
}
_NO_COMPOUNDS = words_in("indoor indoors outdoor outdoors leinwand gewand aufwand")
_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss"})
# Words of layers with annotations of walls and doors.
ANNOTATIONS = words_in(
    "anno annotation annotations dim dims dimension dimensions iden ident tag tags text texts note notes label labels "
    "number numbers legend schedule bemassung beschriftung legende legenda leyenda quote quota quotes cote cotes cotas "
    "cotation testo testi texte textes texto textos etiquetas"
)


def role_of_names(names: Iterable[str]) -> Role:
    """The role of a piece by the names of its layer, block, class or groups, from the innermost to the outermost.

    The first name with a role decides; "other" if none has one. English, Italian, German, French and Spanish are
    understood; names of dimensions, tags and texts have no role.
    """
    return next((role for role in map(_role_of_name, names) if role != "other"), "other")


@lru_cache(maxsize=10_000)
def _role_of_name(name: str) -> Role:
    """The role that the words of a name mean; "other" without one, and for names of dimensions, tags and texts."""
    words = words_of_name(name)
    if not ANNOTATIONS.isdisjoint(words):
        return "other"
    for role, role_words in _WORDS.items():
        ending = _ENDINGS[role]
        if any(word in role_words or (word.endswith(ending) and word not in _NO_COMPOUNDS) for word in words):
            return role
    return "other"


def words_of_name(name: str) -> list[str]:
    """The words of a name such as A-WALL or roomLobby, in small letters without accents."""
    composed = unicodedata.normalize("NFC", name[:300])
    bases = "".join("s" if letter == "ß" else unicodedata.normalize("NFD", letter)[0] for letter in composed)
    matches = re.finditer(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", bases)
    return [_spell_plainly(composed[match.start() : match.end()]) for match in matches]


def _spell_plainly(word: str) -> str:
    """A word in small letters without accents, German umlauts as two letters."""
    spelled = word.lower().translate(_UMLAUTS)
    return "".join(letter for letter in unicodedata.normalize("NFD", spelled) if not unicodedata.combining(letter))


def plan_error(file: Path, fault: str) -> PlanError:
    """The exception for a plan that cannot be read; fault follows the name of the file."""
    return PlanError(f"plan {short_repr(file)} {fault}")


def check_plan_file(path: str | Path, *, max_bytes: int | None = None) -> Path:
    """The path of a plan, as of check_input_file; PlanError if it has more than max_bytes."""
    file = check_input_file(path, "plan", PlanError)
    if max_bytes is not None and file.stat().st_size > max_bytes:
        raise plan_error(file, f"has more than {max_bytes} bytes, too many for a plan, give one floor")
    return file


def require_library(file: Path, library: str, file_format: str, extra: str) -> None:
    """Raise PlanError unless the library of a format ("a DXF") can be imported; extra: of pianta, which has it."""
    try:
        import_module(library)
    except ImportError:
        raise plan_error(file, f"is {file_format}, install pianta[{extra}] to read it") from None


@contextmanager
def damage_as_plan_error(file: Path, file_format: str, *passed: type[BaseException]) -> Iterator[None]:
    """Raise PlanError for whatever a hostile file provokes in the library that reads it; `passed` are raised as is."""
    try:
        with np.errstate(all="ignore"):  # shapes beyond the range of numbers are left out later
            yield
    except Exception as exception:
        if isinstance(exception, (PlanError, *passed)):
            raise
        reason = one_line_reason(exception)
        raise plan_error(file, f"is a damaged {file_format}, save it again: {reason}") from exception


@dataclass
class DrawnPieces:
    """The pieces of a plan during reading, in drawing units, y up; at most MAX_LINES straight lines in all."""

    file: Path
    chains: list[Floats] = field(default_factory=list)
    roles: list[Role] = field(default_factory=list)
    widths: list[float] = field(default_factory=list)
    fills: list[Floats] = field(default_factory=list)
    texts: list[DrawnText] = field(default_factory=list)
    layers: list[str] = field(default_factory=list)
    outlines: list[DrawnOutline] = field(default_factory=list)
    stamps: list[DrawnStamp] = field(default_factory=list)
    skipped: Counter[str] = field(default_factory=Counter)
    lines: int = 0
    outline_corners: int = 0
    clipped_corners: int = 0

    def add_clipped_chain(self, points: Floats, role: Role, clip: Clip, *, width: float = 0.0) -> None:
        """Add the lines along points, shape (N, 2), within a clip; PlanError as of add_chain, and for large clips."""
        self._count_clipped([points], clip)
        for part in clip_chain(points, clip) if _is_in_range(points) else []:
            self.add_chain(part, role, width=width)

    def add_clipped_fill(self, rings: Sequence[Floats], role: Role, clip: Clip) -> None:
        """Add the area within an odd number of rings, each shape (N, 2), within a clip; PlanError for large clips."""
        self._count_clipped(rings, clip)
        rings = [ring for ring in rings if len(ring) >= 3 and _is_in_range(ring)]
        self.add_fill(clip_rings(rings, clip), role)

    def _count_clipped(self, rings: Sequence[Floats], clip: Clip) -> None:
        """Raise PlanError for more than MAX_CLIPPED_CORNERS, which would take forever."""
        if clip is not None:
            self.clipped_corners += int(shapely.get_num_coordinates(clip)) + sum(map(len, rings))
        if self.clipped_corners > MAX_CLIPPED_CORNERS:
            raise plan_error(self.file, "clips too many things with large clip paths, give one floor")

    def add_chain(self, points: Floats, role: Role, *, width: float = 0.0, layer: str = "") -> bool:
        """Add the lines along points, shape (N, 2); False if they have no length.

        Raises PlanError for more than MAX_LINES lines.
        """
        if len(points) < 2 or not _is_in_range(points):
            return False
        points = points[np.append(True, np.diff(points, axis=0).any(axis=1))]
        if len(points) < 2:
            return False
        self.lines += len(points) - 1
        if self.lines > MAX_LINES:
            raise plan_error(self.file, f"has more than {MAX_LINES} lines, give one floor")
        self.chains.append(points)
        self.roles.append(role)
        self.widths.append(width if 0 <= width <= MAX_COORDINATE else 0.0)
        self.layers.append(layer)
        return True

    def add_outline(self, rings: Sequence[Floats], layer: str) -> None:
        """Add a closed outline with its holes, each shape (N, 2), unless it has few or too many corners."""
        valid = [ring for ring in rings if 3 <= len(ring) <= MAX_CORNERS and _is_in_range(ring)]
        if not valid:
            return
        self.outline_corners += sum(map(len, valid))
        if self.outline_corners > MAX_LINES:
            raise plan_error(self.file, f"has outlines with more than {MAX_LINES} corners, give one floor")
        self.outlines.append(DrawnOutline(valid[0], layer, tuple(valid[1:])))

    def add_stamp(self, stamp: DrawnStamp) -> None:
        """Add a stamp unless it says nothing; raises PlanError for more than MAX_TEXTS."""
        if (stamp.number or stamp.name) and max(abs(stamp.x), abs(stamp.y)) <= MAX_COORDINATE:
            self.stamps.append(stamp)
        if len(self.stamps) > MAX_TEXTS:
            raise plan_error(self.file, f"has more than {MAX_TEXTS} blocks with attributes, give one floor")

    def add_fill(self, rings: Sequence[Floats], role: Role, *, layer: str = "") -> None:
        """Add the area within an odd number of rings, each shape (N, 2); the outline of a wall becomes lines, too."""
        rings = [ring for ring in rings if len(ring) >= 3 and _is_in_range(ring)]
        self.fills += _outlines_of_rings(rings)
        if role == "wall":
            for ring in rings:
                self.add_chain(np.vstack([ring, ring[:1]]), role, layer=layer)

    def add_text(self, text: DrawnText) -> None:
        """Add a text unless it is blank or beyond MAX_COORDINATE; raises PlanError for more than MAX_TEXTS."""
        numbers = np.array([text.x, text.y, text.height, text.angle])
        if text.text.strip() and text.height > 0 and (np.abs(numbers) <= MAX_COORDINATE).all():
            self.texts.append(text)
        if len(self.texts) > MAX_TEXTS:
            raise plan_error(self.file, f"has more than {MAX_TEXTS} texts, give one floor")

    def chains_of(self, role: Role) -> list[Floats]:
        """The chains of a role."""
        return [chain for chain, chain_role in zip(self.chains, self.roles, strict=True) if chain_role == role]

    def wall_ends(self) -> KDTree:
        """The points where walls end or turn."""
        return KDTree(np.concatenate([np.zeros((0, 2)), *self.chains_of("wall")]))

    def drawing(
        self,
        doors: Sequence[Floats],
        *,
        unnamed_doors: Sequence[Floats] = (),
        metres_per_unit: float | None = None,
        is_on_paper: bool = False,
    ) -> PlanDrawing:
        """The plan of all pieces and doors, each door shape (2, 2)."""
        names = {layer: number for number, layer in enumerate(dict.fromkeys(self.layers))}
        lines = [np.stack([chain[:-1], chain[1:]], axis=1) for chain in self.chains]
        counts = list(map(len, lines))
        return PlanDrawing(
            lines=np.concatenate([np.zeros((0, 2, 2)), *lines]),
            roles=np.repeat(np.array([ROLES.index(role) for role in self.roles], np.intp), counts),
            widths=np.repeat(np.array(self.widths, float), counts),
            fills=tuple(self.fills),
            doors=np.array(doors, float).reshape(-1, 2, 2),
            texts=tuple(self.texts),
            outlines=tuple(self.outlines),
            stamps=tuple(self.stamps),
            unnamed_doors=np.array(unnamed_doors, float).reshape(-1, 2, 2),
            line_layers=np.repeat(np.array([names[layer] for layer in self.layers], np.intp), counts),
            layers=tuple(names),
            skipped=dict(self.skipped),
            metres_per_unit=metres_per_unit,
            is_on_paper=is_on_paper,
            source=self.file.name,
        )


def luminance(color: Floats) -> float:
    """Luminance of red, green and blue, 0 … 1."""
    return float(color @ np.array([0.299, 0.587, 0.114]))


def is_poche(color: Floats) -> bool:
    """Whether a fill of red, green and blue, 0 … 1, is that of walls: dark, and no colour of a department."""
    return bool(color.max() <= DARK)


def _is_in_range(points: Floats) -> bool:
    return bool((np.abs(points) <= MAX_COORDINATE).all())


def _outlines_of_rings(rings: Sequence[Floats]) -> list[Floats]:
    """Outlines without holes that together cover the area within an odd number of rings."""
    # A single ring is its own outline even if it meets itself; many corners would take forever to combine.
    if len(rings) == 1 or sum(map(len, rings)) > MAX_CORNERS:
        return list(rings)
    area = area_of_rings(rings)
    pieces = [piece for part in list_polygons(shapely.make_valid(area)) for piece in _cut_through_holes(part)]
    return [np.asarray(shapely.get_coordinates(piece.exterior)) for piece in pieces if piece.area > 0]


def _cut_through_holes(polygon: shapely.Polygon) -> list[shapely.Polygon]:
    """Pieces without holes that together cover a polygon; each hole is cut vertically."""
    if not polygon.interiors:
        return [polygon]
    left, bottom, right, top = polygon.bounds
    cuts = [shapely.Polygon(hole).representative_point().x for hole in polygon.interiors]
    cuts = [left, *sorted(cuts), right]
    strips = [shapely.box(start, bottom, end, top) for start, end in pairwise(cuts)]
    return list_polygons(shapely.intersection(polygon, strips))


def chains_of_steps(start: Floats, steps: Iterable[Floats]) -> Iterator[Floats]:
    """Runs of straight lines and runs of curves along a path, each shape (N, 2), so that the arc of a door is separate.

    start: shape (2,). steps: the further points of each piece, shape (N, 2); curves have several.
    """
    run, was_curve = [start[None]], None
    for points in steps:
        is_curve = len(points) > 1
        if was_curve not in {None, is_curve}:
            yield np.concatenate(run)
            run = [run[-1][-1:]]
        run.append(points)
        was_curve = is_curve
    yield np.concatenate(run)


def bezier_points(controls: Floats) -> Floats:
    """Points along a Bézier curve of three (quadratic) or four (cubic) controls, shape (3 or 4, 2)."""
    if len(controls) == 3:
        start, middle, end = controls
        controls = np.array([start, (start + 2 * middle) / 3, (2 * middle + end) / 3, end])
    step = np.linspace(0, 1, _SPLINE_PIECES + 1)[:, None]
    weights = np.hstack([(1 - step) ** 3, 3 * step * (1 - step) ** 2, 3 * step**2 * (1 - step), step**3])
    return np.asarray(weights @ controls)


@dataclass(frozen=True)
class _Swing:
    """The quarter circle of a door leaf: its hinge, shape (2,), and the ends of the arc, shape (2, 2)."""

    hinge: Floats
    ends: Floats

    @property
    def radius(self) -> float:
        return float(np.hypot(*(self.ends[0] - self.hinge)))


def jambs_of_symbol(chains: Sequence[Floats], *, axis: Floats | None = None, walls: KDTree) -> list[Floats]:
    """The doors that a symbol draws, from jamb to jamb, each shape (2, 2).

    chains: the symbol's lines, each shape (N, 2). axis: its direction along the wall, if known.
    walls: the points where walls end.

    A quarter circle gives the hinge and the closed leaf; two that meet are a double door. Without one, the door is the
    longer side of the symbol's box, through its middle.
    """
    along = _longest_direction(chains) if axis is None else axis
    doors = jambs_of_swings(chains, axis=along, walls=walls)
    if doors or not chains:
        return doors
    points = np.concatenate(chains)
    frame = np.array([along, [-along[1], along[0]]])
    low, high = (points @ frame.T).min(axis=0), (points @ frame.T).max(axis=0)
    longer = int(high[1] - low[1] > _LONG_SIDE_RATIO * (high[0] - low[0]))
    ends = np.tile((low + high) / 2, (2, 1))
    ends[:, longer] = low[longer], high[longer]
    return [ends @ frame] if high[longer] > low[longer] else []


def jambs_of_swings(chains: Sequence[Floats], *, axis: Floats | None = None, walls: KDTree) -> list[Floats]:
    """The doors whose quarter circles are among lines, from jamb to jamb; parameters as of jambs_of_symbol."""
    along = _longest_direction(chains) if axis is None else axis
    swings = [swing for swing in map(_swing_of_chain, chains) if swing]
    if not swings:
        return []
    lines = np.concatenate([np.stack([chain[:-1], chain[1:]], axis=1) for chain in chains])
    # Most lines of many doors are chords of arcs, which are too short for a leaf.
    lengths = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
    lines = lines[lengths > min(swing.radius for swing in swings) / 2]
    return _join_leaves([_closed_leaf(swing, lines, along, walls) for swing in swings])


def jambs_of_wedges(chains: Sequence[Floats]) -> list[Floats]:
    """The doors that leaves with their arcs draw among all lines of a plan, from jamb to jamb, each shape (2, 2).

    chains: each shape (N, 2). Leaves of furniture have other widths than the usual door, for which the long ones count.
    """
    arcs = [arc for chain in chains if len(chain) >= _MIN_ARC_POINTS for arc in _split_at_corners(chain)]
    lines = np.concatenate([np.zeros((0, 2, 2)), *[np.stack([each[:-1], each[1:]], axis=1) for each in chains]])
    doors = jambs_of_leaves(arcs[:MAX_WEDGES], lines, turns=_WEDGE_RANGE)
    widths = np.array([np.hypot(*(door[1] - door[0])) for door in doors])
    if not len(widths):
        return []
    least, most = _USUAL_WIDTHS
    ratios = widths / widths[:, None]
    is_near = (ratios >= least) & (ratios <= most)
    usual = is_near[int((is_near @ widths).argmax())]
    return [door for door, is_usual in zip(doors, usual.tolist(), strict=True) if is_usual]


def _split_at_corners(chain: Floats) -> list[Floats]:
    """The pieces of a chain, shape (N, 2), between its corners that have enough points for an arc."""
    steps = np.diff(chain, axis=0)
    lengths = np.hypot(*steps.T)
    angles = np.arctan2(steps[:, 1], steps[:, 0])
    turns = np.abs((np.diff(angles) + np.pi) % (2 * np.pi) - np.pi)
    ratios = lengths[1:] / lengths[:-1]
    is_corner = (turns > np.radians(_MAX_TURN_IN_ARC)) | (np.maximum(ratios, 1 / ratios) > _MAX_STEP_RATIO)
    ends = [0, *(np.flatnonzero(is_corner) + 1).tolist(), len(chain) - 1]
    return [chain[start : end + 1] for start, end in pairwise(ends) if end - start + 1 >= _MIN_ARC_POINTS]


def jambs_of_leaves(arcs: Sequence[Floats], lines: Floats, *, turns: tuple[float, float] = _ARC_RANGE) -> list[Floats]:
    """The doors of arcs that have an open leaf, from jamb to jamb, each shape (2, 2).

    arcs: chains, each shape (N, 2). lines: shape (M, 2, 2), among which the leaves are looked for. turns: of the arcs,
    degrees.

    A leaf is a line from the middle of the quarter circle to one of its ends: arcs of furniture have none.
    """
    swings = [swing for arc in arcs if (swing := _swing_of_chain(arc, turns))]
    lengths = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
    # Most lines of many doors are chords of arcs, which are too short for a leaf.
    lines = lines[lengths > min((swing.radius for swing in swings), default=np.inf) / 2]
    if not len(lines):
        return []
    ends = KDTree(lines.reshape(-1, 2))
    doors = []
    for swing in swings:
        near = ends.query_ball_point(swing.hinge, _END_TOLERANCE * swing.radius)[:_MAX_LEAVES]
        at_hinge = lines[np.unique(np.asarray(near, np.intp) // 2)]
        leaf = _open_leaf(swing, at_hinge)
        if leaf is not None:
            doors.append(np.array([swing.hinge, swing.ends[1 - leaf]]))
    return _join_leaves(doors[:MAX_ARCS])


def _open_leaf(swing: _Swing, lines: Floats) -> int | None:
    """The end of the arc, 0 or 1, to which a line goes from the hinge; None without one, or for both."""
    reach = _END_TOLERANCE * swing.radius
    at_hinge = np.hypot(*np.moveaxis(lines - swing.hinge, -1, 0)) < reach
    at_ends = np.hypot(*np.moveaxis(lines[:, :, None] - swing.ends, -1, 0)) < reach
    open_leaf = (at_hinge[:, ::-1, None] & at_ends).any(axis=(0, 1))
    return int(open_leaf.argmax()) if open_leaf.sum() == 1 else None


def touching_pieces(chains: Sequence[Floats]) -> list[list[Floats]]:
    """Chains in groups whose boxes touch, in the order of their first members."""
    if not chains:
        return []
    bounds = np.array([np.concatenate([chain.min(axis=0), chain.max(axis=0)]) for chain in chains])
    reach = np.hypot(*(bounds[:, 2:] - bounds[:, :2]).T)[:, None] * _TOUCHING_GAP
    boxes = shapely.box(*np.hstack([bounds[:, :2] - reach, bounds[:, 2:] + reach]).T)
    first, second = shapely.STRtree(boxes).query(boxes, predicate="intersects")
    touching = coo_array((np.ones(len(first), bool), (first, second)), shape=(len(chains),) * 2)
    groups: dict[int, list[Floats]] = {}
    for chain, number in zip(chains, connected_components(touching)[1].tolist(), strict=True):
        groups.setdefault(number, []).append(chain)
    return list(groups.values())


def _longest_direction(chains: Sequence[Floats]) -> Floats:
    steps = np.concatenate([np.zeros((1, 2)), *[np.diff(chain, axis=0) for chain in chains]])
    longest = steps[np.hypot(*steps.T).argmax()]
    return np.asarray(longest / np.hypot(*longest)) if longest.any() else np.array([1.0, 0.0])


def _swing_of_chain(chain: Floats, arc_range: tuple[float, float] = _ARC_RANGE) -> _Swing | None:
    """The swing of a chain that is an arc: on a circle, in small steps one way, by degrees in a range; else None."""
    size = np.ptp(chain, axis=0).max()
    if len(chain) < _MIN_ARC_POINTS or size == 0:
        return None
    points = (chain - chain[0]) / size
    equations = np.column_stack([2 * points, np.ones(len(points))])
    middle = np.linalg.lstsq(equations, (points**2).sum(axis=1), rcond=None)[0][:2]
    spokes = points - middle
    radii = np.hypot(*spokes.T)
    if np.ptp(radii) > _MAX_RADIUS_SPREAD * radii.mean():
        return None
    cross = spokes[:-1, 0] * spokes[1:, 1] - spokes[:-1, 1] * spokes[1:, 0]
    turns = np.degrees(np.arctan2(cross, (spokes[:-1] * spokes[1:]).sum(axis=1)))
    total, least, most = abs(turns.sum()), *arc_range
    if np.abs(turns).max() > _MAX_ARC_STEP or np.abs(turns).sum() - total > _MAX_ARC_REVERSAL:
        return None
    if not least < total < most:
        return None
    return _Swing(middle * size + chain[0], chain[[0, -1]])


def _closed_leaf(swing: _Swing, lines: Floats, axis: Floats, walls: KDTree) -> Floats:
    """The closed leaf: from the hinge to the end of the arc away from the drawn, open leaf.

    Without an open leaf, to the end of the arc at the end of a wall; else to the end that is more along the axis.
    lines: of the symbol, shape (N, 2, 2).
    """
    reach = _END_TOLERANCE * swing.radius
    leaf = _open_leaf(swing, lines)
    if leaf is not None:
        return np.array([swing.hinge, swing.ends[1 - leaf]])
    distances = walls.query(swing.ends)[0]
    if distances.min() < reach and np.ptp(distances) > reach / 2:
        return np.array([swing.hinge, swing.ends[distances.argmin()]])
    askew = np.abs((swing.ends - swing.hinge) @ np.array([-axis[1], axis[0]]))
    return np.array([swing.hinge, swing.ends[askew.argmin()]])


def _join_leaves(leaves: Sequence[Floats]) -> list[Floats]:
    """Doors of closed leaves, from hinge to free end; two leaves that meet end to end are one door, equal ones too."""
    doors: list[Floats] = []
    remaining = list(leaves)
    while remaining:
        door = remaining.pop(0)
        reach = _END_TOLERANCE * np.hypot(*(door[1] - door[0]))
        for index, other in enumerate(remaining):
            if np.hypot(*(other[1] - door[1])) < reach and _angle_between(door, other) > _DOUBLE_LEAF_ANGLE:
                door = np.array([door[0], remaining.pop(index)[0]])
                break
        middle = door.mean(axis=0)
        if all(np.hypot(*(middle - other.mean(axis=0))) > reach for other in doors):
            doors.append(door)
    return doors


def _angle_between(first: Floats, second: Floats) -> float:
    """Degrees, 0 … 180, between two lines with a direction."""
    along, other = first[1] - first[0], second[1] - second[0]
    return float(np.degrees(abs(np.arctan2(along[0] * other[1] - along[1] * other[0], along @ other))))
