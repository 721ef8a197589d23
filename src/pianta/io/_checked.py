"""Files with checked content: read and written as a whole, and the version header of pianta's own formats."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator

from pianta.errors import PiantaError
from pianta.io._files import atomic_file, check_byte_count, check_input_file, one_line_reason, short_repr

Content = TypeVar("Content")


def read_checked(
    path: str | Path, what: str, error: type[PiantaError], parse: Callable[[bytes], Content], *, max_bytes: int
) -> Content:
    """The result of `parse` on the bytes of a file; `what` is the noun by which messages call the file.

    Raises error, in one line that names the file, as check_input_file does, for more than max_bytes, and with what
    `parse` raises.
    """
    file = check_input_file(path, what, error)
    try:
        check_byte_count(file.stat().st_size, error, max_bytes=max_bytes)
        return parse(file.read_bytes())
    except (error, OSError) as exception:
        reason = one_line_reason(exception) if isinstance(exception, OSError) else exception
        raise error(f"cannot read the {what} {short_repr(file)}: {reason}") from exception


def save_checked(path: str | Path, what: str, error: type[PiantaError], dump: Callable[[], bytes]) -> None:
    """Write the bytes that `dump` makes.

    Raises error, with the message of what `dump` raises, and PiantaError when the file cannot be written.
    """
    try:
        content = dump()
    except (ValueError, TypeError, RecursionError) as exception:
        raise error(f"cannot save the {what} as {short_repr(path)}: {exception}") from exception
    with atomic_file(path) as temporary:
        temporary.write_bytes(content)


@dataclass(frozen=True)
class FileFormat:
    """A format of pianta's own: its name, and the version that this pianta writes.

    A minor version only adds members, which older readers skip; a major version changes others.
    oldest: the oldest major version that is still read. remedy: what to do with an older file.
    """

    name: str
    major: int
    minor: int = 0
    oldest: int = 1
    remedy: str = ""

    @property
    def header(self) -> dict[str, str]:
        """The first members of a file."""
        return {"format": self.name, "version": f"{self.major}.{self.minor}"}

    def check_version(self, content: object, error: type[PiantaError]) -> tuple[int, int]:
        """Major and minor version of a file: of JSON as bytes, or of an object that is parsed already.

        Raises error for a version that is too new or too old, and pydantic's ValidationError for another format.
        """
        if isinstance(content, bytes):
            version = _Header.model_validate_json(content, context=self).version
        else:
            version = _Header.model_validate(content, context=self).version
        major, minor = map(int, version.split("."))
        if major > self.major:
            raise error(f"it has format version {version}, this pianta reads {self.major}.x; update pianta")
        if major < self.oldest:
            raise error(f"it has format version {version}, which pianta no longer reads; {self.remedy}")
        return major, minor


class _Header(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True)

    format: str
    version: Annotated[str, Field(pattern=r"^[0-9]{1,100}\.[0-9]{1,100}$")]

    @field_validator("format")
    @classmethod
    def _check_format(cls, name: str, info: ValidationInfo[FileFormat]) -> str:
        if name != info.context.name:
            raise ValueError(f"give {info.context.name!r}")
        return name
