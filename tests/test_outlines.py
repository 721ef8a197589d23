import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy import ndimage
from shapely import LineString, MultiPolygon, Point, Polygon, box

from pianta.layout._label_images import join_outlines, largest_part, outline_labels


def outline(*rows: str) -> dict[int, Polygon]:
    """Outlines of a label image that is drawn with digits; - is a label of -1."""
    labels = np.array([[-1 if cell == "-" else int(cell) for cell in row] for row in rows])
    outlines, numbers = outline_labels(labels)
    return dict(zip(numbers.tolist(), shapely.normalize(outlines), strict=True))


def test_an_outline_follows_the_sides_of_the_cells():
    outlines = outline("0110", "0110", "0133")
    assert list(outlines) == [1, 3]
    assert outlines[1].equals(Polygon([(1, 0), (3, 0), (3, 2), (2, 2), (2, 3), (1, 3)]))
    assert outlines[3].equals(box(2, 2, 4, 3))


def test_a_label_around_another_has_a_hole():
    outlines = outline("11111", "12201", "11111")
    assert outlines[1].equals(box(0, 0, 5, 3) - box(1, 1, 4, 2))
    assert outlines[2].equals(box(1, 1, 3, 2))


def test_parts_that_touch_by_a_corner_are_two_and_the_larger_stays():
    assert outline("1100", "0011", "0011") == {1: box(2, 1, 4, 3).normalize()}


def test_a_hole_that_touches_the_outside_by_a_corner_stays_a_hole():
    (ring,) = outline("01110", "11011", "01111", "01110").values()
    assert ring.is_valid
    assert ring.area == 14
    (pinched,) = outline("110", "101", "111").values()
    assert pinched.is_valid
    assert pinched.area == 7


def test_only_positive_labels_are_rooms():
    assert outline("-0", "1-") == {1: box(0, 1, 1, 2).normalize()}
    assert outline("-0", "--") == {}
    assert outline("0") == {}


def test_neighbours_share_the_corners_on_their_common_side():
    outlines = outline("12", "13", "13")
    assert (1, 1) in outlines[1].exterior.coords


labels = arrays(np.int32, array_shapes(min_dims=2, max_dims=2, max_side=9), elements=st.integers(-1, 3))


@given(labels)
def test_outlines_are_a_coverage_by_the_largest_parts(image):
    outlines, numbers = outline_labels(image)
    assert numbers.tolist() == np.unique(image[image > 0]).tolist()
    assert shapely.is_valid(outlines).all()
    assert shapely.coverage_is_valid(outlines)
    for shape, number in zip(outlines, numbers, strict=True):
        parts, count = ndimage.label(image == number)
        sizes = np.bincount(parts.ravel(), minlength=count + 1)[1:]
        assert shape.area == sizes.max()
        rows, cols = np.nonzero(image == number)
        assert shapely.contains_xy(shape, cols + 0.5, rows + 0.5).sum() == shape.area


@pytest.mark.parametrize(
    ("shape", "largest"),
    [
        (box(0, 0, 1, 1), box(0, 0, 1, 1)),
        (MultiPolygon([box(0, 0, 1, 1), box(5, 0, 7, 1)]), box(5, 0, 7, 1)),
        # An hour-glass that crosses itself at (1, 1).
        (Polygon([(0, 0), (3, 3), (3, 0), (0, 3)]), Polygon([(0, 0), (1.5, 1.5), (0, 3)])),
        (shapely.union_all([box(0, 0, 1, 1), LineString([(3, 3), (9, 9)])]), box(0, 0, 1, 1)),
        (Point(0, 0), Polygon()),
        (Polygon(), Polygon()),
    ],
)
def test_the_largest_polygon_of_a_geometry(shape, largest):
    part = largest_part(shape)
    assert isinstance(part, Polygon)
    assert part.area == pytest.approx(largest.area)
    assert part.is_valid


def test_a_part_inside_a_collection_is_found():
    # Two squares that touch along a line which one of them only grazes: repair gives polygons and a line.
    shape = Polygon([(0, 0), (2, 0), (2, 2), (4, 2), (4, 4), (6, 4), (4, 4), (4, 2), (2, 2), (2, 1), (0, 1)])
    assert not shape.is_valid
    assert largest_part(shape).area == pytest.approx(2.0)


def test_a_corner_on_the_side_of_a_neighbour_becomes_a_corner_of_both():
    # The room on the left has one long side, where the two on the right meet.
    rooms = np.array([box(0, 0, 2, 4), box(2, 0, 4, 2), box(2, 2, 4, 4)])
    assert not shapely.coverage_is_valid(rooms)
    joined = join_outlines(rooms)
    assert shapely.coverage_is_valid(joined)
    assert shapely.equals(joined, rooms).all()
    assert (2.0, 2.0) in joined[0].exterior.coords


def test_the_overlap_of_two_outlines_belongs_to_the_first():
    joined = join_outlines(np.array([box(0, 0, 2.001, 4), box(2, 0, 4, 4)]))
    assert shapely.coverage_is_valid(joined)
    assert shapely.area(joined) == pytest.approx([8.004, 7.996])


def test_a_hole_of_a_room_contains_the_room_in_it():
    inner = box(1, 1, 2, 2)
    joined = join_outlines(np.array([box(0, 0, 3, 3) - inner, inner]))
    assert shapely.area(joined) == pytest.approx([8.0, 1.0])
    assert shapely.coverage_is_valid(joined)


def test_an_outline_that_touches_itself_stays_valid_when_it_is_turned():
    # Its hole touches its side in the middle, where no corner is.
    outline = Polygon(box(0, 0, 3, 3).exterior.coords, [[(0, 1.37), (1.1, 0.5), (1.1, 2.3)]])
    (joined,) = join_outlines(np.array([outline]))
    assert joined.area == pytest.approx(outline.area)
    assert all(shapely.affinity.rotate(joined, angle, origin=(17.3, -5.1)).is_valid for angle in range(0, 360, 7))
