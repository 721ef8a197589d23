"""What hypothesis draws for several test files."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from pianta.gridmap import GridMap

finite = st.floats(allow_nan=False, allow_infinity=False)

grids = st.builds(
    GridMap,
    arrays(np.int8, array_shapes(min_dims=2, max_dims=2), elements=st.integers(-1, 100)),
    st.floats(0, exclude_min=True, allow_infinity=False),
    st.tuples(finite, finite, finite),
)
