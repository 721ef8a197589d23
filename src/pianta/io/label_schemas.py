"""labels.yaml: the label schema of a building type that is not in the thesis, such as a hospital or a house.

It has the members `format`, `version`, `building_type` and `labels`; docs/methods/labels.md has an example. A label
needs a `name` and a `function`; the other members have defaults.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import yaml
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    ValidationInfo,
    model_validator,
)

from pianta.errors import LabelError
from pianta.io._checked import FileFormat, read_checked, save_checked
from pianta.io._faults import validation_as
from pianta.io._files import check_byte_count, one_line_reason, short_repr
from pianta.io._yaml import PlainLoader
from pianta.labels import (
    FCES,
    FCES_COLORS,
    GeneralLabel,
    Label,
    LabelSchema,
    standard_building_type,
    standard_color,
    standard_name,
)

FORMAT = FileFormat("pianta labels", 1)
MAX_FILE_BYTES = 256 * 2**10


def save_label_schema(schema: LabelSchema, path: str | Path) -> None:
    """Write a schema as labels.yaml, a label a line; read_label_schema returns an equal schema.

    Raises LabelError for a schema that read_label_schema would refuse, and PiantaError if the file cannot be written.
    """
    save_checked(path, "label schema", LabelError, lambda: _dump_schema(schema))


def read_label_schema(path: str | Path) -> LabelSchema:
    """Read the schema of a building type from labels.yaml.

    A label without a color has that of its function; without a size, a CONNECTION is C and the others are M.

    Raises LabelError, with every fault in one message, for a file that is no schema or of a newer format.
    """
    return read_checked(path, "label schema", LabelError, _parse_schema, max_bytes=MAX_FILE_BYTES)


def _dump_schema(schema: LabelSchema) -> bytes:
    """The content of labels.yaml; raises LabelError if it would not read back as the same schema."""
    keys = {
        **FORMAT.header,
        "building_type": schema.building_type,
        "labels": [dump_label(label) for label in schema.labels],
    }
    # Flow style for the innermost collections only: a label a line.
    text = yaml.safe_dump(keys, sort_keys=False, default_flow_style=None, allow_unicode=True, width=10_000)
    content = text.encode()
    check_byte_count(len(content), LabelError, max_bytes=MAX_FILE_BYTES)
    if _parse_schema(content) != schema:
        raise LabelError("it does not read back as it is")
    return content


def dump_label(label: Label) -> dict[str, str | bool]:
    """The keys of a label in a file, without optional ones that are not set."""
    keys: dict[str, str | bool] = {
        "name": label.name,
        "function": label.function.value,
        "general": label.general.value,
        "color": label.color,
    }
    if label.in_experiments is not None:
        keys["in_experiments"] = label.in_experiments.value
    if label.corridor_in_graphs is not None:
        keys["corridor_in_graphs"] = label.corridor_in_graphs
    return keys


class _UniqueKeyLoader(PlainLoader):
    """Plain YAML, so that a label may be called NO or 12, with each key once."""

    def compose_mapping_node(self, anchor: dict[Any, yaml.Node]) -> yaml.MappingNode:
        """Refuse a repeated key, of which YAML would keep the last value."""
        node = super().compose_mapping_node(anchor)
        counts = Counter(key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode))
        repeated = [short_repr(key) for key, count in counts.items() if count > 1]
        if repeated:
            line = node.start_mark.line + 1
            raise yaml.YAMLError(f"the mapping at line {line} has keys twice: {', '.join(repeated)}; keep one of each")
        return node


def _capitalize(value: object) -> object:
    """Text in capitals, without spaces around it; any other value unchanged."""
    return value.strip().upper() if isinstance(value, str) else value


def _parse_general_label(value: object) -> object:
    """The general label whose name is the text, such as "medium"; any other value as `_capitalize` returns it."""
    name = _capitalize(value)
    return GeneralLabel[name] if isinstance(name, str) and name in GeneralLabel.__members__ else name


_Function = Annotated[FCES, BeforeValidator(_capitalize)]
_Size = Annotated[GeneralLabel, BeforeValidator(_parse_general_label)]


@dataclass
class _Context:
    """State of the validation of a file.

    is_later: the file is of a later minor version. names: of the labels that have been validated so far.
    """

    is_later: bool
    names: set[str] = field(default_factory=set)


def _check_new_name(name: str, info: ValidationInfo[_Context]) -> str:
    """The name of a label in standard form; raises ValueError if an earlier label has the same."""
    standard = standard_name(name)
    if standard in info.context.names:
        raise ValueError(f"an earlier label has the name {standard!r}, rename one")
    info.context.names.add(standard)
    return standard


def _check_color(color: str) -> str:
    """The colour as #rrggbb; raises ValueError for an empty one, since # without quotes starts a comment."""
    if not color:
        raise ValueError('there is no colour, put "#rrggbb" in quotes, since # starts a comment in YAML')
    return standard_color(color)


class _Part(BaseModel):
    """An object in the file; an unknown key is a fault, or skipped in a file of a later minor version."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @model_validator(mode="before")
    @classmethod
    def _skip_unknown_keys(cls, keys: object, info: ValidationInfo[_Context]) -> object:
        if info.context.is_later and isinstance(keys, dict):
            return {key: value for key, value in keys.items() if key in cls.model_fields}
        return keys


class _LabelPart(_Part):
    name: Annotated[str, AfterValidator(_check_new_name)]
    function: _Function
    size: _Size | None = None
    general: _Size | None = None
    color: Annotated[str, AfterValidator(_check_color)] | None = None
    in_experiments: _Function | None = None
    corridor_in_graphs: bool | None = None

    @property
    def label(self) -> Label:
        """The label; without size it is M, or C if its function is CONNECTION; without colour it has its function's."""
        derived = GeneralLabel.CORRIDOR if self.function is FCES.CONNECTION else GeneralLabel.MEDIUM
        return Label(
            self.name,
            self.function,
            self.general or self.size or derived,
            self.color or FCES_COLORS[self.function],
            self.in_experiments,
            self.corridor_in_graphs,
        )

    @model_validator(mode="after")
    def _check(self) -> _LabelPart:
        if self.size and self.general:
            raise ValueError("it has a size and a general, which are the same, give one")
        _ = self.label
        return self


class _SchemaPart(_Part):
    format: str
    version: str
    building_type: Annotated[str, AfterValidator(standard_building_type)]
    labels: list[_LabelPart]

    @property
    def label_schema(self) -> LabelSchema:
        return LabelSchema(self.building_type, tuple(part.label for part in self.labels))


@validation_as(LabelError)
def _parse_schema(content: bytes) -> LabelSchema:
    """The schema in the content of labels.yaml; raises LabelError with every fault."""
    try:
        keys = _UniqueKeyLoader(content).get_single_data()
    except (yaml.YAMLError, ValueError, RecursionError) as exception:
        raise LabelError(f"it is no YAML: {one_line_reason(exception)}") from None
    if not isinstance(keys, dict):
        raise LabelError("it has no keys, give format, version, building_type and labels")
    _, minor = FORMAT.check_version(keys, LabelError)
    return _SchemaPart.model_validate(keys, context=_Context(minor > FORMAT.minor)).label_schema
