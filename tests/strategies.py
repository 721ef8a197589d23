"""What hypothesis draws for several test files."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap

finite = st.floats(allow_nan=False, allow_infinity=False)

grids = st.builds(
    GridMap,
    arrays(np.int8, array_shapes(min_dims=2, max_dims=2), elements=st.integers(-1, 100)),
    st.floats(0, exclude_min=True, allow_infinity=False),
    st.tuples(finite, finite, finite),
)


@st.composite
def noise_maps(draw: st.DrawFn) -> GridMap:
    """Maps of single cells, most of them free, at any resolution."""
    shape = draw(st.integers(1, 40)), draw(st.integers(1, 40))
    seed = draw(st.integers(0, 2**32 - 1))
    return GridMap(
        np.random.default_rng(seed).choice([FREE] * 7 + [OCCUPIED, UNKNOWN], size=shape),
        draw(st.sampled_from([1e-9, 0.01, 0.05, 0.3, 1e6])),
    )
