"""Algorithm 1 as the thesis prints it, as a method of the benches beside those of `METHODS`."""

from __future__ import annotations

from pianta.layout.parameters import Parameters, ThesisParameters

AS_PRINTED = "thesis as printed"
# Maps of empty rooms, from which the thesis removes no small groups of cells (section 3.2).
BARE_SETS = ("survey", "schools")


def choose_method(name: str, part: str) -> tuple[str, Parameters | None]:
    """The method of `METHODS` for the name of a method of a bench, and its parameters on a set of maps."""
    if name != AS_PRINTED:
        return name, None
    return "thesis", ThesisParameters.as_printed(furnished=part not in BARE_SETS)
