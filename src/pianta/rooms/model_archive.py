"""The archive of a model: a zip of .npy arrays, which numpy.load opens too, and a text beside them.

An archive may come from a stranger. Nothing of it is unpacked before its sizes are known, and of no member more than
its directory promises; arrays are numbers of the type that is asked for, and nothing is unpickled.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Mapping
from math import prod
from typing import Any, Self

import numpy as np
from numpy.lib import format as npy
from numpy.typing import DTypeLike, NDArray

from pianta.errors import ModelError
from pianta.io._files import one_line_reason, short_repr

NO_MODEL = "it is no model of rooms, or damaged; make one with `pianta train places`"
# Bytes that an archive may unpack to, and members that it may have: older models had a thousand, and are to be told.
MAX_CONTENT_BYTES = 512 * 2**20
MAX_MEMBERS = 20_000
# Ways of packing of which zipfile unpacks no more than it is asked for.
PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
# The earliest date that a zip can tell, so that the same arrays give the same bytes.
DATE = (1980, 1, 1, 0, 0, 0)
# How hard is packed, and Unix, on which members are ordinary files.
LEVEL, UNIX, ORDINARY_FILE = 9, 3, 0o100644 << 16
# What zipfile raises for what is damaged: a way of packing that it does not know is a NotImplementedError, and an
# encrypted member a RuntimeError.
FAULTS = (zipfile.BadZipFile, zlib.error, KeyError, EOFError, RuntimeError, OSError, ValueError)


def pack_archive(text: str, name: str, arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """A text under its name and arrays under theirs as an archive; the same ones always as the same bytes."""
    members = {name: text.encode()}
    for key, array in arrays.items():
        stream = io.BytesIO()
        npy.write_array(stream, np.ascontiguousarray(array), version=(1, 0), allow_pickle=False)
        members[f"{key}.npy"] = stream.getvalue()
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for member, data in members.items():
            info = zipfile.ZipInfo(member, DATE)
            info.create_system, info.external_attr = UNIX, ORDINARY_FILE
            archive.writestr(info, data, zipfile.ZIP_DEFLATED, LEVEL)
    return content.getvalue()


class ModelArchive:
    """An archive whose members can be read one by one.

    Raises
    ------
    ModelError
        For what is no archive, and for one with too many or too large members.

    """

    def __init__(self, content: bytes) -> None:
        try:
            self._archive = zipfile.ZipFile(io.BytesIO(content))
        except FAULTS:
            raise ModelError(NO_MODEL) from None
        members = self._archive.infolist()
        if len(members) > MAX_MEMBERS:
            raise ModelError(f"it has {len(members)} members, too many for a model; the limit is {MAX_MEMBERS}")
        size = sum(member.file_size for member in members)
        if size > MAX_CONTENT_BYTES:
            raise ModelError(f"it unpacks to {size} bytes, too many for a model; the limit is {MAX_CONTENT_BYTES}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._archive.close()

    def read(self, name: str) -> bytes:
        """The content of a member.

        Raises ModelError where it is missing or damaged.
        """
        try:
            member = self._archive.getinfo(name)
            if member.compress_type not in PACKINGS:
                raise ModelError(f"{short_repr(name)} is packed by method {member.compress_type}, pack it by deflate")
            with self._archive.open(member) as stream:
                # Without a number zipfile would unpack all that is there, whatever the directory says.
                return stream.read(member.file_size)
        except ModelError:
            raise
        except KeyError:
            raise ModelError(f"{short_repr(name)} is missing") from None
        except FAULTS as exception:
            raise ModelError(f"{short_repr(name)} is damaged: {one_line_reason(exception)}") from None

    def read_array(self, key: str, dtype: DTypeLike, *, axes: int) -> NDArray[Any]:
        """An array of so many axes; it cannot be written to.

        Raises ModelError for one that is missing, damaged, or of another type.
        """
        content = self.read(f"{key}.npy")
        stream = io.BytesIO(content)
        try:
            if npy.read_magic(stream) != (1, 0):
                raise ValueError("its header is of another version")
            shape, by_columns, found = npy.read_array_header_1_0(stream)
        # Whatever a header of a stranger provokes in numpy, which reads it as Python.
        except Exception as exception:
            raise ModelError(f"{short_repr(key)} is no array: {one_line_reason(exception)}") from None
        if found != np.dtype(dtype) or len(shape) != axes or by_columns:
            wanted = f"{np.dtype(dtype)} with {axes} ax{'es' if axes > 1 else 'is'}, by rows"
            raise ModelError(f"{short_repr(key)} is {found} of shape {short_repr(shape)}, give {wanted}")
        size = len(content) - stream.tell()
        if min(shape) < 0 or max(shape) > size or prod(shape) * found.itemsize != size:
            raise ModelError(
                f"{short_repr(key)} has {size} bytes, its header promises {found} of shape {short_repr(shape)}"
            )
        return np.frombuffer(content, found, offset=stream.tell()).reshape(shape)
