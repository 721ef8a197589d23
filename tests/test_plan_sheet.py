"""The contact sheet of drawn floors."""

from shapely import box

from pianta.floor import Floor, Room
from pianta.labels import SCHOOL
from pianta.plot.plan_sheet import CELL, draw_plan_sheet


def make_floor(*labels: str) -> Floor:
    rooms = tuple(
        Room(number, box(5 * number, 0, 5 * number + 4, 3), label=label) for number, label in enumerate(labels, 1)
    )
    return Floor(rooms, building_type={"school": 1.0})


def test_the_legend_has_each_label_of_any_floor_once():
    floors = [make_floor("CLASSROOM", "GYM"), make_floor("GYM", "CORRIDOR", "GYM")]
    figure = draw_plan_sheet(floors, ["a", "b"], schema=SCHOOL)
    (legend,) = figure.legends
    assert sorted(text.get_text() for text in legend.get_texts()) == ["CLASSROOM", "CORRIDOR", "GYM"]
    assert [ax.get_title() for ax in figure.axes] == ["a", "b"]
    assert figure.get_figwidth() == 2 * CELL
    bottom = min(ax.get_position().y0 for ax in figure.axes) * figure.get_figheight()
    assert bottom > 0.3


def test_a_single_floor_fills_the_sheet():
    figure = draw_plan_sheet([make_floor("CLASSROOM")], ["a"], schema=SCHOOL)
    assert figure.get_figwidth() == CELL
