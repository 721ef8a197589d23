"""The unit of length of an IFC that names none."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ifcopenshell import file

# Doors are 0.6 to 4 m wide, in metres, centimetres or millimetres; chosen by hand.
_MAX_METRES, _MAX_CENTIMETRES = 10.0, 400.0
_NAMES = {None: "metres", "CENTI": "centimetres", "MILLI": "millimetres"}


def set_missing_unit(model: file) -> str | None:
    """Give a model without a unit of length the one that fits its doors, and say so; None if it has a unit."""
    projects = model.by_type("IfcProject")
    named = [unit for project in projects if project.UnitsInContext for unit in project.UnitsInContext.Units]
    if any(_is_length(unit) for unit in named) or not projects:
        return None
    widths = [door.OverallWidth for door in model.by_type("IfcDoor") if door.OverallWidth]
    typical = float(np.median(widths)) if widths else 0.0
    prefix = None if typical <= _MAX_METRES else "CENTI" if typical <= _MAX_CENTIMETRES else "MILLI"
    unit = model.create_entity("IfcSIUnit", UnitType="LENGTHUNIT", Prefix=prefix, Name="METRE")
    for project in projects:
        own = project.UnitsInContext.Units if project.UnitsInContext is not None else ()
        project.UnitsInContext = model.create_entity("IfcUnitAssignment", [*own, unit])
    evidence = "its doors fit" if widths else "without doors these are"
    return f"no unit of length, {evidence} {_NAMES[prefix]}"


def _is_length(unit: object) -> bool:
    return getattr(unit, "UnitType", None) == "LENGTHUNIT"
