"""Limits on what bags of untrusted origin unpack to: a chunk of some kilobytes can hold gigabytes of zeros."""

from __future__ import annotations

from bz2 import BZ2Decompressor
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pianta.errors import MapError
from pianta.io._files import MAX_CELLS, check_byte_count

# A chunk has at least one message; the largest map that is read fits into it.
MAX_CHUNK_BYTES = MAX_CELLS + 2**24
# Its reader takes some 30 microseconds for a byte; bags of hundreds of topics have 100 kB.
MAX_METADATA_BYTES = 2**18


def check_metadata(file: Path) -> None:
    """Raise MapError, in one line, for a metadata.yaml that is too large."""
    try:
        check_byte_count(file.stat().st_size, MapError, max_bytes=MAX_METADATA_BYTES)
    except MapError as error:
        raise MapError(f"bag {str(file)!r}: {error}, such as the .mcap or .db3 alone") from None


def limit_unpacking() -> None:
    """Let rosbags unpack chunks up to MAX_CHUNK_BYTES; it raises ValueError for larger ones.

    rosbags has no limit itself, and finds its functions in tables by the name of the compression.
    """
    from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]
    from rosbags.rosbag1 import reader as reader1
    from rosbags.rosbag2 import storage_mcap

    reader1.decompressors.update(bz2=_limit(BZ2Decompressor), lz4=_limit(LZ4FrameDecompressor))
    zstd: Any = storage_mcap.__dict__["zstd"]  # of Python 3.14, or of a package
    storage_mcap.DECOMPRESSORS.update(lz4=_limit(LZ4FrameDecompressor), zstd=_limit(zstd.ZstdDecompressor))


def _limit(make_decompressor: Callable[[], Any]) -> Callable[..., bytes]:
    """A function that unpacks one frame."""

    def unpack(packed: bytes, _size: int = 0) -> bytes:
        decompressor = make_decompressor()
        unpacked: bytes = decompressor.decompress(packed, MAX_CHUNK_BYTES + 1)
        if len(unpacked) > MAX_CHUNK_BYTES:
            raise ValueError(f"a chunk unpacks to more than {MAX_CHUNK_BYTES} bytes")
        if not decompressor.eof:
            raise ValueError("a chunk is cut off")
        return unpacked

    return unpack
