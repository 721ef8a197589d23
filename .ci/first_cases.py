"""A pytest plugin that runs the first case alone of each test with parameters: for versions, not for values.

TEST_SHARE, such as 2/3: only the tests of every third file, from the second one on.
"""

from __future__ import annotations

import os

import pytest


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out all cases of a test but the first, and the files that are not in the share."""
    part, parts = map(int, os.environ.get("TEST_SHARE", "1/1").split("/"))
    files = set(sorted({item.path for item in items})[part - 1 :: parts])
    first: dict[tuple[object, ...], pytest.Item] = {}
    for item in items:
        first.setdefault((item.path, getattr(item, "cls", None), getattr(item, "originalname", item.name)), item)
    chosen = {item for item in first.values() if item.path in files}
    config.hook.pytest_deselected(items=[item for item in items if item not in chosen])
    items[:] = [item for item in items if item in chosen]
