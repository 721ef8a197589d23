"""Labels of rooms: the hierarchical label schema of the thesis, section 4.3, and L_general of section 4.2.

A schema lists the labels of a building type (Fig. 4.5); io/label_schemas.py reads the schemas of other building types.
"""

from pianta.labels._hierarchy import (
    FCES,
    MAX_NAME_LENGTH,
    RC,
    GeneralLabel,
    Label,
    LabelConvention,
    LabelSchema,
    LabelSet,
    normalize_label,
    standard_building_type,
    standard_color,
    standard_name,
)
from pianta.labels._schemas import ALL_SCHEMAS, FCES_COLORS, HOME, HOSPITAL, HOUSE, OFFICE, SCHEMAS, SCHOOL, schema_of

__all__ = [
    "ALL_SCHEMAS",
    "FCES",
    "FCES_COLORS",
    "HOME",
    "HOSPITAL",
    "HOUSE",
    "MAX_NAME_LENGTH",
    "OFFICE",
    "RC",
    "SCHEMAS",
    "SCHOOL",
    "GeneralLabel",
    "Label",
    "LabelConvention",
    "LabelSchema",
    "LabelSet",
    "normalize_label",
    "schema_of",
    "standard_building_type",
    "standard_color",
    "standard_name",
]
