"""64-bit hashes of names, numbers and multisets of codes that are equal on every machine and in every run."""

from __future__ import annotations

from functools import lru_cache
from hashlib import blake2b
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Codes: TypeAlias = NDArray[np.uint64]

# The finaliser of splitmix64 (Steele, Lea and Flood, 2014): a bijection whose output bits all depend on all input bits.
STEP = np.uint64(0x9E3779B97F4A7C15)
FACTORS = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
SHIFTS = np.uint64(30), np.uint64(27), np.uint64(31)


@lru_cache(maxsize=4096)
def hash_name(name: str) -> int:
    """The code of a text, 0 … 2^64 - 1."""
    return int.from_bytes(blake2b(name.encode(errors="surrogatepass"), digest_size=8).digest(), "little")


def mix(codes: Codes) -> Codes:
    """A pseudo-random bijection of codes; the sum of mixed codes is a hash of their multiset."""
    mixed = codes + STEP
    mixed = (mixed ^ (mixed >> SHIFTS[0])) * FACTORS[0]
    mixed = (mixed ^ (mixed >> SHIFTS[1])) * FACTORS[1]
    return mixed ^ (mixed >> SHIFTS[2])


def join(*parts: NDArray[np.integer] | int) -> Codes:
    """Codes of ordered tuples, whose elements are arrays of shape (n,) or single integers of 0 or more."""
    joined = np.zeros(1, np.uint64)
    for part in parts:
        joined = mix(joined ^ mix(np.atleast_1d(np.asarray(part, np.uint64))))
    return joined
