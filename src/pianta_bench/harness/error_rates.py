"""Two error rates of a classification: the share of wrong floors, and the mean over the classes of this share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import fmean

# Share of all floors that are wrong.
ALL_FLOORS = "all floors"
# For each class the share of its floors that are wrong, and the mean of these shares: every class counts the same.
CLASS_MEAN = "class mean"
STATISTICS = (ALL_FLOORS, CLASS_MEAN)
STATISTICS_NOTE = f"{ALL_FLOORS}: share of all floors; {CLASS_MEAN}: mean of the shares of each class."


def measure_error_rates(classes: Sequence[str], wrong: Sequence[bool]) -> Mapping[str, float | None]:
    """The error rates by statistic, %; None without floors.

    classes: the true class of each floor. wrong: whether a model gives it another one.

    Examples
    --------
    One of six worlds is wrong, and none of twenty offices:

    >>> rates = measure_error_rates(["world"] * 6 + ["office"] * 20, [True] + [False] * 25)
    >>> {name: round(rate, 2) for name, rate in rates.items()}
    {'all floors': 3.85, 'class mean': 8.33}
    """
    if not classes:
        return dict.fromkeys(STATISTICS)
    by_class: dict[str, list[bool]] = {}
    for name, is_wrong in zip(classes, wrong, strict=True):
        by_class.setdefault(name, []).append(bool(is_wrong))
    return {ALL_FLOORS: 100 * fmean(wrong), CLASS_MEAN: 100 * fmean(fmean(each) for each in by_class.values())}
