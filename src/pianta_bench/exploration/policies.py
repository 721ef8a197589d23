"""The policies that bench exploration compares."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

from pianta.errors import OptionError
from pianta.exploration.policies import POLICIES, PREDICTED, make_policy
from pianta.exploration.policy_input import Policy

NEAREST = "nearest"


@dataclass(frozen=True)
class ComparedPolicy:
    """A policy of the comparison.

    make: the policy from `sampler`, of whole floors, None if no model fits, and `find`, the label to search for, None
    for an exploration. predicts: whether it uses them. One that does not is classical: it drives the same way whatever
    it searches for.
    """

    make: Callable[..., Policy]
    predicts: bool = False


COMPARED_POLICIES: Mapping[str, ComparedPolicy] = MappingProxyType(
    {name: ComparedPolicy(partial(make_policy, name), predicts=name == PREDICTED) for name in POLICIES}
)


def choose_policies(
    names: Sequence[str], registry: Mapping[str, ComparedPolicy] = COMPARED_POLICIES
) -> dict[str, ComparedPolicy]:
    """The policies of these names in the order of the registry, all of them without names.

    Raises OptionError for other names, and without NEAREST, which all are compared with.
    """
    for name in names:
        if name not in registry:
            raise OptionError(f"policy is {name!r}, give one of {', '.join(registry)}")
    chosen = {name: policy for name, policy in registry.items() if name in names or not names}
    if NEAREST not in chosen:
        raise OptionError(f"policies are {', '.join(chosen)}, give {NEAREST} too, which all are compared with")
    return chosen
