"""Hashes that are the same on every machine and in every run: 64-bit codes of names, numbers and multisets of codes."""

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
    """Codes that look random, another for each code; sums of them stand for multisets, where order does not count."""
    mixed = codes + STEP
    mixed = (mixed ^ (mixed >> SHIFTS[0])) * FACTORS[0]
    mixed = (mixed ^ (mixed >> SHIFTS[1])) * FACTORS[1]
    return mixed ^ (mixed >> SHIFTS[2])


def join(*parts: NDArray[np.integer] | int) -> Codes:
    """Codes of ordered tuples: arrays of one shape (n,), and integers of 0 or more that stand for themselves."""
    joined = np.zeros(1, np.uint64)
    for part in parts:
        joined = mix(joined ^ mix(np.atleast_1d(np.asarray(part, np.uint64))))
    return joined
