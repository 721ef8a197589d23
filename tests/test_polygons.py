"""Only the polygons of a geometry."""

import pytest
import shapely
from shapely import GeometryCollection, LineString, MultiPolygon, Point, Polygon, box

from pianta.floor.polygons import find_largest_polygon, list_polygons

SMALL, LARGE, APART = box(0, 0, 1, 1), box(2, 0, 5, 2), box(7, 0, 8, 2)


@pytest.mark.parametrize(
    ("shape", "polygons"),
    [
        (SMALL, [SMALL]),
        (MultiPolygon([SMALL, LARGE]), [SMALL, LARGE]),
        (GeometryCollection([LineString([(0, 0), (1, 0)]), SMALL, Point(3, 3)]), [SMALL]),
        (GeometryCollection([MultiPolygon([SMALL, LARGE]), APART]), [SMALL, LARGE, APART]),
        ([SMALL, MultiPolygon([LARGE, APART])], [SMALL, LARGE, APART]),
        (GeometryCollection([Polygon(), Point(0, 0)]), []),
        (LineString([(0, 0), (1, 0)]), []),
        ([], []),
    ],
)
def test_polygons_without_lines_points_and_empty_ones(shape, polygons):
    assert list_polygons(shape) == polygons


def test_two_squares_that_share_a_side_have_no_area_in_common():
    assert list_polygons(shapely.intersection(SMALL, box(1, 0, 2, 1))) == []


def test_the_largest_polygon():
    assert find_largest_polygon(GeometryCollection([SMALL, LineString([(0, 0), (99, 0)]), LARGE])) == LARGE
    assert find_largest_polygon(LineString([(0, 0), (1, 0)])).is_empty
