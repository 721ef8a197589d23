"""Pictures of predictions: shades, frames, numbers and bars."""

from functools import cache

import networkx as nx
import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Circle, PathPatch

from pianta.errors import PiantaError
from pianta.generation.type_model import learn_type
from pianta.plot.figure import save_figure
from pianta.plot.graphs import place_nodes
from pianta.plot.prediction import (
    AVERAGE_COLOR,
    OPEN_COLOR,
    PREDICTED_COLOR,
    SHADE_COLOR,
    TRUE_COLOR,
    choose_sample,
    draw_prediction,
    plot_explored,
    plot_known_part,
    plot_label_shares,
    plot_sample,
    plot_skeleton,
)
from pianta.prediction.explored_part import ExploredPart
from pianta.prediction.prediction import Prediction, predict
from pianta.prediction.revealed_floor import RevealedFloor, reveal_corridors
from pianta.prediction.unexplored_part import SampledFloor
from tests.generated_types import SCHOOL, make_schools, make_wing


@cache
def predicted() -> tuple[Prediction, RevealedFloor]:
    """A prediction for the fourth school, with one of four corridors explored, by a model of the other schools."""
    schools = make_schools()
    truth = reveal_corridors(schools[3], SCHOOL, corridors=1)
    return predict(truth.part, learn_type([*schools[:3], *schools[4:]], SCHOOL), count=8), truth


@pytest.fixture
def ax():
    return Figure().add_axes((0, 0, 1, 1))


def shade_of(ax) -> list[PathPatch]:
    return [
        patch for patch in ax.patches if isinstance(patch, PathPatch) and to_hex(patch.get_facecolor()) == SHADE_COLOR
    ]


def covers(ax, position) -> bool:
    """Whether a position is in the shade."""
    return any(patch.get_path().contains_point(position) for patch in shade_of(ax))


def frames_of(ax) -> list[tuple[float, float]]:
    """The middles of the red frames."""
    return [patch.get_center() for patch in ax.patches if to_hex(patch.get_edgecolor()) == OPEN_COLOR]


def texts_of(ax) -> list[str]:
    return [text.get_text() for text in ax.texts]


class TestKnownPart:
    def test_shades_known_rooms_and_the_edges_between_them(self, ax):
        graph = make_wing("CCS")
        plot_known_part(graph, [0, 1], ax=ax, schema=SCHOOL)
        positions = {node: np.array(position) for node, position in place_nodes(graph).items()}
        assert [covers(ax, positions[node]) for node in graph] == [True, True, False, False]
        assert covers(ax, (positions[0] + positions[1]) / 2)
        assert not covers(ax, positions[0] + 0.7 * (positions[2] - positions[0]))
        assert sum(isinstance(patch, Circle) for patch in ax.patches) == 3

    def test_rooms_without_a_label_have_a_question_mark_and_open_corridors_a_frame(self, ax):
        graph = make_wing("CC")
        graph.nodes[2]["label"] = None
        plot_known_part(graph, [0, 1], ax=ax, schema=SCHOOL, open_ends=[0], names={0: "$corridor"})
        assert texts_of(ax) == ["?", "$corri"]
        (frame,) = frames_of(ax)
        assert frame == pytest.approx(place_nodes(graph)[0])

    @pytest.mark.parametrize("known_nodes", [[], [0, 1, 2]])
    def test_none_or_all_is_known(self, ax, known_nodes):
        plot_known_part(make_wing("CC"), known_nodes, ax=ax, schema=SCHOOL)
        assert len(shade_of(ax)) == bool(known_nodes)


class TestPanels:
    def test_what_is_explored_has_a_mark_for_each_open_end(self, ax):
        prediction, _ = predicted()
        plot_explored(prediction, ax=ax)
        explored = prediction.explored
        assert len(frames_of(ax)) == len(explored.open) == 2
        assert texts_of(ax).count("?") == len(explored.doors)
        positions = place_nodes(explored.graph)
        assert all(covers(ax, positions[node]) == (node in explored.known_graph) for node in explored.graph)
        assert f"{len(explored.known_graph)} rooms known" in ax.get_title()

    def test_the_truth_is_the_whole_floor(self, ax):
        prediction, truth = predicted()
        plot_explored(prediction, ax=ax, truth=truth)
        positions = place_nodes(truth.graph)
        assert {node for node in truth.graph if covers(ax, positions[node])} == truth.graph.nodes - set(truth.unknown)
        corridors = {str(prediction.explored.graph.nodes[node]["room"]) for node in prediction.explored.corridors}
        assert set(texts_of(ax)) == corridors

    def test_a_sample_has_the_known_part_shaded(self, ax):
        prediction, _ = predicted()
        sample = choose_sample(prediction)
        plot_sample(sample, prediction, ax=ax)
        positions = place_nodes(sample.graph)
        assert {node for node in sample.graph if covers(ax, positions[node])} == {*sample.known_nodes.values()}
        assert len(frames_of(ax)) == len(prediction.explored.open)
        assert f"{len(sample.graph)} rooms" in ax.get_title()

    def test_the_sample_is_of_middle_size_and_has_the_expected_labels(self):
        """Six samples of 2 to 8 rooms around a known corridor; one of the two with 4 and 5 rooms has only gyms."""
        samples = [sample_rooms(rooms) for rooms in ("C", "CC", "GGG", "CCCS", "CCCCCC", "CCCCCCC")]
        explored = ExploredPart("", nx.empty_graph(1), frozenset({0}), (0,), {})
        explored.graph.nodes[0].update(label="CORRIDOR", room=0)
        prediction = Prediction(explored, tuple(samples), SCHOOL, {})
        assert choose_sample(prediction) is samples[3]


def sample_rooms(rooms: str) -> SampledFloor:
    """A sample with a known corridor and unknown rooms."""
    return SampledFloor(make_wing(rooms), {0: 0}, {})


class TestSkeleton:
    def test_edges_are_as_wide_as_probable_and_numbered(self, ax):
        skeleton = nx.Graph()
        skeleton.add_nodes_from([("a", {"probability": 1.0}), ("b", {"probability": 1.0})])
        skeleton.add_nodes_from([(("beyond", "b"), {"probability": 0.4}), ("door", {"probability": 0.02})])
        skeleton.add_edge("a", "b", probability=1.0)
        skeleton.add_edge("b", ("beyond", "b"), probability=0.4)
        skeleton.add_edge("a", "door", probability=0.02)
        plot_skeleton(skeleton, ax=ax)
        assert sorted(texts_of(ax)) == ["40", "?", "a", "b"]
        certain, uncertain = ax.lines
        assert certain.get_linewidth() > uncertain.get_linewidth()
        assert certain.get_alpha() > uncertain.get_alpha() == 0.5

    def test_a_floor_without_corridors_has_none(self, ax):
        plot_skeleton(nx.Graph(), ax=ax)
        assert not ax.patches


class TestLabelShares:
    def test_each_label_has_a_bar_of_each_distribution(self, ax):
        predicted_shares, average = {"GYM": 0.25, "CLASSROOM": 0.75}, {"CLASSROOM": 0.9, "CLOSET": 0.1}
        plot_label_shares(predicted_shares, average, ax=ax, true={"CLASSROOM": 1.0, "LAB": 0.001})
        assert [text.get_text() for text in ax.get_xticklabels()] == ["CLASSROOM", "GYM", "CLOSET"]
        heights = {
            bars.get_label(): ([bar.get_height() for bar in bars], to_hex(bars[0].get_facecolor()))
            for bars in ax.containers
        }
        assert heights == {
            "true": ([100, 0, 0], TRUE_COLOR),
            "average of the model": ([90, 0, 10], AVERAGE_COLOR),
            "predicted": ([75, 25, 0], PREDICTED_COLOR),
        }
        lefts = [bar.get_x() for bars in ax.containers for bar in bars]
        assert len(set(np.round(lefts, 6))) == 9

    def test_without_a_truth_there_is_no_bar_for_it(self, ax):
        plot_label_shares({}, {"CLOSET": 1.0}, ax=ax)
        assert [bars.get_label() for bars in ax.containers] == ["average of the model", "predicted"]


class TestPicture:
    @pytest.mark.parametrize("with_truth", [False, True])
    def test_has_four_panels_and_a_legend_of_labels(self, with_truth):
        prediction, truth = predicted()
        figure = draw_prediction(prediction, truth=truth if with_truth else None)
        assert len(figure.axes) == 4
        (legend,) = figure.legends
        assert "CORRIDOR" in [text.get_text() for text in legend.get_texts()]
        bars = [container.get_label() for container in figure.axes[3].containers]
        assert ("true" in bars) == with_truth

    @pytest.mark.slow
    def test_the_same_prediction_has_the_same_bytes(self, tmp_path):
        prediction, truth = predicted()
        for name in ("one.png", "other.png"):
            save_figure(draw_prediction(prediction, truth=truth), tmp_path / name)
        assert (tmp_path / "one.png").read_bytes() == (tmp_path / "other.png").read_bytes()

    @pytest.mark.slow
    def test_a_file_that_cannot_be_written_is_an_error(self, tmp_path):
        with pytest.raises(PiantaError, match="missing"):
            save_figure(draw_prediction(predicted()[0]), tmp_path / "missing" / "picture.png")
