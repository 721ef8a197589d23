"""Figures of pyplot that no window shows, and that are gone afterwards."""

from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

from matplotlib import pyplot


@contextmanager
def hiding_figures() -> Iterator[None]:
    """A block in which pyplot draws into memory, and whoever shows a figure fails."""
    with pyplot.rc_context({"backend": "agg"}), patch.object(pyplot, "show", side_effect=AssertionError("shown")):
        try:
            yield
        finally:
            pyplot.close("all")
