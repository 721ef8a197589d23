"""Areas, sizes and lengths as plans write them, in many languages and as the text reader takes them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.plan.text.areas import parse_areas, states_total
from pianta.plan.text.sizes import parse_possible_lengths, parse_possible_sizes


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("20,96m²", [20.96]),
        ("20.96 m²", [20.96]),
        ("13 m2", [13]),
        ("13m^2", [13]),
        ("41m?", [41]),
        ("3 rn2", [3]),
        ("14,55 м²", [14.55]),
        ("12 кв. м", [12]),
        ("18 qm", [18]),
        ("45,20 mq", [45.2]),
        ("45,20 m.q.", [45.2]),
        ("24 kvm", [24]),
        ("12.5 sqm", [12.5]),
        ("12.5 SQ.M.", [12.5]),
        ("TOTAL AREA 59.1 sq.m.", [59.1]),
        ("120.31 sq. metres", [120.31]),
        ("120.31 square meters", [120.31]),
        ("16㎡", [16]),
        ("16.5平米", [16.5]),
        ("Chambre 11,2 m² env.", [11.2]),
        ("209 sf", [19.417]),
        ("209 S.F.", [19.417]),
        ("209 SQ FT", [19.417]),
        ("209 sqft", [19.417]),
        ("209 square feet", [19.417]),
        ("209 ft²", [19.417]),
        ("209 GSF", [19.417]),
        ("1,295 sq. ft.", [120.309]),
        ("1295 sq, feet (120.31 sq, metres)", [120.309, 120.31]),
        ("1.295,5 m²", [1295.5]),
        ("1 295 m²", [1295]),
        ("6.7帖", [10.854]),
        ("6畳", [9.72]),
        ("6.7 jo", [10.854]),
        ("10 tsubo", [33.058]),
        ("10坪", [33.058]),
        ("5.16 × 3.48m", []),
        ("12 m", []),
        ("3.5 m", []),
        ("204", []),
        ("BH=700", []),
        ("204 French", []),
        ("M2 2", []),
        ("0 m²", []),
        ("", []),
        ("9" * 300 + " m²", []),
    ],
)
def test_areas(text, metres):
    assert [area.area for area in parse_areas(text)] == pytest.approx(metres, abs=0.001)


def test_an_area_is_as_exact_as_it_is_written():
    assert [parse_areas(text)[0].step for text in ("13 m²", "13,5 m²", "13.52 m²")] == pytest.approx([1, 0.1, 0.01])
    assert parse_areas("209 sf")[0].step == pytest.approx(0.0929, abs=1e-4)


@pytest.mark.parametrize("text", ["Total 85 m²", "Wohnfläche: 85 m²", "GIA 85 m²", "Superficie 85 mq", "Approx. 85 m2"])
def test_totals_are_named(text):
    assert states_total(text)
    assert not states_total("Bedroom 13 m²")


@pytest.mark.parametrize(
    ("text", "sizes"),
    [
        ("12'8\"x11'2\"", [(3.861, 3.404)]),
        ("(16'7\"x13'7\")", [(5.055, 4.140)]),
        ("12’8”×11’2”", [(3.861, 3.404)]),
        ("12′8″ X 11′2″", [(3.861, 3.404)]),
        ("12'-6 1/2\" x 10'-0\"", [(3.823, 3.048)]),
        ("9' 6½\" x 8'", [(2.908, 2.438)]),
        ("5'-10''x7'-2''", [(1.778, 2.184)]),
        ("12 ft 6 in x 10 ft", [(3.81, 3.048)]),
        ("BEDROOM 11' x 10'", [(3.353, 3.048)]),
        ("67.0 x 41-6", [(20.422, 12.649)]),
        # As the text reader takes them
        ("11'1* × 13'6\"", [(3.378, 4.115)]),
        ('8\'2" x 5°3"', [(2.489, 1.6)]),
        ("10'× 67\"", [(3.048, 2.007)]),
        ("4.50×2.08m", [(4.5, 2.08)]),
        ("3,50 x 4,20", [(3.5, 4.2)]),
        ("3.5m x 4m", [(3.5, 4)]),
        ("350 x 420 cm", [(3.5, 4.2)]),
        ("322 X 347", [(3.22, 3.47)]),
        ("3.2*4.1", [(0.975, 1.25), (3.2, 4.1)]),
        # Without a unit there are several ways to read a size
        ("12 x 11", [(3.658, 3.353), (12, 11)]),
        ("3220x3470", [(32.2, 34.7), (3.22, 3.47)]),
        ("2 x 3 x 4 m", []),
        ("22.0×", []),
        ("box 3 x", []),
        ("12", []),
        ("0 x 0 m", []),
        ("", []),
    ],
)
def test_sizes_in_all_possible_units(text, sizes):
    parsed = sorted(parse_possible_sizes(text))
    assert parsed == [pytest.approx(size, abs=0.001) for size in sorted(sizes)]


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("3900", [39.0, 3.9]),
        ("390", [3.9]),
        ("3,90", [3.9]),
        ("3.90 m", [3.9]),
        ("350 cm", [3.5]),
        ("12'-6\"", [3.81]),
        ("50'", [15.24]),
        ("12", []),
        ("2.4", []),
        ("1-2", []),
        ("A 3900", []),
        ("", []),
    ],
)
def test_lengths_in_all_possible_units(text, metres):
    assert sorted(parse_possible_lengths(text)) == pytest.approx(sorted(metres))


@given(st.text(alphabet="0123456789.,'\"x×*²mftsqinc -/½帖", max_size=60))
def test_any_measure_is_parsed_without_error(text):
    assert all(area.area > 0 for area in parse_areas(text))
    assert all(min(size) > 0 for size in parse_possible_sizes(text))
    assert all(length > 0 for length in parse_possible_lengths(text))


@given(st.integers(4, 60), st.integers(0, 11), st.integers(4, 60), st.integers(0, 11))
def test_feet_and_inches_of_both_sides_add_up(feet, inches, other_feet, other_inches):
    (size,) = parse_possible_sizes(f"{feet}'{inches}\" x {other_feet}'{other_inches}\"")
    assert size == pytest.approx((0.3048 * feet + 0.0254 * inches, 0.3048 * other_feet + 0.0254 * other_inches))
