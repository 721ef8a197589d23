"""How `make properties` runs the tests of hypothesis: more examples, other ones each time, and an end."""

import random
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, is_hypothesis_test, settings

# As many times the examples that a test has in `make test`.
TIMES = 20


def fuzz(test: Callable[..., Any]) -> None:
    """Give a test of hypothesis more examples, drawn by a random seed.

    A profile alone does not do it: what a test says of its examples goes before the profile. Nor may settings be
    applied twice, so this sets where hypothesis keeps them; it raises AttributeError once they lie elsewhere.
    """
    usual = test._hypothesis_internal_use_settings  # type: ignore[attr-defined]
    more = settings(
        usual, max_examples=TIMES * usual.max_examples, derandomize=False, suppress_health_check=list(HealthCheck)
    )
    test._hypothesis_internal_use_settings = more  # type: ignore[attr-defined]


def choose_fuzzed(items: list[pytest.Item], seed: str | None) -> tuple[list[pytest.Item], list[pytest.Item]]:
    """The tests of hypothesis in an order by the seed, each with more examples, and the other tests."""
    functions = {item.nodeid: getattr(item, "function", None) for item in items}
    fuzzed = [item for item in items if is_hypothesis_test(functions[item.nodeid])]
    for function in {functions[item.nodeid] for item in fuzzed}:
        assert function is not None
        fuzz(function)
    others = [item for item in items if item not in fuzzed]
    random.Random(seed).shuffle(fuzzed)  # noqa: S311  # no secret
    return fuzzed, others
