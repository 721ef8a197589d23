"""Draw the picture of the README that shows `pianta view`: an office in the browser, with a selected room.

Run: OMP_NUM_THREADS=1 python docs/draw_view.py

Needs Chromium on PATH and the package playwright.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread

from playwright.sync_api import sync_playwright

import pianta
from pianta.view.folders import find_folders
from pianta.view.server import listen, make_app, make_server

IMAGE = Path(__file__).parent / "images" / "view.png"
TOKEN = "picture"  # noqa: S105 - of a server that lives as long as this script
SIZE = {"width": 1280, "height": 800}
ROOM = 10


def main() -> None:
    """Write the picture."""
    with TemporaryDirectory() as folder:
        office = Path(folder) / "office"
        pianta.make_world("sample")[1].save(Path(folder) / "map.yaml")
        pianta.read(Path(folder) / "map.yaml", building_type="office").save(office)
        listener = listen()
        server = make_server(make_app(find_folders([office]), token=TOKEN))
        thread = Thread(target=server.run, kwargs={"sockets": [listener]})
        thread.start()
        try:
            photograph(f"http://127.0.0.1:{listener.getsockname()[1]}/{TOKEN}/")
        finally:
            server.should_exit = True
            thread.join()


def photograph(address: str) -> None:
    """Open the page, select a room, and save what the window shows."""
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport=SIZE)
        page.goto(address)
        page.locator("#rooms tbody tr").nth(ROOM - 1).click()
        page.wait_for_timeout(500)
        page.screenshot(path=IMAGE)
        browser.close()


if __name__ == "__main__":
    main()
