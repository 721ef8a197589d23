"""A browser that looks at the page of `pianta view`; tests that need it are skipped without one."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Any

import pytest

from tests.served_floors import TOKEN, Client

# Longer than any answer takes on a busy machine, milliseconds.
PATIENCE_MS = 30_000


def open_browser() -> Iterator[Any]:
    """Chromium, as a fixture of a module gives it."""
    playwright = pytest.importorskip("playwright.sync_api", reason="install playwright to test the page in a browser")
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("there is no chromium on PATH to test the page in")
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield browser
        browser.close()


class Tab:
    """A tab with the page, and what went on in it. errors: of scripts. addresses: of its requests."""

    def __init__(self, context: Any, address: str) -> None:
        self.page = context.new_page()
        self.page.set_default_timeout(PATIENCE_MS)
        self.errors: list[str] = []
        self.addresses: list[str] = []
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("request", lambda request: self.addresses.append(request.url))
        self.page.on("dialog", lambda dialog: dialog.accept())
        self.page.goto(address)

    def wait_until(self, function: str, arg: Any = None) -> None:
        """Wait until a function of the page is true; Playwright's own way needs eval, which the page forbids."""
        end = monotonic() + PATIENCE_MS / 1000
        while not self.page.evaluate(function, arg):
            assert monotonic() < end, f"waited in vain for {function} of {arg}"
            self.page.wait_for_timeout(20)

    def wait_for_floor(self) -> "Tab":
        self.wait_until("globalThis.pianta?.session?.state !== undefined")
        self.page.wait_for_selector("#rooms tbody tr")
        return self

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Where a point of the map frame is in the window."""
        left, top = self.page.evaluate(
            """([x, y]) => {
                const box = document.getElementById("map").getBoundingClientRect();
                const point = globalThis.pianta.floorMap.map.latLngToContainerPoint([y, x]);
                return [box.left + point.x, box.top + point.y];
            }""",
            [x, y],
        )
        return left, top

    def color_of_room(self, x: float, y: float) -> list[int]:
        """Red, green, blue and opacity that the canvas of the rooms has at a point of the map frame."""
        color: list[int] = self.page.evaluate(
            """([x, y]) => {
                const canvas = document.querySelector(".leaflet-rooms-pane canvas");
                if (!canvas) return [0, 0, 0, 0];
                const box = canvas.getBoundingClientRect();
                const scale = canvas.width / box.width;
                const [column, row] = [(x - box.left) * scale, (y - box.top) * scale];
                return [...canvas.getContext("2d").getImageData(column, row, 1, 1).data];
            }""",
            self.pixel(x, y),
        )
        return color

    def wait_for_frame(self) -> None:
        """Wait until what has changed is drawn."""
        self.page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def click(self, *points: tuple[float, float]) -> None:
        """Click at points of the map frame, one after the other."""
        for point in points:
            self.page.mouse.click(*self.pixel(*point))

    def use(self, tool: str) -> None:
        self.page.click(f"#tools [data-tool={tool}]")

    def ids(self) -> list[int]:
        """The rooms in the list, in its order."""
        rows = self.page.locator("#rooms tbody tr[data-room]")
        return [int(row) for row in rows.evaluate_all("rows => rows.map((row) => row.dataset.room)")]

    def wait_for_ids(self, *ids: int) -> None:
        wanted = ",".join(map(str, ids))
        self.wait_until(
            """(wanted) => [...document.querySelectorAll("#rooms tbody tr[data-room]")]
                .map((row) => row.dataset.room).sort((a, b) => a - b).join() === wanted""",
            wanted,
        )

    def wait_for_text(self, selector: str, text: str) -> None:
        self.wait_until(
            "([selector, text]) => document.querySelector(selector)?.textContent.includes(text)", [selector, text]
        )

    def save(self) -> None:
        self.page.click("#save")
        self.wait_for_text("#hint", "Saved.")


@contextmanager
def opened_tab(browser: Any, client: Client, anchor: str = "", **options: Any) -> Iterator[Tab]:
    """A tab of its own at the page of a server; no script of it may fail."""
    context = browser.new_context(viewport={"width": 1200, "height": 800}, **options)
    tab = Tab(context, f"http://127.0.0.1:{client.port}/{TOKEN}/{anchor}")
    try:
        yield tab
        assert tab.errors == []
    finally:
        context.close()
