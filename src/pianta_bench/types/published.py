"""What chapter 4 of the thesis prints of building types; sets and labels by the names that RoomSet has.

Per cent and metres. The tables' union is H+S+O, which is not S+O. Values of figures that the text does not give, and
the standard deviations of axes ratios, are not here.
"""

from __future__ import annotations

from types import MappingProxyType

# Table 4.2: rooms (%), then mean and standard deviation of area (m²) and doorways, and the mean axes ratio.
CHARACTERISTICS = MappingProxyType(
    {
        "House": {
            "C": (23.9, 14.0, 11.4, 4.0, 1.8, 3.4),
            "H": (8.0, 61.5, 25.1, 3.3, 1.5, 1.8),
            "S": (28.0, 6.0, 2.6, 1.0, 0.2, 1.6),
            "M": (26.3, 17.4, 4.8, 1.3, 0.4, 2.0),
            "B": (13.7, 33.7, 7.8, 1.8, 1.0, 1.5),
        },
        "School": {
            "C": (15.4, 36.1, 42.2, 5.7, 3.8, 7.4),
            "H": (5.6, 205.1, 172.9, 6.9, 4.5, 2.0),
            "S": (55.6, 10.0, 9.7, 1.1, 0.4, 1.6),
            "M": (21.3, 54.8, 14.8, 1.6, 0.8, 1.3),
            "B": (2.0, 102.9, 22.3, 2.1, 0.7, 1.7),
        },
        "Office": {
            "C": (20.6, 30.5, 25.7, 6.7, 4.8, 8.1),
            "H": (6.6, 106.9, 84.5, 6.5, 3.6, 2.4),
            "S": (23.2, 4.5, 2.3, 1.0, 0.1, 1.3),
            "M": (34.5, 18.5, 14.4, 1.2, 0.3, 1.9),
            "B": (14.8, 31.3, 12.2, 1.4, 0.9, 1.9),
        },
        "H+S+O": {
            "C": (20.3, 26.4, 27.9, 5.7, 4.1, 6.5),
            "H": (6.8, 110.9, 109.2, 3.7, 3.7, 2.2),
            "S": (32.3, 7.1, 6.9, 1.0, 0.4, 1.5),
            "M": (29.3, 24.5, 18.9, 1.3, 0.6, 1.8),
            "B": (11.5, 35.0, 18.0, 1.6, 0.9, 1.8),
        },
    }
)

# Section 4.2.3: mean accuracy over algorithms, and its standard deviation.
ACCURACIES = MappingProxyType(
    {"House": (87.8, 4.9), "School": (88.3, 4.8), "Office": (81.6, 4.6), "H+S+O": (73.6, 4.7)}
)

# Table 4.3: rows are true labels, columns given ones, C H S M B.
CONFUSIONS = MappingProxyType(
    {
        "House": (
            (92.3, 1.2, 1.7, 3.5, 1.3),
            (3.0, 88.0, 0.0, 0.7, 8.2),
            (3.8, 0.3, 91.4, 4.5, 0.0),
            (3.7, 0.4, 8.1, 83.4, 4.3),
            (1.0, 7.1, 0.0, 5.4, 86.5),
        ),
        "School": (
            (92.0, 3.3, 4.2, 0.3, 0.1),
            (7.4, 80.0, 1.3, 5.2, 6.1),
            (3.1, 0.3, 94.0, 2.6, 0.0),
            (0.6, 3.5, 6.5, 85.5, 3.9),
            (0.0, 21.7, 2.9, 18.8, 56.5),
        ),
        "Office": (
            (91.9, 3.6, 0.2, 2.6, 1.7),
            (7.8, 80.9, 0.0, 6.5, 4.8),
            (2.0, 0.0, 92.3, 5.4, 0.3),
            (2.6, 1.2, 5.6, 70.9, 19.6),
            (3.6, 5.9, 0.1, 25.3, 65.1),
        ),
        "H+S+O": (
            (85.7, 6.9, 2.1, 2.8, 2.4),
            (7.9, 75.8, 1.0, 7.1, 8.0),
            (4.0, 0.2, 75.4, 17.6, 2.7),
            (2.3, 3.0, 11.9, 63.3, 19.6),
            (4.6, 9.3, 3.6, 15.8, 66.7),
        ),
    }
)
# Its row FN, which is 100 - TN.
MISLED = MappingProxyType(
    {
        "House": (24.2, 1.5, 3.7, 3.9, 2.5),
        "School": (2.6, 1.8, 57.6, 2.6, 1.2),
        "Office": (20.7, 1.9, 3.2, 7.6, 9.9),
        "H+S+O": (3.6, 3.1, 35.3, 12.1, 8.9),
    }
)

# Table 4.4: RI, MLP, DT, K-NN and their average.
TRANSFERS = MappingProxyType(
    {("House", "School"): (40.0, 35.7, 43.0, 41.2, 40.0), ("School", "House"): (50.7, 56.1, 53.0, 51.0, 52.7)}
)

# Sections 4.2.4 and 4.3.1: of a building type; the last two are means over H, S and O.
CLUSTERS = "20-30"
OUTLIERS, CORRIDORS_IN_OUTLIERS, HOMOGENEITY_R_C, RULE_ACCURACY = 17, 75, 0.71, 93.5
