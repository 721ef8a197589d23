"""`make properties` runs more examples than a test asks for, and others each time."""

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.more_examples import TIMES, fuzz


def test_a_test_with_more_examples_draws_more_and_other_examples():
    examples: list[int] = []

    @settings(max_examples=3, derandomize=True, database=None)
    @given(st.integers(0, 10**9))
    def sample(number: int) -> None:
        examples.append(number)

    sample()
    usual, examples[:] = len(examples), []
    fuzz(sample)
    sample()
    first, examples[:] = examples[:], []
    sample()
    assert (usual, len(first)) == (3, 3 * TIMES)
    assert examples != first
