"""The policies of exploration by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING

from pianta.errors import OptionError
from pianta.exploration.classical_policies import InformationGain, NearestFrontier
from pianta.exploration.policy_input import Policy

if TYPE_CHECKING:
    from pianta.prediction.unexplored_part import FloorSampler

PREDICTED = "predicted"
CLASSICAL: Mapping[str, Callable[[], Policy]] = MappingProxyType(
    {"nearest": NearestFrontier, "gain": InformationGain, "gain-exp": partial(InformationGain, "exponential")}
)
# The names for `pianta explore --policy`.
POLICIES = (*CLASSICAL, PREDICTED)


def check_policy(name: str) -> None:
    """Raise OptionError for a name that is not in POLICIES."""
    if name not in POLICIES:
        raise OptionError(f"policy is {name!r}, give one of {', '.join(POLICIES)}")


def make_policy(
    name: str, *, sampler: FloorSampler | None = None, find: str | None = None, enough: float | None = None
) -> Policy:
    """Make the policy of a name in POLICIES.

    sampler, find, enough: of PredictedGain; the classical policies ignore them.
    Raises OptionError for any other name, and as PredictedGain does.
    """
    check_policy(name)
    if name in CLASSICAL:
        return CLASSICAL[name]()
    # Imported late, because its imports are slow.
    from pianta.exploration.predicted_gain import PredictedGain

    return PredictedGain(sampler, find=find, enough=enough)
