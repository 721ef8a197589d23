"""Settings shared by all tests."""

import os
from pathlib import Path
from time import monotonic

import cv2
import pytest
from hypothesis import settings

from tests.more_examples import choose_fuzzed

cv2.setNumThreads(1)
settings.register_profile("pianta", deadline=None, derandomize=True)
settings.register_profile("properties", deadline=None, print_blob=True)
PROFILE = os.environ.get("HYPOTHESIS_PROFILE") or "pianta"
settings.load_profile(PROFILE)
# No test of `make properties` starts later.
PROPERTIES_END = monotonic() + float(os.environ.get("PROPERTY_SECONDS") or "inf")

DATA = Path(os.environ.get("PIANTA_DATA") or Path(__file__).parents[2] / "shared" / "data")


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark what needs the real maps."""
    if "data" in getattr(item, "fixturenames", ()):
        item.add_marker("data")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """`make properties` runs the tests of hypothesis only, each time in another order, so that all have their turn."""
    if PROFILE == "properties":
        # All processes of pytest-xdist need the same order, and know the same id of the run.
        items[:], others = choose_fuzzed(items, os.environ.get("PYTEST_XDIST_TESTRUNUID"))
        config.hook.pytest_deselected(items=others)


def pytest_runtest_setup() -> None:
    if PROFILE == "properties" and monotonic() > PROPERTIES_END:
        pytest.skip("PROPERTY_SECONDS are over")


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real maps and ground truth; tests that need it are skipped where it is missing."""
    if not DATA.is_dir():
        pytest.skip(f"no real maps in {DATA}, set PIANTA_DATA to the folder that holds them")
    return DATA
