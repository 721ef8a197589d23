"""Hashes: pinned values, equal on every machine and version, and different for different inputs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.graphs.stable_hash import Codes, hash_name, join, mix

codes = st.integers(0, 2**64 - 1)


def to_array(*values: int) -> Codes:
    return np.array(values, np.uint64)


def test_pinned_names():
    # What `printf CORRIDOR | b2sum -l 64` prints, its last byte first.
    assert hash_name("CORRIDOR") == 0x30CEFC3D4433A566
    assert hash_name("\ud800") != hash_name("?")


def test_mixing_is_splitmix64():
    # The first outputs of the published generator from seed 0, whose state grows by its step.
    states = to_array(0, 0x9E3779B97F4A7C15, 0x3C6EF372FE94F82A)
    assert mix(states).tolist() == [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F]


def test_pinned_tuples():
    assert join(1, to_array(2, 3)).tolist() == [15671754871817308195, 8504064997099855862]
    assert join(0).shape == (1,)
    assert join(0, to_array()).shape == (0,)


@given(codes, codes)
def test_other_codes_mix_to_others(one, other):
    assert (mix(to_array(one)) == mix(to_array(other))).all() == (one == other)


@pytest.mark.slow
@given(st.lists(codes, max_size=4), st.lists(codes, max_size=4))
def test_tuples_are_distinguished_by_order_and_length(one, other):
    assert (join(*map(to_array, one)) == join(*map(to_array, other))).all() == (one == other)
