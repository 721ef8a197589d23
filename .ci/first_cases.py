"""A pytest plugin that runs the first case alone of each test with parameters: for versions, not for values."""

from __future__ import annotations

import pytest


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out all cases of a test but the first."""
    first: dict[tuple[object, ...], pytest.Item] = {}
    for item in items:
        first.setdefault((item.path, getattr(item, "cls", None), getattr(item, "originalname", item.name)), item)
    chosen = set(first.values())
    config.hook.pytest_deselected(items=[item for item in items if item not in chosen])
    items[:] = [item for item in items if item in chosen]
