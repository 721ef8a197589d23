"""Damaged copies of valid files, for fuzzing readers."""

from collections.abc import Iterator
from contextlib import contextmanager

from hypothesis import strategies as st

from pianta.errors import PiantaError


@st.composite
def mutated(draw: st.DrawFn, valid: bytes) -> bytes:
    """A valid file with up to five bytes changed, and perhaps a piece cut out and random bytes in its place."""
    content = bytearray(valid)
    for _ in range(draw(st.integers(0, 5))):
        content[draw(st.integers(0, len(content) - 1))] = draw(st.integers(0, 255))
    start, stop = sorted(draw(st.tuples(*[st.integers(0, len(content))] * 2)))
    if draw(st.booleans()):
        content[start:stop] = draw(st.binary(max_size=20))
    return bytes(content)


@contextmanager
def refused_in_one_line() -> Iterator[None]:
    """A block that may succeed, or raise PiantaError with a message of one line, and nothing else."""
    message = ""
    try:
        yield
    except PiantaError as error:
        message = str(error)
    assert "\n" not in message
