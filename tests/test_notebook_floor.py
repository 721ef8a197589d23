"""A floor as a notebook shows it: the page in a frame without rights."""

import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from pianta.floor import Floor
from tests.browser import open_browser
from tests.served_floors import FLOOR

HOSTILE = '"><img src=x onerror="top.document.title=1"></script><script>top.document.title=1</script>'


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    yield from open_browser()


def show(browser: Any, html: str | None, tmp_path: Path) -> Any:
    """A page with the HTML of a cell between others, and what went wrong in it."""
    file = tmp_path / "notebook.html"
    assert html
    text = f"<!doctype html><meta charset=utf-8><title>notebook</title><p id=before>In</p>{html}<p id=after>Out</p>"
    file.write_text(text, encoding="utf-8")
    page = browser.new_page(viewport={"width": 1200, "height": 800})
    page.addresses = []
    page.on("request", lambda request: page.addresses.append(request.url))
    page.goto(f"file://{file}")
    return page


def test_a_floor_without_rooms_has_no_page():
    assert Floor(())._repr_html_() is None


def test_the_frame_may_run_scripts_and_nothing_else():
    html = FLOOR._repr_html_()
    assert html is not None
    (opening,) = re.findall(r"<iframe [^>]*>", html)
    assert html == f"{opening}</iframe>"
    attributes = dict(re.findall(r'([\w-]+)="([^"]*)"', opening))
    assert attributes.keys() == {"sandbox", "title", "srcdoc", "style"}
    assert attributes["sandbox"] == "allow-scripts"
    assert "height: 520px" in attributes["style"]
    assert unescape(attributes["srcdoc"]).startswith("<!doctype html>")


def test_names_end_no_attribute():
    hostile = replace(FLOOR, source=HOSTILE, rooms=(replace(FLOOR.rooms[0], name=HOSTILE), *FLOOR.rooms[1:]))
    html = hostile._repr_html_()
    assert html is not None
    assert html.count("<") == 2
    assert html.count(">") == 2


def test_it_needs_no_server():
    code = """
import sys
sys.modules.update(dict.fromkeys(("fastapi", "uvicorn", "starlette")))
import pianta
from shapely import box
assert "<iframe" in pianta.Floor((pianta.Room(1, box(0, 0, 4, 3)),))._repr_html_()
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=120)


def test_it_is_shown_in_a_browser(browser, tmp_path):
    page = show(browser, FLOOR._repr_html_(), tmp_path)
    frame = page.frame_locator("iframe")
    frame.locator("#rooms tbody tr").first.wait_for()
    assert frame.locator("#rooms tbody tr").count() == 3
    # Texts are placed after the list
    frame.locator(".room-text").nth(2).wait_for()
    assert sorted(frame.locator(".room-text").all_text_contents()) == ["1\nOFFICE", "2\nBar\nKITCHEN", "3\nCORRIDOR"]
    frame.locator("#rooms tbody tr", has_text="KITCHEN").click()
    assert "Room 2" in frame.locator("#selected").inner_text()
    assert page.locator("iframe").bounding_box()["height"] == pytest.approx(520, abs=2)
    # What follows in the notebook is below it.
    assert page.locator("#after").bounding_box()["y"] > 520
    assert {address.split(":")[0] for address in page.addresses} <= {"file", "data", "about"}
    page.close()


def test_names_are_text_in_it(browser, tmp_path):
    rooms = (replace(FLOOR.rooms[0], name=HOSTILE), *FLOOR.rooms[1:])
    page = show(browser, replace(FLOOR, source=HOSTILE, rooms=rooms)._repr_html_(), tmp_path)
    frame = page.frame_locator("iframe")
    frame.locator("#rooms tbody tr").first.wait_for()
    assert HOSTILE in frame.locator("#rooms").inner_text()
    assert frame.locator("img[src=x]").count() == 0
    assert page.locator("img").count() == 0
    assert page.title() == "notebook"
    page.close()


def test_two_floors_in_a_notebook(browser, tmp_path):
    other = replace(FLOOR, rooms=FLOOR.rooms[:1], doors=())
    page = show(browser, f"{FLOOR._repr_html_()}{other._repr_html_()}", tmp_path)
    for number, rooms in ((0, 3), (1, 1)):
        rows = page.frame_locator("iframe").nth(number).locator("#rooms tbody tr")
        rows.first.wait_for()
        assert rows.count() == rooms
    page.close()
