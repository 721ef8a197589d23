import numpy as np
import pytest

from pianta.layout.structure.wall_lines import WallLines, find_wall_lines, span_walls
from tests.drawn_maps import carve


def test_a_plain_room_has_one_line_per_wall_with_the_wall_outside():
    lines = find_wall_lines(carve((140, 180), (20, 120, 20, 160)), resolution=0.05)

    middle = np.array([69.5, 89.5])
    assert len(lines) == 4
    assert (((lines.points - middle) * lines.towards).sum(axis=1) > 45).all()
    np.testing.assert_allclose(np.sort(np.abs(lines.along[:, 0])), [0, 0, 1, 1], atol=0.02)


def test_two_faces_in_line_are_one_line():
    space = carve((140, 240), (20, 120, 20, 220))
    space[60:64, 20:80] = space[60:64, 100:150] = False

    lines = find_wall_lines(space, resolution=0.05)

    upper = (np.abs(lines.points[:, 0] - 59) < 2) & (lines.towards[:, 0] > 0.9)
    assert upper.sum() == 1


def test_a_slanted_half_wall_is_found():
    rows, cols = np.indices((200, 240))
    direction = np.array([np.sin(np.radians(20)), np.cos(np.radians(20))])
    across = (rows - 100) * direction[1] - (cols - 120) * direction[0]
    space = carve((200, 240), (20, 180, 20, 220)) & ~((np.abs(across) < 2.5) & (cols < 120))

    lines = find_wall_lines(space, resolution=0.05)

    turned = np.degrees(np.arccos(np.abs(lines.along @ direction).clip(0, 1)))
    assert (turned < 2).sum() == 2


@pytest.mark.parametrize("space", [carve((50, 50)), carve((50, 50), (20, 24, 20, 24))])
def test_a_map_without_walls_has_no_lines(space):
    assert len(find_wall_lines(space, resolution=0.05)) == 0


@pytest.mark.parametrize(("face", "length"), [((30, 90), 60), ((59, 60), None)])
def test_a_wall_spans_its_face_and_a_single_sample_is_no_wall(face, length):
    """A line along row 60 whose wall, below it, has its face in some columns; space is on both sides elsewhere."""
    space = np.ones((120, 120), bool)
    space[60:, face[0] : face[1]] = False
    lines = WallLines(np.array([(59.0, 59.0)]), np.array([(0.0, 1.0)]), np.array([(1.0, 0.0)]))
    walls = span_walls(lines, space, reach=2.5, gap=0.9, resolution=0.05)
    lengths = [round(float(np.hypot(*(end - start)))) for start, end in walls]
    assert lengths == ([pytest.approx(length, abs=6)] if length else [])
