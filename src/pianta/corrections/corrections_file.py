"""corrections.json: the corrections of a floor, in the order in which they were made.

The file has the members `format`, `version`, `frame`, `units` and `corrections`: a list of objects with the `kind`, as
in KINDS, and the members of that kind. Points are [x, y], metres of the map frame. Since 1.1 there is the kind number.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from pianta.corrections.kinds import KINDS, Correction, name_kind
from pianta.errors import CorrectionError
from pianta.io._checked import FileFormat, read_checked, save_checked
from pianta.io._faults import describe_validation, join_faults, validation_as
from pianta.io._files import short_repr

FILE_NAME = "corrections.json"
FORMAT = FileFormat("pianta corrections", 1, 1)
MAX_FILE_BYTES = 16 * 2**20
# A limit of time; a floor of 2000 rooms with ten corrections for each has as many.
MAX_CORRECTIONS = 20_000


def read_corrections(path: str | Path) -> list[Correction]:
    """The corrections in a file.

    Raises CorrectionError, in one line with every fault, if the file is damaged or of a newer format.
    """
    return read_checked(path, "corrections", CorrectionError, parse_corrections, max_bytes=MAX_FILE_BYTES)


def save_corrections(corrections: Sequence[Correction], path: str | Path) -> None:
    """Write corrections, a line each; read_corrections returns equal ones.

    Raises CorrectionError for corrections that read_corrections would refuse, and PiantaError if the file cannot be
    written.
    """
    save_checked(path, "corrections", CorrectionError, lambda: _dump(corrections))


def describe_correction(correction: Correction) -> dict[str, Any]:
    """A correction as an object of JSON."""
    return {"kind": name_kind(correction), **asdict(correction)}


@validation_as(CorrectionError)
def parse_corrections(content: bytes) -> list[Correction]:
    """The corrections in the content of a file."""
    FORMAT.check_version(content, CorrectionError)
    items = _File.model_validate_json(content).corrections
    corrections, faults = [], []
    for number, item in enumerate(items, start=1):
        try:
            corrections.append(parse_correction(item))
        except CorrectionError as error:
            faults.append(f"correction {number}: {error}")
    if faults:
        raise CorrectionError(join_faults(faults))
    return corrections


def parse_correction(item: dict[str, Any]) -> Correction:
    """The correction of an object of JSON.

    Raises CorrectionError, with every fault, for an unknown kind, and for members that are missing, unknown or wrong.
    """
    members = dict(item)
    name = members.pop("kind", None)
    if not isinstance(name, str) or name not in KINDS:
        raise CorrectionError(f"its kind is {short_repr(name)}, give one of {', '.join(KINDS)}")
    try:
        # As JSON, where a list of two numbers is a point.
        correction: Correction = _ADAPTERS[name].validate_json(json.dumps(members))
    except ValidationError as error:
        raise CorrectionError(f"{name}: {describe_validation(error)}") from None
    return correction


def _dump(corrections: Sequence[Correction]) -> bytes:
    """The content of corrections.json; CorrectionError if it would not be read as the same corrections."""
    header = {**FORMAT.header, "frame": "map", "units": "metres"}
    items = ",\n".join(json.dumps(describe_correction(each), allow_nan=False) for each in corrections)
    content = f'{json.dumps(header)[:-1]}, "corrections": [\n{items}\n]}}\n'.encode()
    if parse_corrections(content) != [*corrections]:
        raise CorrectionError("it would not be read as the same corrections, give tuples of x and y")
    return content


class _File(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True)

    corrections: Annotated[list[dict[str, Any]], Field(max_length=MAX_CORRECTIONS)]


_ADAPTERS = {name: TypeAdapter[Any](correction) for name, correction in KINDS.items()}
