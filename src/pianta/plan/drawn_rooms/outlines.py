"""Which closed outlines of a vector plan are rooms: those with a text or stamp inside that tile the floor."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, STRtree

from pianta._types import Floats
from pianta.floor import MAX_ROOM_NAME_LENGTH
from pianta.floor.polygons import find_largest_polygon
from pianta.io.drawings._drawing import DrawnOutline, DrawnStamp, DrawnText, PlanDrawing
from pianta.io.writers.room_texts import split_number
from pianta.plan.sheets.sheet import PlacedText
from pianta.plan.text.dimensions import parse_size
from pianta.plan.text.room_names import compose_room_name
from pianta.plan.text.room_numbers import split_title

# Limits against hostile files.
MAX_OUTLINES = 20_000
MAX_PAIRS = 1_000_000  # of outlines that meet, and of texts in them
MAX_REPAIRED_CORNERS = 500  # of an outline that crosses itself; all its crossings are computed
MAX_REPAIRED = 50
MAX_TEXT = 200  # characters of a text in which an area is looked for

# Metres, or square metres.
WALL_REACH = 1.0  # between neighbours: the thickest walls of old buildings
MEDIAN_AREA = (2.0, 1000.0)  # of rooms; a desk has 1.3, a wardrobe 1.2
MIN_AREA = 0.3  # of a room: a shaft

# Shares. Each leaves a wide margin to what rooms have, and to what other outlines have.
RELATIVE_REACH = 0.25  # of the side of the median room, for neighbours on a plan without units
MAX_OVERLAP = 0.05  # of all rooms: their outlines meet in walls, else not
MIN_NEIGHBOURS = 0.5  # of the rooms have a neighbour; pieces of furniture stand by themselves
MIN_NAMED = 0.4  # of the outlines of a layer have a text: else texts stand in them by chance
MAX_NAMES = 2  # of the median room; outlines of wings, fire zones and flats have those of all their rooms
GROSS_SHARE = 0.5  # covered by rooms, from which an outline around them is no room
SAME_SHARE = 0.97  # covered by each other: the same outline drawn twice
FINER_SHARE = 0.6  # of an area that finer outlines cover too, from which these are the rooms
MAX_HOLES = 30  # outlines without a text in a room that are its holes: columns, shafts, courts
AREA_TOLERANCE = 0.03  # by which a written area is off

_ROOM_LAYER = re.compile(
    r"room|space|area|raum|zimmer|nutzfl|netto|stanz|vano|vani|local|piece|salle|surface|habitac|estancia|recint|rm(?:$|[-_])",
    re.IGNORECASE,
)
_AREA = re.compile(
    r"(?P<number>\d{1,6}(?:[.,]\d{1,3})?)\s*(?:(?P<metric>m2|m²|qm|mq|sqm|sq\.?\s?m\b|m\^2)|(?P<feet>sf\b|sq\.?\s?ft|ft2|ft²))",
    re.IGNORECASE,
)
_BARE_AREA = re.compile(r"\d{1,6}[.,]\d{1,3}")
_SIDE = r"\d[\d.,'\"’”-]*(?:\s?(?:mm|cm|m|ft)\b)?"
_SIZE = re.compile(rf"(?<![\w.,]){_SIDE}\s*[xX×]\s*{_SIDE}")
_SQUARE_FOOT = 0.3048**2


@dataclass(frozen=True, eq=False)
class DrawnRoom:
    """A room as it is drawn, in drawing units; stated: its written area, m², None without one."""

    polygon: Polygon
    number: str | None = None
    name: str | None = None
    stated: float | None = None
    layer: str = ""


@dataclass(frozen=True)
class _Label:
    """A text, or the stamp of a block, at a point in drawing units."""

    x: float
    y: float
    text: DrawnText | None = None
    stamp: DrawnStamp | None = None


@dataclass(frozen=True, eq=False)
class _Group:
    """Rooms that are drawn alike; total: their area, drawing units. named: how many have a text."""

    rooms: tuple[DrawnRoom, ...]
    layer: str

    @property
    def total(self) -> float:
        return float(sum(room.polygon.area for room in self.rooms))


def find_room_outlines(
    drawing: PlanDrawing, *, metres: float | None, chosen: Collection[str] = (), faces: Sequence[DrawnOutline] = ()
) -> tuple[DrawnRoom, ...]:
    """The rooms that a plan draws as closed outlines; empty if its outlines are no rooms.

    Parameters
    ----------
    drawing
        The plan.
    metres
        Metres per drawing unit, None if unknown.
    chosen
        The layers of rooms, if the user gives them; their outlines are rooms whatever they look like.
    faces
        Outlines to look at instead of those of the plan.

    Notes
    -----
    Outlines of a layer are rooms if a text or a stamp stands in them, they do not overlap, most have a neighbour behind
    a wall, and they are as large as rooms; names of layers only break ties. Of layers that cover the same floor the one
    that divides it more finely has the rooms. An outline around rooms is a hole of the room around it, or a gross area.
    """
    by_layer: dict[str, list[DrawnOutline]] = defaultdict(list)
    for outline in (faces or drawing.outlines)[:MAX_OUTLINES]:
        by_layer[outline.layer].append(outline)
    labels = _labels_of(drawing)
    is_chosen = bool(chosen)
    groups = [_group_of(outlines, labels, layer, metres) for layer, outlines in by_layer.items()]
    valid = [group for group in groups if group.rooms and (is_chosen or _tiles(group, labels, metres))]
    if not valid:
        return ()
    valid.sort(key=lambda group: (-group.total, not _ROOM_LAYER.search(group.layer), group.layer))
    best = valid[0]
    for group in valid[1:]:
        if len(group.rooms) > len(best.rooms) and _covered(best, group) >= FINER_SHARE * best.total:
            best = group
    return _with_others(best, valid)


def stated_area(texts: Sequence[str]) -> float | None:
    """The area, m², that texts of a room state, as 12,5 m², 209 sf or 12' x 13'; None unless all agree."""
    areas: set[float] = set()
    for text in texts:
        for match in _AREA.finditer(text[:MAX_TEXT]):
            unit = 1.0 if match["metric"] else _SQUARE_FOOT
            areas.add(float(match["number"].replace(",", ".")) * unit)
    if not areas:
        sizes = [size for text in texts for part in _SIZE.findall(text[:MAX_TEXT]) if (size := parse_size(part))]
        areas = {round(first * second, 6) for first, second in sizes}
    return areas.pop() if len(areas) == 1 else None


def _labels_of(drawing: PlanDrawing) -> list[_Label]:
    texts = [_Label(text.x, text.y, text=text) for text in drawing.texts if any(map(str.isalnum, text.text))]
    return [*(_Label(stamp.x, stamp.y, stamp=stamp) for stamp in drawing.stamps), *texts]


def _group_of(outlines: Sequence[DrawnOutline], labels: Sequence[_Label], layer: str, metres: float | None) -> _Group:
    """The rooms of a layer: outlines with a text of their own, and those without among them."""
    shapes = _distinct(_polygons_of(outlines))
    if not shapes or not labels:
        return _Group((), layer)
    owned = _labels_by_shape(shapes, labels)
    inside = _shapes_within(shapes)
    if inside is None:
        return _Group((), layer)
    rooms = []
    by_shape = {index: [labels[each] for each in owned[index]] for index in sorted(owned)}
    form = _common_form(by_shape.values())
    for index, own in by_shape.items():
        polygon = _without_rooms_inside(index, shapes, inside[index], owned, labels, metres)
        if polygon is not None:
            rooms.append(_make_room(polygon, _without_other_numbers(own, form), layer))
    rooms = [room for room in rooms if room.polygon.area > 0]
    if not rooms or len(rooms) < MIN_NAMED * len(shapes):
        return _Group(tuple(rooms), layer)
    return _Group((*rooms, *_unnamed_rooms(shapes, rooms, owned, layer)), layer)


def _polygons_of(outlines: Sequence[DrawnOutline]) -> list[Polygon]:
    """Valid polygons of outlines; of one that crosses itself the largest part."""
    repaired, polygons = 0, []
    for outline in outlines:
        polygon = Polygon(outline.ring, outline.holes)
        if not shapely.is_valid(polygon):
            repaired += 1
            if repaired > MAX_REPAIRED or shapely.get_num_coordinates(polygon) > MAX_REPAIRED_CORNERS:
                continue
            polygon = find_largest_polygon(shapely.make_valid(polygon, method="structure", keep_collapsed=False))
        if polygon.area > 0 and np.isfinite(polygon.area):
            polygons.append(polygon)
    return polygons


def _distinct(polygons: Sequence[Polygon]) -> list[Polygon]:
    """Polygons from the smallest to the largest, without those that cover the same area as an earlier one."""
    order = sorted(range(len(polygons)), key=lambda index: (polygons[index].area, index))
    distinct: list[Polygon] = []
    boxes: dict[tuple[float, ...], list[Polygon]] = defaultdict(list)
    for index in order:
        polygon = polygons[index]
        left, bottom, right, top = polygon.bounds
        size = max(right - left, top - bottom)
        middle = np.round([(left + right) / 2 / size, (bottom + top) / 2 / size], 2)
        # Neighbouring cells, so that rounding does not part the same outlines
        keys = [
            (round(float(np.log(size)), 1), *np.add(middle, (dx, dy)).round(2))
            for dx in (-0.01, 0, 0.01)
            for dy in (-0.01, 0, 0.01)
        ]
        if not any(_is_same(polygon, other) for key in keys for other in boxes[key][:MAX_REPAIRED]):
            distinct.append(polygon)
            boxes[keys[4]].append(polygon)
    return distinct


def _is_same(one: Polygon, other: Polygon) -> bool:
    common = shapely.intersection(one, other).area
    return bool(common >= SAME_SHARE * max(one.area, other.area))


def _pairs(tree: STRtree, shapes: Sequence[object] | NDArray[np.object_], predicate: str) -> NDArray[np.intp] | None:
    """Pairs of `shapes` and shapes of the tree, shape (2, N); None for more than MAX_PAIRS."""
    parts, count = [], 0
    array = np.asarray(shapes, object)
    for start in range(0, len(array), 256):
        part = tree.query(array[start : start + 256], predicate=predicate)
        part[0] += start
        count += part.shape[1]
        if count > MAX_PAIRS:
            return None
        parts.append(part)
    return np.concatenate(parts, axis=1) if parts else np.zeros((2, 0), np.intp)


def _labels_by_shape(shapes: Sequence[Polygon], labels: Sequence[_Label]) -> dict[int, list[int]]:
    """The labels in each shape, from the smallest one around them; shapes are in the order of their areas."""
    points = shapely.points([[label.x, label.y] for label in labels])
    pairs = _pairs(STRtree(shapes), points, "intersects")
    innermost: dict[int, int] = {}
    for label, shape in pairs.T.tolist() if pairs is not None else ():
        innermost[label] = min(shape, innermost.get(label, shape))
    owned: dict[int, list[int]] = defaultdict(list)
    for label, shape in sorted(innermost.items()):
        owned[shape].append(label)
    return dict(owned)


def _shapes_within(shapes: Sequence[Polygon]) -> list[list[int]] | None:
    """The indexes of the shapes in each shape; None if there are too many."""
    middles = shapely.point_on_surface(np.array(shapes, object))
    pairs = _pairs(STRtree(middles), shapes, "intersects")
    if pairs is None:
        return None
    within: list[list[int]] = [[] for _ in shapes]
    for outer, inner in pairs.T.tolist():
        if inner < outer:
            within[outer].append(inner)
    return within


def _without_rooms_inside(  # noqa: PLR0917
    index: int,
    shapes: Sequence[Polygon],
    inside: Sequence[int],
    owned: dict[int, list[int]],
    labels: Sequence[_Label],
    metres: float | None,
) -> Polygon | None:
    """The room of an outline with a text: without the holes and the rooms in it; None for a gross area around rooms."""
    outline = shapes[index]
    if not inside:
        return outline
    named = [each for each in inside if each in owned]
    # The largest outlines first: a hole may have rooms in it, which then are not in this room
    holes = [each for each in sorted(inside, reverse=True) if each not in owned]
    around = [hole for hole in holes if any(shapes[hole].intersects(shapes[each].point_on_surface()) for each in named)]
    net = find_largest_polygon(
        shapely.difference(outline, shapely.union_all([shapes[each] for each in (*holes, *named)]))
    )
    rest = find_largest_polygon(shapely.difference(outline, shapely.union_all([shapes[each] for each in named])))
    stated = stated_area(_texts_of([labels[each] for each in owned[index]]))
    if stated is not None and metres is not None:
        fits = [each for each in (net, rest, outline) if abs(each.area * metres**2 / stated - 1) <= AREA_TOLERANCE]
        if fits and (fits[0] is not outline or not named):
            return fits[0]
    free = [
        each for each in named if not any(shapes[hole].contains(shapes[each].point_on_surface()) for hole in around)
    ]
    if sum(shapes[each].area for each in free) >= GROSS_SHARE * outline.area:
        return None
    # Many small outlines in a room are furniture on the layer of the rooms
    return net if len(holes) <= MAX_HOLES else rest


def _unnamed_rooms(
    shapes: Sequence[Polygon], rooms: Sequence[DrawnRoom], owned: dict[int, list[int]], layer: str
) -> Iterator[DrawnRoom]:
    """Outlines without a text beside those with one, on the same layer; not those in rooms or around them."""
    tree = STRtree([room.polygon for room in rooms])
    smallest = min(room.polygon.area for room in rooms) / 4
    for index, shape in enumerate(shapes):
        if index in owned or shape.area < smallest:
            continue
        met = tree.query(shape, predicate="intersects")
        common = sum(shapely.intersection(shape, rooms[each].polygon).area for each in met[:MAX_HOLES])
        holds_rooms = any(shape.contains(rooms[each].polygon.point_on_surface()) for each in met)
        in_room = any(Polygon(rooms[each].polygon.exterior).contains(shape.point_on_surface()) for each in met)
        if common <= MAX_OVERLAP * shape.area and not holds_rooms and not in_room:
            yield DrawnRoom(shape, layer=layer)


def _make_room(polygon: Polygon, labels: Sequence[_Label], layer: str) -> DrawnRoom:
    stamps = [label.stamp for label in labels if label.stamp is not None]
    texts = [label.text for label in labels if label.text is not None]
    stated = stated_area(_texts_of(labels))
    number = next((stamp.number for stamp in stamps if stamp.number), None)
    name = next((stamp.name for stamp in stamps if stamp.name), None)
    if number is None and name is None:
        number, name = split_title(compose_room_name([_place_text(text) for text in texts]))
    elif name is None and not any(stamp.name or stamp.area for stamp in stamps):
        # A stamp with nothing but the number stands beside the text of the name
        _, name = split_number(compose_room_name([_place_text(text) for text in texts if text.text != number]))
    return DrawnRoom(polygon, _clean(number), _clean(name), stated, layer)


def _texts_of(labels: Sequence[_Label]) -> list[str]:
    """The texts in which areas are looked for; a bare number in the area of a stamp is square metres."""
    areas = [label.stamp.area for label in labels if label.stamp is not None and label.stamp.area]
    stamped = [f"{area} m²" if _BARE_AREA.fullmatch(area) else area for area in areas]
    return stamped or [label.text.text for label in labels if label.text is not None]


def _place_text(text: DrawnText) -> PlacedText:
    """A text with a box, in the frame of a sheet: row down, col to the right."""
    along = np.array([-np.sin(text.angle), np.cos(text.angle)])
    down = np.array([np.cos(text.angle), np.sin(text.angle)])
    half = along * len(text.text) * 0.85 * text.height / 2
    half_line = down * 1.4 * text.height / 2
    middle = np.array([-text.y, text.x])
    corners = middle + np.array([-half - half_line, half - half_line, half + half_line, half_line - half])
    return PlacedText(text.text, corners)


def _clean(text: str | None) -> str | None:
    printable = "".join(filter(str.isprintable, " ".join((text or "").split())))
    return printable[:MAX_ROOM_NAME_LENGTH].strip() or None


def _tiles(group: _Group, labels: Sequence[_Label], metres: float | None) -> bool:
    """Whether the outlines of a group with texts are as large as rooms, lie side by side, and have a name each."""
    rooms = group.rooms
    named = [room for room in rooms if room.number or room.name or room.stated]
    if len(named) < (1 if _ROOM_LAYER.search(group.layer) else 2) or len(named) < MIN_NAMED * len(rooms):
        return False
    areas = np.array([room.polygon.area for room in rooms])
    if metres is not None and not MEDIAN_AREA[0] <= float(np.median(areas)) * metres**2 <= MEDIAN_AREA[1]:
        return False
    return _names_per_room(rooms, labels) <= MAX_NAMES and _lie_side_by_side([room.polygon for room in rooms], metres)


def _names_per_room(rooms: Sequence[DrawnRoom], labels: Sequence[_Label]) -> float:
    """How many numbers of rooms stand in the median room.

    Desks and doors have numbers, too: those that are written alike in the most rooms are the rooms' own.
    """
    stamps = [label for label in labels if label.stamp is not None and (label.stamp.number or label.stamp.name)]
    counted = [(label, "") for label in stamps]
    if not stamps:
        counted = [(label, form) for label in labels if (form := _form_of(label))]
    if not counted:
        return 0.0
    points = shapely.points([[label.x, label.y] for label, _ in counted])
    pairs = _pairs(STRtree(points), [room.polygon for room in rooms], "intersects")
    if pairs is None:
        return float("inf")
    by_form: dict[str, NDArray[np.intp]] = defaultdict(lambda: np.zeros(len(rooms), np.intp))
    for room, label in pairs.T.tolist():
        by_form[counted[label][1]][room] += 1
    most_common = max(by_form.values(), key=lambda counts: int((counts > 0).sum()), default=np.zeros(1, np.intp))
    return float(np.median(most_common))


def _form_of(label: _Label) -> str | None:
    """How the number in a text is written, as 9.99 or A99; None without one."""
    match = _NUMBER.search(label.text.text[:MAX_TEXT]) if label.text is not None else None
    return _SIGNS.sub(_kind_of_sign, match[0]) if match else None


def _common_form(rooms: Iterable[Sequence[_Label]]) -> str | None:
    """The form of number that the most rooms have."""
    counts = Counter(form for labels in rooms for form in {_form_of(label) for label in labels} if form)
    return max(counts, key=lambda form: (counts[form], form), default=None)


def _without_other_numbers(labels: Sequence[_Label], form: str | None) -> list[_Label]:
    """The labels of a room without numbers of another form, as of desks, if it has one of this form."""
    if not any(_form_of(label) == form for label in labels):
        return list(labels)
    return [label for label in labels if not (_is_number(label) and _form_of(label) != form)]


def _is_number(label: _Label) -> bool:
    return label.text is not None and bool(_NUMBER.fullmatch(label.text.text.strip()[:MAX_TEXT]))


def _kind_of_sign(match: re.Match[str]) -> str:
    return "9" if match[0].isdigit() else "A"


_SIGNS = re.compile(r"[A-Za-z]+|\d")
_NUMBER = re.compile(r"(?<![\w.,])(?:[A-Za-z]{0,3}[-.]?\d{1,4})(?:[.\-]\w{1,4})*(?![\w.,²]|\s*(?:m|qm|sf|x|'))")


def _lie_side_by_side(shapes: Sequence[Polygon], metres: float | None) -> bool:
    """Whether shapes hardly overlap, and most of them have a neighbour behind a wall."""
    areas = np.array([shape.area for shape in shapes])
    reach = min(RELATIVE_REACH * sqrt(float(np.median(areas))), WALL_REACH / metres if metres else np.inf)
    array = np.array(shapes, object)
    pairs = _pairs(STRtree(array), shapely.buffer(array, reach, quad_segs=1), "intersects")
    if pairs is None:
        return False
    first, second = pairs[:, pairs[0] < pairs[1]]
    overlap = float(shapely.area(shapely.intersection(array[first], array[second])).sum())
    if overlap > MAX_OVERLAP * areas.sum():
        return False
    has_neighbour = np.isin(np.arange(len(shapes)), np.concatenate([first, second]))
    return len(shapes) == 1 or float(has_neighbour.mean()) >= MIN_NEIGHBOURS


def _covered(group: _Group, other: _Group) -> float:
    """The area of a group that the rooms of another one cover."""
    tree = STRtree([room.polygon for room in other.rooms])
    return float(sum(
        shapely.intersection(room.polygon, other.rooms[each].polygon).area
        for room in group.rooms
        for each in tree.query(room.polygon, predicate="intersects")
    ))  # fmt: skip


def _with_others(best: _Group, groups: Sequence[_Group]) -> tuple[DrawnRoom, ...]:
    """The rooms of a group, and those of other groups beside them, as where each use has a layer of its own."""
    rooms = list(best.rooms)
    for group in groups:
        if group is best:
            continue
        tree = STRtree([room.polygon for room in rooms])
        for room in group.rooms:
            met = tree.query(room.polygon, predicate="intersects")
            common = sum(shapely.intersection(room.polygon, rooms[each].polygon).area for each in met)
            if common <= MAX_OVERLAP * room.polygon.area:
                rooms.append(replace(room))
    return tuple(sorted(rooms, key=_reading_order))


def _reading_order(room: DrawnRoom) -> tuple[float, float]:
    left, _, _, top = room.polygon.bounds
    return -top, left


def corners_of(polygon: Polygon) -> Floats:
    """The corners of the shell of a polygon, shape (N, 2)."""
    return np.asarray(shapely.get_coordinates(polygon.exterior)[:-1])
