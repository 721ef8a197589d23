"""Settings shared by all tests."""

import os
from pathlib import Path

import cv2
import pytest
from hypothesis import settings

cv2.setNumThreads(1)
settings.register_profile("pianta", deadline=None, derandomize=True)
settings.load_profile("pianta")

DATA = Path(os.environ.get("PIANTA_DATA") or Path(__file__).parents[2] / "shared" / "data")


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real maps and ground truth; tests that need it are skipped where it is missing."""
    if not DATA.is_dir():
        pytest.skip(f"no real maps in {DATA}, set PIANTA_DATA to the folder that holds them")
    return DATA
