"""XML of untrusted origin, parsed without entities or references and with a limit on its size."""

from __future__ import annotations

from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree.ElementTree import ParseError

from defusedxml import DefusedXmlException, ElementTree

from pianta.errors import BuildingError
from pianta.io._files import one_line_reason, short_repr

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MAX_FILE_BYTES = 16 * 2**20  # 30 times the largest layout XML of the thesis' data


def parse_xml(file: Path) -> Element:
    """The root element of a building's file.

    Raises BuildingError, in one line, for a file that is too large, no XML, or declares a document type or entities.
    """
    check_building_size(file)
    try:
        root: Element = ElementTree.parse(file, forbid_dtd=True).getroot()
    except DefusedXmlException:
        raise BuildingError(f"building {short_repr(file)} declares a document type or entities, remove them") from None
    except (ParseError, ValueError, LookupError, OSError) as exception:
        fault = f"building {short_repr(file)} is no XML: {one_line_reason(exception)}"
        raise BuildingError(f"{fault}; give a drawn building, `pianta read` reads maps") from None
    return root


def check_building_size(file: Path) -> None:
    """Raise BuildingError, in one line, for a file of more than MAX_FILE_BYTES."""
    if file.stat().st_size > MAX_FILE_BYTES:
        raise BuildingError(
            f"building {short_repr(file)} has more than {MAX_FILE_BYTES} bytes, too many for a building, give one floor"
        )


def parse_number(text: str | None, *, limit: float) -> float:
    """A number rounded to 1e-6, finer than any drawing; nan for other text, or beyond ±limit."""
    try:
        number = float(text or nan)
    except ValueError:
        return nan
    return round(number, 6) if isfinite(number) and abs(number) <= limit else nan
