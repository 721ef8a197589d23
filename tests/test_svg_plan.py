"""SVGs are read as drawings: transforms applied, y up, roles by names, and no external file is fetched."""

import socket
import sys
import warnings
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pianta.errors import PlanError, PlanWarning
from pianta.io.drawings import _layers
from pianta.io.drawings import svg as svg_plan
from pianta.io.drawings._drawing import ROLES, PlanDrawing, Role
from pianta.io.drawings.svg import read_svg_plan
from tests.mutation import mutated, refused_in_one_line

pytest.importorskip("svgelements", reason="pianta[svg] is not installed")

SPACES = (
    'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
    'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
)
STROKE = 'stroke="black" fill="none"'
# An open leaf that points upwards, hinged at the origin; the door is to the right.
LEAF = '<path d="M0 0 V-9 A9 9 0 0 1 9 0"/>'


def svg(*content: str, **attributes: object) -> str:
    attribute_text = " ".join(f'{name.replace("_", "-")}="{value}"' for name, value in attributes.items())
    return f"<svg {SPACES} {attribute_text}>{''.join(content)}</svg>"


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("svg") / "plan.svg"


def read(path: Path, *content: str, **attributes: object) -> PlanDrawing:
    path.write_text(svg(*content, **attributes))
    return read_svg_plan(path)


def lines_of(drawing: PlanDrawing, role: Role = "other") -> list[list[float]]:
    """Lines of a role as x0, y0, x1, y1, to a thousandth."""
    return np.asarray(np.round(drawing.lines[drawing.roles == ROLES.index(role)], 3) + 0.0).reshape(-1, 4).tolist()


def ends(door: NDArray[np.float64]) -> list[tuple[float, float]]:
    return sorted((x, y) for x, y in (np.round(door, 2) + 0.0).tolist())


def test_transforms_of_all_groups_apply_and_y_goes_up(path):
    inner = f'<g transform="scale(2) rotate(90)"><line x1="1" y1="0" x2="3" y2="0" {STROKE} stroke-width="0.5"/></g>'
    drawing = read(path, f'<g transform="translate(10, 20)">{inner}</g>')
    assert lines_of(drawing) == [[10, -22, 10, -26]]
    assert drawing.widths == pytest.approx([1.0])
    assert (drawing.metres_per_unit, drawing.source) == (None, "plan.svg")


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ('<rect x="1" y="2" width="3" height="4"/>', [[1, -2, 4, -2], [4, -2, 4, -6], [4, -6, 1, -6], [1, -6, 1, -2]]),
        ('<polyline points="0,0 1,0 1 1"/>', [[0, 0, 1, 0], [1, 0, 1, -1]]),
        ('<polygon points="0,0 1,0 1 1"/>', [[0, 0, 1, 0], [1, 0, 1, -1], [1, -1, 0, 0]]),
        ('<path d="m1 1h2v2z"/>', [[1, -1, 3, -1], [3, -1, 3, -3], [3, -3, 1, -1]]),
        ('<path d="M0 0H1M5 5V6"/>', [[0, 0, 1, 0], [5, -5, 5, -6]]),
    ],
)
def test_straight_shapes(path, shape, expected):
    assert lines_of(read(path, f"<g {STROKE}>{shape}</g>")) == expected


@pytest.mark.parametrize(
    "shape",
    [
        '<circle cx="50" cy="50" r="10"/>',
        '<path d="M60 50A10 10 0 1 1 40 50A10 10 0 1 1 60 50"/>',
        '<ellipse cx="25" cy="50" rx="5" ry="10" transform="scale(2 1)"/>',
        '<path d="M60 50 C60 55.5228 55.5228 60 50 60"/>',
    ],
)
def test_curves_become_chains_on_them(path, shape):
    points = read(path, f"<g {STROKE}>{shape}</g>").lines
    assert len(points) >= 16
    assert np.hypot(points[..., 0] - 50, points[..., 1] + 50) == pytest.approx(10, rel=2e-3)


def test_quadratic_curves_pass_their_middle(path):
    points = read(path, f'<path d="M0 0Q10 10 20 0" {STROKE}/>').lines
    assert np.hypot(*np.moveaxis(points - (10, -5), -1, 0)).min() < 1e-9


def test_use_symbols_and_viewports(path):
    symbol = f'<symbol id="s" viewBox="0 0 10 10"><line x1="0" y1="0" x2="10" y2="10" {STROKE}/></symbol>'
    used = '<use xlink:href="#s" x="5" y="5" width="20" height="20"/><use href="#nowhere"/>'
    plain = f'<line id="l" x2="1" {STROKE}/><use href="#l" y="3" transform="translate(0 1)"/>'
    nested = f'<svg x="100" viewBox="0 0 1 1" width="4" height="2"><line x2="1" {STROKE}/></svg>'
    drawing = read(path, f"<defs>{symbol}</defs>", used, plain, nested, viewBox="0 0 999 1", width="10mm")
    assert lines_of(drawing) == [[5, -5, 15, -15], [0, 0, 1, 0], [0, -4, 1, -4], [101, 0, 103, 0]]


def test_roles_by_ids_classes_and_labels_from_the_inside(path):
    line = f'<line x2="{{}}" {STROKE} {{}}/>'
    drawing = read(
        path,
        f'<g inkscape:label="Wände">{line.format(1, "")}<g class="a window">{line.format(2, "")}</g></g>',
        f'<g id="walls">{line.format(3, chr(105) + "d=" + chr(34) + "door1" + chr(34))}</g>',
        line.format(4, 'id="path12"'),
    )
    assert [lines_of(drawing, role) for role in ROLES] == [
        [[0, 0, 1, 0]],
        [[0, 0, 3, 0]],
        [[0, 0, 2, 0]],
        [[0, 0, 4, 0]],
    ]


def test_doors_lie_between_jambs(path):
    """A swing in its group, a mirrored one by `use`, and a plain rectangle in a wall; all white."""
    group = f'<g class="Door" fill="none" stroke="black" transform="translate(100 0)">{LEAF}</g>'
    used = f'<defs><g id="door-900">{LEAF}</g></defs><use href="#door-900" transform="translate(50 50) scale(-1 1)"/>'
    plain = '<rect id="door3" x="10" y="80" width="9" height="1" fill="white"/>'
    drawing = read(path, group, used, plain)
    assert [ends(door) for door in drawing.doors] == [
        [(100, 0), (109, 0)],
        [(41, -50), (50, -50)],
        [(10, -80.5), (19, -80.5)],
    ]


def test_doors_of_one_layer_are_distinguished_and_a_leaf_is_no_door(path):
    shapes = '<line x1="0" y1="0" x2="0" y2="-9"/><path d="M0 -9A9 9 0 0 1 9 0"/>'
    layer = f'<g inkscape:label="Doors" {STROKE}>{shapes}<g transform="translate(30 0)">{shapes}</g></g>'
    assert [ends(door) for door in read(path, layer).doors] == [[(0, 0), (9, 0)], [(30, 0), (39, 0)]]


def test_only_dark_areas_and_walls_are_filled(path):
    square = '<path d="M{0} 0h9v9h-9zm3 3h3v3h-3z" {1}/>'
    drawing = read(
        path,
        square.format(0, ""),
        square.format(20, 'fill="#eee"'),
        square.format(40, 'fill="#eee" stroke="none" class="wall"'),
        square.format(60, 'fill="white" class="wall" stroke="#000"'),
        square.format(80, 'style="fill:#fff;fill-opacity:0"'),
        square.format(100, 'fill="url(#gradient)"'),
        square.format(120, 'fill="rgba(0,0,0,0.1)"'),
        '<line x2="1" stroke="#ffffff"/>',
    )
    bounds = sorted({(outline[:, 0].min() // 20 * 20, outline[:, 0].max() // 20 * 20) for outline in drawing.fills})
    assert bounds == [(0, 0), (40, 40)]
    halves = [abs(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])) / 2 for x, y in (outline.T for outline in drawing.fills)]
    assert sum(halves) == pytest.approx(2 * (81 - 9)), "without their holes"
    assert len(lines_of(drawing, "wall")) == 16, "outlines of the filled wall and of the drawn one"
    assert lines_of(drawing) == []


def test_shapes_with_a_role_and_no_style_are_lines(path):
    drawing = read(path, '<g id="walls"><line x2="5"/><path d="M0 1H5"/></g><line x2="9"/>')
    assert lines_of(drawing, "wall") == [[0, 0, 5, 0], [0, -1, 5, -1]]
    assert (lines_of(drawing), drawing.fills) == ([], ())


@pytest.mark.parametrize(
    "hidden",
    ['style="display: none"', 'display="none"', 'visibility="hidden"', 'opacity="0"', 'class="gone"', 'id="none"'],
)
def test_hidden_elements_are_left_out(path, hidden):
    css = "<style>/* rules */ .gone, #none { display:none !important } g line { display: none }</style>"
    hidden_group = f'<g {hidden}><g><line x2="1" {STROKE}/></g><text>no</text></g>'
    drawing = read(path, css, hidden_group, f'<line x2="2" {STROKE}/>', f'<defs><line x2="3" {STROKE}/></defs>')
    assert lines_of(drawing) == [[0, 0, 2, 0]]
    assert drawing.texts == ()


def test_style_sheets_give_strokes(path):
    css = "<style>.thin{stroke:#000;stroke-width:0.25;fill:none} rect.thin{stroke-width:2}</style>"
    drawing = read(path, css, '<line class="x thin" x2="1"/><rect class="thin" width="1" height="1"/>')
    assert drawing.widths.tolist() == [0.25, 2, 2, 2, 2]


def test_texts_are_placed_by_their_middle(path):
    drawing = read(
        path,
        f'<line x2="1" {STROKE}/><g font-size="10">',
        '<text x="20" y="20" text-anchor="middle" transform="rotate(90 20 20)">Office <tspan>1</tspan></text>',
        '<text x="0" y="50">Lab</text><text x="0" y="50" text-anchor="end" style="font-size:7.5pt">End</text>',
        '<text><tspan x="0" y="70">Main</tspan> <tspan x="0" y="80">Hall</tspan></text><text> </text></g>',
    )
    placed = {text.text: (text.x, text.y, text.height, text.angle) for text in drawing.texts}
    assert placed == {
        "Office 1": pytest.approx((23.5, -20, 7, -pi / 2)),
        "Lab": pytest.approx((9, -46.5, 7, 0)),
        "End": pytest.approx((-9, -46.5, 7, 0)),
        "Main Hall": pytest.approx((13.5, -71.5, 7, 0)),
    }


def test_metres_come_from_their_attribute_alone(path):
    assert read(path, f'<line x2="1" {STROKE}/>', data_metres_per_unit="0.01").metres_per_unit == 0.01
    assert read(path, f'<line x2="1" {STROKE}/>', width="210mm", viewBox="0 0 210 297").metres_per_unit is None
    for value in ("0", "-1", "nan", "1 cm"):
        with pytest.raises(PlanError, match=f"data-metres-per-unit='{value}'"):
            read(path, f'<line x2="1" {STROKE}/>', data_metres_per_unit=value)


def test_embedded_pictures_and_damaged_shapes_are_left_out_with_a_warning(path):
    picture = '<image href="data:image/png;base64,AA=="/>'
    bad = f'<path d="M0 0 L q z" {STROKE}/><g transform="turn(5)"/>'
    with pytest.warns(PlanWarning, match="images"):
        drawing = read(path, picture, bad, picture, f'<line x2="1" {STROKE}/>')
    assert lines_of(drawing) == [[0, 0, 1, 0]]


@pytest.mark.parametrize(
    ("content", "target"),
    [
        ('<use href="file:///etc/passwd#x"/>', "file:///etc/passwd#x"),
        ('<use href="other.svg#x"/>', "other.svg#x"),
        ('<rect fill="url(http://a.b/c.svg#g)"/>', "http://a.b/c.svg#g"),
        ("<rect style=\"filter: URL( '//a.b' )\"/>", "//a.b"),
        ('<style>@import "http://a.b/c.css";</style>', '@import "http://a.b/c.css"'),
        ("<style>@font-face{src:url(font.woff)}</style>", "font.woff"),
    ],
)
def test_references_to_the_outside_are_refused(path, content, target):
    with pytest.raises(PlanError) as caught:
        read(path, content, f'<line x2="1" {STROKE}/>')
    assert repr(target) in str(caught.value)


def test_scripts_are_ignored(path):
    content = f'<line x2="1" {STROKE}/><script href="http://a.b/c.js"/><script>document.write("x")</script>'
    assert lines_of(read(path, content)) == [[0, 0, 1, 0]]


@pytest.mark.parametrize("target", ["http://a.b/c.png", "plan.png", "file:///etc/passwd"])
def test_linked_images_are_left_out_and_not_fetched(path, target, monkeypatch):
    monkeypatch.setattr(socket, "socket", None)
    with pytest.warns(PlanWarning, match="1 image that cannot be read, left out"):
        drawing = read(path, f'<line x2="1" {STROKE}/><image xlink:href="{target}"/>')
    assert lines_of(drawing) == [[0, 0, 1, 0]]


def test_references_to_the_inside_and_links_are_not(path):
    content = (
        f'<a href="http://a.b"><line x2="1" {STROKE} clip-path="url(#c)"/></a><style>.x{{fill:url(\'#g\')}}</style>'
    )
    assert lines_of(read(path, content)) == [[0, 0, 1, 0]]


PUBLIC = '"-//W3C//DTD SVG 1.1//EN" "http://127.0.0.1:9/svg11.dtd"'


@pytest.mark.parametrize(
    "declared",
    [
        f"<!DOCTYPE svg PUBLIC {PUBLIC}>",
        f'<?xml version="1.0" encoding="UTF-8" standalone="no"?>\n<!-- Inkscape -->\n<!DOCTYPE svg PUBLIC {PUBLIC}>\n',
        '<!DOCTYPE svg SYSTEM "file:///etc/passwd">',
        "<!DOCTYPE svg>",
    ],
)
def test_a_document_type_is_skipped_and_nothing_is_fetched(path, monkeypatch, declared):
    path.write_text(declared + svg(f'<line x2="1" {STROKE}/>'))
    monkeypatch.setattr(socket, "socket", None)
    assert lines_of(read_svg_plan(path)) == [[0, 0, 1, 0]]


OWN_TYPE = "entities"
LOL = '<!DOCTYPE svg [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]>'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (LOL + svg("<text>&b;</text>"), OWN_TYPE),
        ('<!DOCTYPE svg SYSTEM "http://a.b/svg.dtd" []>' + svg(), OWN_TYPE),
        ('<!DOCTYPE svg [<!ATTLIST line x2 CDATA "9">]>' + svg(), OWN_TYPE),
        (f'<!DOCTYPE svg PUBLIC {PUBLIC} [<!ENTITY % a SYSTEM "file:///etc/passwd"> %a;]>' + svg(), OWN_TYPE),
        (f"<!DOCTYPE svg PUBLIC {PUBLIC}>" + svg("<text>&ns;</text>"), "SVG"),
        (svg(f'<line x2="1" {STROKE}/>')[:-9], "SVG"),
        ("<svg", "SVG"),
        ("<html/>", "html"),
        (svg(), "lines"),
        (svg('<line x2="1e400" stroke="red"/>'), "lines"),
        ("", "empty"),
    ],
)
def test_files_without_a_plan_are_refused_in_one_line(path, text, message):
    path.write_text(text)
    with pytest.raises(PlanError, match=message) as caught:
        read_svg_plan(path)
    assert "\n" not in str(caught.value)


def test_a_missing_library_is_named(path, monkeypatch):
    monkeypatch.setitem(sys.modules, "svgelements", None)
    with pytest.raises(PlanError, match=r"pianta\[svg\]"):
        read(path)


def test_groups_that_multiply_without_end_are_refused(path, monkeypatch):
    monkeypatch.setattr(svg_plan, "MAX_ELEMENTS", 1000)
    laughs = "".join(
        f'<g id="g{level}">{f"<use href={chr(34)}#g{level - 1}{chr(34)}/>" * 10}</g>' for level in range(9)
    )
    with pytest.raises(PlanError, match="1000"):
        read(path, laughs)
    with pytest.raises(PlanError, match="64"):
        read(path, "<g>" * 100, "</g>" * 100)
    with pytest.raises(PlanError, match="64"):
        read(path, '<g id="a"><use href="#a"/></g>')


@settings(max_examples=60)
@given(data=st.data())
def test_damaged_files_are_read_or_refused_in_one_line(path, data):
    text = svg(
        f'<g class="door" {STROKE} transform="rotate(30)">{LEAF}</g><style>.w{{fill:#000}}</style>',
        '<text x="1" y="2" font-size="3">Office</text><rect class="w wall" x="1" y="1" width="5%" height="2"/>',
        f'<polygon points="1 2 3 4 5 9"/><use href="#a"/><circle id="a" r="{sqrt(2)}"/>',
    )
    path.write_bytes(data.draw(mutated(text.encode())))
    with refused_in_one_line(), warnings.catch_warnings():
        warnings.simplefilter("ignore", PlanWarning)
        read_svg_plan(path)


def test_lines_end_at_clip_paths(path):
    """The clip is the box 2 … 4 × 0 … 10 of the group, moved by 1, and within that the box of the line's own clip."""
    paths = (
        '<clipPath id="c"><rect x="2" y="0" width="2" height="10"/></clipPath>'
        '<clipPath id="half"><rect x="0" y="0" width="3" height="10"/></clipPath>'
    )
    line = f'<line x1="0" y1="5" x2="9" y2="5" {STROKE}/>'
    clipped = f'<g transform="translate(1)" clip-path="url(#c)">{line}</g>'
    assert lines_of(read(path, paths, clipped)) == [[3, -5, 5, -5]]
    twice = f'<g clip-path="url(#c)"><g style="clip-path: url(#half)">{line}</g>{line}</g>{line}'
    assert lines_of(read(path, paths, twice)) == [[2, -5, 3, -5], [2, -5, 4, -5], [0, -5, 9, -5]]


def test_areas_and_texts_end_at_clip_paths(path):
    clip = '<clipPath id="c" transform="scale(2)"><path d="M0 0 H2 V2 H0 Z"/></clipPath>'
    shapes = (
        '<rect x="2" width="8" height="3" clip-path="url(#c)"/>'
        '<g clip-path="url(#c)"><text x="0" y="3" font-size="2">in</text><text x="8" y="3">out</text></g>'
    )
    drawing = read(path, clip, shapes)
    assert [text.text for text in drawing.texts] == ["in"]
    (fill,) = drawing.fills
    assert (*fill.min(axis=0), *fill.max(axis=0)) == (2, -3, 4, 0)


def test_clips_without_area_hide_and_those_of_bounding_boxes_do_not(path):
    empty = '<clipPath id="c"/>'
    box = '<clipPath id="b" clipPathUnits="objectBoundingBox"><rect width="1" height="1"/></clipPath>'
    lines = f'<line x2="1" {STROKE} clip-path="url(#c)"/><line x2="2" {STROKE} clip-path="url(#b)"/>'
    assert lines_of(read(path, empty, box, lines)) == [[0, 0, 2, 0]]


def test_many_large_clips_are_refused(path, monkeypatch):
    monkeypatch.setattr(_layers, "MAX_CLIPPED_CORNERS", 100)
    clip = '<clipPath id="c"><circle r="5"/></clipPath>'
    line = f'<line x2="1" {STROKE} clip-path="url(#c)"/>'
    assert lines_of(read(path, clip, line)) == [[0, 0, 1, 0]]
    with pytest.raises(PlanError, match="clips too many things"):
        read(path, clip, line, line)


@pytest.mark.parametrize(("fill", "count"), [("#999999", 1), ("#800000", 1), ("red", 0), ("#a900e6", 0), ("#bbb", 0)])
def test_fills_of_departments_are_no_poche(path, fill, count):
    """Dark fills are those whose brightest channel is at most 0.6."""
    drawing = read(path, f'<rect width="5" height="5" fill="{fill}"/><line x2="1" {STROKE}/>')
    assert len(drawing.fills) == count


def test_clips_that_only_touch_hide_everything_and_crossing_ones_hold(path):
    """Two boxes with a side in common; a bow tie, whose two halves are both inside."""
    clips = (
        '<clipPath id="left"><rect width="5" height="9"/></clipPath>'
        '<clipPath id="right"><rect x="5" width="5" height="9"/></clipPath>'
        '<clipPath id="bow"><path d="M0 0 L10 10 V0 L0 10 Z"/></clipPath>'
    )
    line = f'<line x1="0" y1="5" x2="10" y2="5" {STROKE}/>'
    touching = f'<g clip-path="url(#left)"><g clip-path="url(#right)">{line}</g></g>'
    bow = f'<line x1="1" y1="-9" x2="1" y2="30" {STROKE} clip-path="url(#bow)"/>'
    assert lines_of(read(path, clips, touching, bow)) == [[1, -1, 1, -9]]


def test_clips_with_too_many_corners_are_ignored(path):
    zigzag = " ".join(f"L{k % 2 * 9} {k % 7}" for k in range(6000))
    clip = f'<clipPath id="c"><path d="M0 0 {zigzag} Z"/></clipPath>'
    assert lines_of(read(path, clip, f'<line x2="90" {STROKE} clip-path="url(#c)"/>')) == [[0, 0, 90, 0]]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("<g>" * 1000 + f"<path d='M0 0H9' {STROKE}/>" + "</g>" * 1000, "elements more than 200 deep"),
        (
            f"<defs><path id='p' d='M0 0{'L1 1L2 3' * 5000}' {STROKE}/></defs>" + "<use href='#p'/>" * 5000,
            "more than 5000000 corners|more than [0-9]+ lines",
        ),
    ],
    ids=["nested", "used"],
)
def test_content_that_takes_the_square_of_its_length_is_refused(path, content, message):
    with pytest.raises(PlanError, match=message):
        read(path, content)


@pytest.mark.parametrize("css", ["a" * 200_000, "/*" * 100_000, "}" * 200_000, "a{" * 100_000, "a,{}" * 50_000])
def test_style_sheets_without_rules_take_no_time(css):
    """Each took 30 s and more by expressions that start again at each letter."""
    assert set(svg_plan._parse_rules(css)) <= {"", "a"}


def test_rules_of_style_sheets_have_comments_and_lists_of_selectors():
    css = "/* no {stroke: red} */ .a, #b { stroke: black; width: 3 } @media print { path { fill: none } } c{}"
    rules = svg_plan._parse_rules(css)
    assert rules[".a"] == rules["#b"] == {"stroke": "black"}
    assert rules["path"] == {"fill": "none"}
    assert rules["c"] == {}
