"""Areas that are written on plans, in square metres."""

from __future__ import annotations

import re
from typing import NamedTuple

SQUARE_FOOT = 0.3048**2  # m²
JO = 1.62  # m² of a mat, as Japanese advertisements must count at least (Fair Competition Code for Real Estate)
TSUBO = 400 / 121  # m², also the Korean pyeong and the Chinese ping
MAX_TEXT_LENGTH = 200  # characters of a text that may state areas: files of drawings may hold anything
MIN_AREA = 0.3  # m²: smaller numbers are no areas of rooms
MAX_AREA = 200_000.0  # m² of a building

_METRE = r"(?:m|м|rn)"
_POWER = r"(?:\s?[²2?]|\^2)"
_SQUARE_METRES = (
    rf"{_METRE}{_POWER}(?![\d.,]*\d)|㎡|q\.?\s?m(?![a-z])\.?|m\.?q\.?(?![a-z])|s\.?\s?q\.?\s?m(?:t|tr|s)?(?![a-z])\.?|"
    r"sq[.,]?\s?met(?:er|re)s?|square\s+met(?:er|re)s?|kvm|k-m2|кв\.?\s?м|平方米|平米|mètres?\s+carrés?|metros?\s+cuadrados?"
)
_SQUARE_FEET = (
    r"[gnr]?\.?s\.?\s?f\.?(?![a-z])|(?:sq[.,]?|square)\s?f(?:ee|oo)?t\.?|sq[.,]?\s?'|sqft|ft\s?[²2]|ft\^2|"
    r"pieds?\s+carrés?|pi\s?[²2]"
)
_MATS = r"帖|畳|疊|jo(?![a-z])|tatami|mats?(?![a-z])"
_TSUBO = r"坪|tsubo|평|pyeong|pyung"
_UNITS = (
    ("metres", _SQUARE_METRES, 1.0),
    ("feet", _SQUARE_FEET, SQUARE_FOOT),
    ("mats", _MATS, JO),
    ("tsubo", _TSUBO, TSUBO),
)
AREA = re.compile(
    r"(?<![\d.,'\"])(?P<number>\d{1,3}(?:[,.' ]\d{3})+(?!\d)(?:[.,]\d{1,2})?|\d{1,6}(?:[.,]\s?\d{1,3})?)\s*(?:"
    + "|".join(f"(?P<{name}>{pattern})" for name, pattern, _ in _UNITS)
    + r")",
    re.IGNORECASE,
)
_TOTAL = re.compile(
    r"total|gross|\bnet\b|\bgia\b|\bgfa\b|approx|overall|floor\s?(?:area|space)|living\s?(?:area|space)|internal\s+area|"
    r"wohnfl|nutzfl|grundfl|gesamt|superfici|surface|habitable|boarea|boyta|bostadsyta|asuinala|oppervlak|"
    r"sup\.|área|общая|площадь|面積|面积",
    re.IGNORECASE,
)


class WrittenArea(NamedTuple):
    """An area that a text states, m², and the step to which it is rounded, m²."""

    area: float
    step: float


def parse_areas(text: str) -> tuple[WrittenArea, ...]:
    """The areas in a text such as 20,96m², Kitchen 13 m2, 1,295 sq. ft., 6.7帖 or 18 qm; not lengths.

    A single ² that was read as a question mark counts, too.
    """
    if len(text) > MAX_TEXT_LENGTH:
        return ()
    areas = []
    for match in AREA.finditer(text):
        factor = next(factor for name, _, factor in _UNITS if match[name])
        number, decimals = _parse_number(match["number"])
        if MIN_AREA <= number * factor <= MAX_AREA:
            areas.append(WrittenArea(number * factor, 10.0**-decimals * factor))
    return tuple(areas)


def states_total(text: str) -> bool:
    """Whether a text says that its area is that of a whole floor or flat."""
    return len(text) <= MAX_TEXT_LENGTH and bool(_TOTAL.search(text))


def _parse_number(text: str) -> tuple[float, int]:
    """A number and how many decimals it has; signs before groups of three digits do not separate decimals."""
    plain = text.replace(" ", "")
    *groups, last = re.split(r"[.,']", plain)
    if groups and len(last) == 3:
        return float("".join((*groups, last))), 0
    integer = "".join(groups) or last
    return (float(f"{integer}.{last}"), len(last)) if groups else (float(last), 0)
