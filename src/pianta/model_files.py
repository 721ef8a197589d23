"""Model files of all formats, detected by their content."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

from pianta.building_types.model import BuildingTypeModel
from pianta.building_types.model_file import read_building_type_model
from pianta.errors import ModelError
from pianta.generation.type_model import TypeModel
from pianta.generation.type_model_file import read_type_model
from pianta.io._files import check_input_file, short_repr
from pianta.rooms.model import RoomModel
from pianta.rooms.model_file import read_room_model

MAX_FILE_BYTES = 64 * 2**20  # to detect the format; the readers of models have lower limits


def load_model(path: str | Path) -> RoomModel | BuildingTypeModel | TypeModel:
    """Load a model that pianta has trained: of rooms, of building types, or of one building type.

    Parameters
    ----------
    path
        The file that `model.save(path)` or `pianta train` has written.

    Returns
    -------
    RoomModel, BuildingTypeModel or TypeModel
        For `label_rooms`, `classify_building`, or `generate` and `predict`.

    Raises
    ------
    ModelError
        The file is no model, is damaged, or comes from a newer pianta; in one line.

    Examples
    --------
    >>> import pianta
    >>> model = pianta.load_model("school.json")  # doctest: +SKIP
    """
    file = check_input_file(path, "model", ModelError)
    if zipfile.is_zipfile(file):
        return read_room_model(file)
    file_format = _read_format(file)
    if file_format == "pianta buildings":
        return read_building_type_model(file)
    if file_format == "pianta type":
        return read_type_model(file)
    raise ModelError(
        f"cannot read the model {short_repr(file)}: it is no model of pianta, make one with `pianta train`"
    )


def _read_format(file: Path) -> str:
    """The member `format` of a JSON file; empty for other files."""
    if file.stat().st_size > MAX_FILE_BYTES:
        return ""
    try:
        content = json.loads(file.read_bytes())
    except (ValueError, RecursionError, OSError):
        return ""
    return str(content.get("format", "")) if isinstance(content, dict) else ""
