"""Sizes of rooms that are written on plans, such as 12'8"x11'2", 4.50 x 2.08m and 322 X 347, in all possible units."""

from __future__ import annotations

import re

FOOT, INCH = 0.3048, 0.0254  # m
MAX_TEXT_LENGTH = 200  # characters of a text that may state a size: files of drawings may hold anything
SHORTEST_SIDE = 0.5  # m of a room
LONGEST_SIDE = 60.0  # m
SHORTEST_LENGTH = 0.1  # m of a dimension
LONGEST_LENGTH = 200.0  # m
# Numbers without a unit, by what plans write: 12 x 11 feet, 3.2 x 4.5 m, 322 x 347 cm, 3220 x 3470 mm
SHORTEST_CM = 100
SHORTEST_MM = 1000
SHORTEST_FEET = 3
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "ft": FOOT}

# Quotes of every kind, and signs as which the text reader takes them
_SIGNS = str.maketrans(
    {"’": "'", "‘": "'", "`": "'", "´": "'", "′": "'", "°": "'", "“": '"', "”": '"', "″": '"', "„": '"', "¨": '"'}
    | dict.fromkeys("×хХ✕✖", "x")
    | {"½": " 1/2", "¼": " 1/4", "¾": " 3/4", "⅛": " 1/8", "⅜": " 3/8", "⅝": " 5/8", "⅞": " 7/8"}
)
_FRACTION = r"(?:[ -]?\d{1,2}\s?/\s?\d{1,2})?"
_FEET = (
    rf"(?P<feet>\d{{1,3}}(?:\.\d{{1,2}})?)\s*(?:'(?!')|ft\b\.?|feet\b)"
    rf"(?:\s*-?\s*(?P<inches>\d{{1,2}}{_FRACTION})(?!\d))?\s*(?:[\"*']{{1,2}}|in\b\.?)?"
)
_JOINED = r"(?P<joined>\d{2,3})\s*\""
_DASHED = r"(?P<dashed>\d{1,3}\s?-\s?\d{1,2}(?!\d))"
_METRIC = r"(?P<number>\d{1,5}(?:[.,]\d{1,3})?)\s*(?P<unit>mm|cm|m(?![a-z²2]))?\.?"
_SIDE = re.compile(rf"(?:{_FEET}|{_JOINED}|{_DASHED}|{_METRIC})", re.IGNORECASE)
_AFTER_NUMBER = r"(?:(?:mm|cm|m|ft|feet|in)\b\.?\s*(?:\d[\d/ -]*(?:\"|in\b\.?))?)?[\"']{0,2}"
_ANY_SIDE, _UNSTARRED_SIDE = (rf"\d[\d.,'\"/ {sign}-]*{_AFTER_NUMBER}" for sign in ("*", ""))
_SIZE = re.compile(rf"(?<![\dx.,])({_ANY_SIDE})\s*(?:x|by)\s*({_ANY_SIDE})", re.IGNORECASE)
_STARRED = re.compile(rf"({_UNSTARRED_SIDE})\s*\*\s*({_UNSTARRED_SIDE})", re.IGNORECASE)
_SEVERAL = re.compile(r"\d\W*(?:x|by)\W*[\d.,]+\W*(?:x|by)\W*\d", re.IGNORECASE)


def parse_possible_sizes(text: str) -> tuple[tuple[float, float], ...]:
    """The two sides, m, that a size in a text may mean; none without a size.

    A unit at one side is that of both. Without one, every unit counts in which the sides are those of a room.
    Quotes may be of any kind, and may be misread. Sizes of three lengths are not of rooms.
    """
    if len(text) > MAX_TEXT_LENGTH:
        return ()
    plain = text.translate(_SIGNS)
    match = _SIZE.search(plain) or _STARRED.fullmatch(plain.strip(" ()"))
    if match is None or _SEVERAL.search(plain):
        return ()
    first, second = (_read_side(side.strip()) for side in match.groups())
    stated = [set(side) for side in (first, second) if len(side) == 1]
    units = set.intersection(*stated) if stated else first.keys() & second.keys()
    sides = [(first.get(unit, 0.0), second.get(unit, 0.0)) for unit in sorted(units)]
    return tuple(size for size in sides if min(size) >= SHORTEST_SIDE and max(size) <= LONGEST_SIDE)


def parse_possible_lengths(text: str) -> tuple[float, ...]:
    """The metres that a length alone, such as 3900, 3,90, 12'-6" or 350 cm, may mean; none for other texts.

    A number of less than three digits without a unit counts only with two decimals: rooms are numbered.
    """
    plain = text.translate(_SIGNS).strip(" ()") if len(text) <= MAX_TEXT_LENGTH else ""
    if re.fullmatch(r"\d{1,2}(?:[.,]\d|\s?-\s?\d{1,2})?", plain):
        return ()
    lengths = (metres for _, metres in sorted(_read_side(plain).items()))
    return tuple(metres for metres in lengths if SHORTEST_LENGTH <= metres <= LONGEST_LENGTH)


def _read_side(text: str) -> dict[str, float]:
    """The metres of a side by each unit that it may have."""
    match = _SIDE.fullmatch(text)
    if match is None:
        return {}
    if match["feet"]:
        return {"ft": float(match["feet"]) * FOOT + parse_inches(match["inches"] or "0") * INCH}
    if match["joined"]:
        # The sign for feet was not read: 67" is 6'7", 1011" is 10'11"
        feet, inches = (match["joined"][:-1], match["joined"][-1])
        return {"ft": int(feet) * FOOT + int(inches) * INCH}
    if match["dashed"]:
        feet, inches = (int(part) for part in match["dashed"].split("-"))
        return {"ft": feet * FOOT + inches * INCH} if inches < 12 else {}
    number, value = match["number"], float(match["number"].replace(",", "."))
    if match["unit"]:
        return {match["unit"].lower(): value * UNITS[match["unit"].lower()]}
    is_whole = number.isdecimal()
    # Feet are not written with a decimal comma, nor with two decimals
    in_feet = (is_whole or re.fullmatch(r"\d+\.\d", number) is not None) and SHORTEST_FEET <= value < SHORTEST_CM
    possible = {"m": value < SHORTEST_CM, "ft": in_feet}
    possible |= {"cm": is_whole and value >= SHORTEST_CM, "mm": is_whole and value >= SHORTEST_MM}
    return {unit: value * UNITS[unit] for unit, is_possible in possible.items() if is_possible}


def parse_inches(text: str) -> float:
    """Inches such as 6, 6 1/2 or 1/2."""
    integer, _, fraction = text.replace("-", " ").replace(" /", "/").rpartition(" ") if "/" in text else (text, "", "")
    above, _, below = fraction.partition("/")
    return float(integer or 0) + (float(above) / max(float(below), 1) if below else 0.0)
