"""The policies that bench exploration compares."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from pianta.errors import OptionError
from pianta.exploration.policies import POLICIES, PREDICTED, make_policy
from pianta.exploration.policy_input import Policy
from pianta.prediction.unexplored_part import FloorSampler

NEAREST = "nearest"


@dataclass(frozen=True)
class Contender:
    """A policy to be compared.

    make: the policy from a sampler of whole floors, None where no model fits, and the label that is looked for, None
    for an exploration.
    predicts: whether it makes use of them; what does not is classical, and goes the same way whatever is looked for.
    """

    make: Callable[[FloorSampler | None, str | None], Policy]
    predicts: bool = False


def _contend(name: str) -> Contender:
    return Contender(lambda sampler, find: make_policy(name, sampler=sampler, find=find), predicts=name == PREDICTED)


CONTENDERS: Mapping[str, Contender] = MappingProxyType({name: _contend(name) for name in POLICIES})


def check_policies(names: Sequence[str]) -> tuple[str, ...]:
    """The names without doubles, all of CONTENDERS for none.

    Raises OptionError for others, and where NEAREST is not among them, which all are compared with.
    """
    for name in names:
        if name not in CONTENDERS:
            raise OptionError(f"policy is {name!r}, give one of {', '.join(CONTENDERS)}")
    chosen = tuple(name for name in CONTENDERS if name in names or not names)
    if NEAREST not in chosen:
        raise OptionError(f"policies are {', '.join(chosen)}, give {NEAREST} too, which all are compared with")
    return chosen
