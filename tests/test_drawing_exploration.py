"""Pictures of explorations: what is drawn where."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image, ImageSequence

from pianta.errors import OptionError, PiantaError
from pianta.exploration.classical_policies import NearestFrontier
from pianta.exploration.explore import explore
from pianta.plot.exploration import (
    FRONTIER_COLOR,
    check_animation,
    draw_exploration,
    plot_area,
    plot_exploration,
    save_animation,
)
from pianta.plot.figure import save_figure
from tests.explored_worlds import two_room_world


@pytest.fixture(scope="module")
def world():
    return two_room_world()


@pytest.fixture(scope="module")
def run(world):
    return explore(world, NearestFrontier(), starts=[(2, 3.5)], robots=2)


@pytest.mark.slow
def test_the_map_has_the_greys_of_what_was_known_and_orange_frontiers(world, run):
    ax = plot_exploration(run, world, ax=Figure().add_subplot(), scan=0)
    colors = np.asarray(ax.images[0].get_array())
    orange = (colors == tuple(bytes.fromhex(FRONTIER_COLOR[1:]))).all(axis=2)
    assert orange.any()
    assert (run.map.cells[orange] == 0).all()
    unseen = (run.scan_of_cell != 0) & ~orange
    assert np.unique(colors[unseen]).tolist() == [228, 243]
    assert (colors[unseen & world.free] == 243).all()
    final = np.asarray(plot_exploration(run, world, ax=Figure().add_subplot()).images[0].get_array())
    assert (final[run.map.cells == 100] == 110).all()


def test_tracks_end_where_robots_were_at_the_scan(world, run):
    for scan in (0, 1, len(run.area) - 1):
        ax = plot_exploration(run, world, ax=Figure().add_subplot(), scan=scan)
        for number in range(2):
            moves = np.count_nonzero(run.robot[: scan + 1] == number)
            line = np.column_stack(ax.lines[3 * number].get_data())
            expected = run.tracks[number][:moves, :2] - world.origin[:2]
            assert line.shape == expected.shape
            assert np.allclose(line, expected)


def test_the_curve_is_the_share_over_the_metres(run):
    ax = plot_area(run, ax=Figure().add_subplot())
    assert np.array_equal(ax.lines[0].get_xdata(), run.distance)
    assert np.array_equal(ax.lines[0].get_ydata(), 100 * run.share)
    assert ax.get_ylabel() == f"% of {run.reachable_area:.0f} m²"
    assert np.size(plot_area(run, ax=Figure().add_subplot(), scan=1).lines[0].get_xdata()) == 2


@pytest.mark.slow
def test_the_picture_is_the_same_for_the_same_run(world, run, tmp_path):
    for name in ("one.png", "two.png"):
        save_figure(draw_exploration(run, world), tmp_path / name)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()
    with Image.open(tmp_path / "one.png") as image:
        assert image.size[0] == 1600


@pytest.mark.slow
def test_the_animation_has_the_given_number_of_frames_and_rests(world, run, tmp_path):
    save_animation(run, world, tmp_path / "run.gif", frames=3)
    with Image.open(tmp_path / "run.gif") as image:
        # Pillow joins the same frames at the end to one that lasts.
        assert len(list(ImageSequence.Iterator(image))) == 3
        assert image.size == tuple(round(side * 100) for side in draw_exploration(run, world).get_size_inches())
        image.seek(2)
        assert image.info["duration"] == 1100


def test_an_animation_that_cannot_be_made_is_refused(monkeypatch):
    with pytest.raises(OptionError, match="animation is 'avi', give gif, mp4 or none"):
        check_animation("avi")
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter.isAvailable", lambda: False)
    with pytest.raises(OptionError, match="needs ffmpeg, which is not installed; give gif"):
        check_animation("mp4")


def test_a_missing_folder_is_an_error_in_one_line(world, run, tmp_path):
    with pytest.raises(PiantaError, match="cannot"):
        save_figure(draw_exploration(run, world), tmp_path / "nowhere" / "picture.png")
