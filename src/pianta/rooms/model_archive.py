"""The archive of a model: a zip of .npy arrays, which numpy.load opens too, and a text beside them.

An archive may be hostile. Nothing of it is unpacked before its sizes are known, and of no member more than its
directory promises; arrays must have the expected type, and nothing is unpickled.
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
# Limits of the unpacked size and the number of members; models of version 1 had a thousand, and must be recognised.
MAX_CONTENT_BYTES = 512 * 2**20
MAX_MEMBERS = 20_000
# Compressions of which zipfile unpacks no more than it is asked for.
COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
# The earliest date of the zip format, so that the same arrays always give the same bytes.
DATE = (1980, 1, 1, 0, 0, 0)
# Compression level, and the system and attributes of members: regular files on Unix.
COMPRESSION_LEVEL = 9
UNIX = 3
REGULAR_FILE = 0o100644 << 16
# Exceptions of zipfile for a damaged archive; RuntimeError is for encrypted members and, as NotImplementedError, for
# unknown compressions.
FAULTS = (zipfile.BadZipFile, zlib.error, KeyError, EOFError, RuntimeError, OSError, ValueError)


def pack_archive(text: str, name: str, arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """The bytes of an archive with a text and arrays under their names; the same content gives the same bytes."""
    members = {name: text.encode()}
    for key, array in arrays.items():
        stream = io.BytesIO()
        npy.write_array(stream, np.ascontiguousarray(array), version=(1, 0), allow_pickle=False)
        members[f"{key}.npy"] = stream.getvalue()
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for member, data in members.items():
            info = zipfile.ZipInfo(member, DATE)
            info.create_system, info.external_attr = UNIX, REGULAR_FILE
            archive.writestr(info, data, zipfile.ZIP_DEFLATED, COMPRESSION_LEVEL)
    return content.getvalue()


class ModelArchive:
    """An archive whose members are read one by one.

    Raises ModelError for bytes that are not an archive, and for too many or too large members.
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
        """The content of a member; raises ModelError if it is missing or damaged."""
        try:
            member = self._archive.getinfo(name)
            if member.compress_type not in COMPRESSIONS:
                raise ModelError(f"{short_repr(name)} is packed by method {member.compress_type}, pack it by deflate")
            with self._archive.open(member) as stream:
                # Without a size zipfile would unpack everything, whatever the directory says.
                return stream.read(member.file_size)
        except ModelError:
            raise
        except KeyError:
            raise ModelError(f"{short_repr(name)} is missing") from None
        except FAULTS as exception:
            raise ModelError(f"{short_repr(name)} is damaged: {one_line_reason(exception)}") from None

    def read_array(self, key: str, dtype: DTypeLike, *, axes: int) -> NDArray[Any]:
        """A read-only array; raises ModelError if it is missing, damaged, or of another type or number of axes."""
        content = self.read(f"{key}.npy")
        stream = io.BytesIO(content)
        try:
            if npy.read_magic(stream) != (1, 0):
                raise ValueError("its header is of another version")
            shape, by_columns, stored = npy.read_array_header_1_0(stream)
        # numpy parses the header as Python, so a hostile one may raise anything.
        except Exception as exception:
            raise ModelError(f"{short_repr(key)} is no array: {one_line_reason(exception)}") from None
        if stored != np.dtype(dtype) or len(shape) != axes or by_columns:
            expected = f"{np.dtype(dtype)} with {axes} ax{'es' if axes > 1 else 'is'}, by rows"
            raise ModelError(f"{short_repr(key)} is {stored} of shape {short_repr(shape)}, give {expected}")
        size = len(content) - stream.tell()
        if min(shape) < 0 or max(shape) > size or prod(shape) * stored.itemsize != size:
            raise ModelError(
                f"{short_repr(key)} has {size} bytes, its header promises {stored} of shape {short_repr(shape)}"
            )
        return np.frombuffer(content, stored, offset=stream.tell()).reshape(shape)
