"""Plans of several pages: each page that shows a plan is read, and the pages are the storeys of one building."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pianta.errors import PlanError, PlanWarning
from pianta.io._files import short_repr
from pianta.io.drawings.pdf import count_pdf_pages
from pianta.io.images import Source, path_of
from pianta.plan.read_plan import PlanReading, read_plan
from pianta.plan.sheets.open_sheet import PDF_SUFFIX
from pianta.plan.text.storey_titles import find_storey_title

MAX_PAGES = 30  # that are read at once; each takes seconds
MAX_LISTED = 5  # pages in one message


def read_plan_pages(source: Source, **options: Any) -> tuple[PlanReading, ...]:  # noqa: ANN401  # those of read_plan
    """Read the pages of a plan, each as by `read_plan`.

    Parameters
    ----------
    source
        The plan. Of a PDF with several pages all are read, of other plans there is one.
    **options
        As of `read_plan`; with `page` that page alone is read.

    Returns
    -------
    tuple of PlanReading
        Of each page that shows a plan: in the order of the storeys if their titles say it, else of the pages. Floors
        are named by the titles, else by the pages.

    Raises
    ------
    PlanError
        No page shows a plan, or there are more than 30 pages.

    Warns
    -----
    PlanWarning
        Pages show no plan, or floors that other pages show one by one.
    """
    path = Path(path_of(source))
    count = 1
    if path.suffix.lower() == PDF_SUFFIX and options.get("page") is None:
        count = count_pdf_pages(path)
    if count == 1:
        return (read_plan(source, **options),)
    if count > MAX_PAGES:
        raise PlanError(
            f"plan {short_repr(path)} has {count} pages, more than {MAX_PAGES}, choose one, page=1 … page={count}"
        )
    readings, faults = _read_each(source, count, options)
    if not readings:
        raise PlanError(f"plan {short_repr(path)} has {count} pages and none shows a plan; page 1: {faults[1]}")
    messages = [f"{_list_pages(list(faults))} no plan, left out"] if faults else []
    overviews = _find_overviews(readings)
    if overviews:
        messages.append(f"{_list_pages(overviews)} floors that other pages show one by one, left out")
    for message in messages:
        warnings.warn(f"plan {short_repr(path)}: {message}", PlanWarning, stacklevel=2)
    return _name_pages({page: reading for page, reading in readings.items() if page not in overviews})


def _read_each(source: Source, count: int, options: dict[str, Any]) -> tuple[dict[int, PlanReading], dict[int, str]]:
    """The pages that show a plan, and what is wrong with the others, by page from 1."""
    readings: dict[int, PlanReading] = {}
    faults: dict[int, str] = {}
    for page in range(1, count + 1):
        try:
            with warnings.catch_warnings():
                # Each page would warn that it shows several floors, or that no text reader is installed
                warnings.simplefilter("ignore", PlanWarning)
                readings[page] = read_plan(source, **{**options, "page": page})
        except PlanError as error:
            faults[page] = str(error)
    return readings, faults


def _find_overviews(readings: dict[int, PlanReading]) -> list[int]:
    """The pages with several floors, if as many other pages show one floor each."""
    single = sum(len(reading.floors) == 1 for reading in readings.values())
    return [page for page, reading in readings.items() if 1 < len(reading.floors) <= single]


def _name_pages(readings: dict[int, PlanReading]) -> tuple[PlanReading, ...]:
    """The readings with named floors, the lowest first if the titles of all pages say how high they are."""
    titles = {
        page: find_storey_title(reading.sheet.texts or ()) if reading.sheet and len(reading.floors) == 1 else None
        for page, reading in readings.items()
    }
    levels = [title[1] for title in titles.values() if title is not None]
    by_title = len(levels) == len(set(levels)) == len(readings)
    names = {page: title[0] for page, title in titles.items() if title is not None and by_title}
    order = sorted(readings, key=lambda page: (titles[page] or ("", 0))[1]) if by_title else list(readings)
    return tuple(_name_floors(readings[page], names.get(page, f"page {page}")) for page in order)


def _name_floors(reading: PlanReading, name: str) -> PlanReading:
    if len(reading.floors) == 1:
        return replace(reading, floors=(replace(reading.floors[0], name=name),))
    named = (replace(floor, name=f"{name} floor {number}") for number, floor in enumerate(reading.floors, start=1))
    return replace(reading, floors=tuple(named))


def _list_pages(pages: Sequence[int]) -> str:
    """Such as page 3 shows, or pages 5, 6 and 2 more show."""
    if len(pages) == 1:
        return f"page {pages[0]} shows"
    listed = ", ".join(map(str, pages[:MAX_LISTED]))
    more = f" and {len(pages) - MAX_LISTED} more" if len(pages) > MAX_LISTED else ""
    return f"pages {listed}{more} show"
