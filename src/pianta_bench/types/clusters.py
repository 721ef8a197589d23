"""Clusters of rooms by geometry, without their labels, and their agreement with labels (sections 4.2.4 and 4.3.1)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from sklearn.cluster import DBSCAN
from sklearn.decomposition import PCA
from sklearn.metrics import completeness_score, homogeneity_score
from sklearn.neighbors import NearestNeighbors
from sklearn.preprocessing import minmax_scale

from pianta._types import Floats
from pianta.labels import GeneralLabel
from pianta.rooms.thesis_features import GENERAL_FEATURES
from pianta_bench.types.room_sets import RoomSet

MIN_POINTS = 6  # rooms, MinPts of DBSCAN (section 4.2.4)
EPSILON = 3.0  # ε of DBSCAN (section 4.2.4), in the units of the scaled features
OUTLIER = -1
# C of L_general, and the labels of corridors in the files of MIT and KTH.
CORRIDOR_LABELS = (str(GeneralLabel.CORRIDOR), "CORR", "P CIRC", "CORRIDOR")
# "CORRIDORS have usually more than four doors", ROOMs one or two (section 4.3.1); four is best on the data.
CORRIDOR_DOORWAYS = 4
# The K-distances of the last rooms, which are far from all others, are left out when the bend is sought.
BEND_SHARE = 0.98

Clusters = NDArray[np.int_]


# The thesis does not print how its features were scaled for an ε of 3.
SCALES: MappingProxyType[str, Callable[[RoomSet], Floats]] = MappingProxyType(
    {
        "a (m²), d, rt": lambda rooms: rooms.geometry,
        "with neighbours": RoomSet.with_neighbours,
        "% of range": lambda rooms: 100 * minmax_scale(rooms.geometry),
    }
)


@dataclass(frozen=True)
class RoomClusters:
    """Clusters of a set.

    rooms: the name of the set. scale: a key of SCALES.
    clusters: from 0, OUTLIER in no cluster, shape (rooms,). plane: their first two principal components, (rooms, 2).
    distances: to the MIN_POINTS-th nearest room, itself counted, ascending, shape (rooms,).
    bend: the distance at which that curve bends.
    figures: homogeneity and completeness over L_general and homogeneity over R/C, outliers as one cluster;
        `accuracy_...` of ROOM or CORRIDOR by the majority of the cluster; see `measure_clusters`; None without meaning.
    """

    rooms: str
    scale: str
    clusters: Clusters
    plane: Floats
    distances: Floats
    bend: float
    figures: dict[str, float | None]


def find_room_clusters(rooms: RoomSet, *, scale: str) -> RoomClusters:
    """Cluster rooms by DBSCAN with MinPts 6 and ε 3 (section 4.2.4)."""
    features = SCALES[scale](rooms)
    clusters = DBSCAN(eps=EPSILON, min_samples=MIN_POINTS).fit_predict(features)
    distances = measure_distances(features)
    plane = PCA(2, svd_solver="full").fit_transform(features)
    figures = measure_clusters(rooms, clusters)
    return RoomClusters(rooms.name, scale, clusters, plane, distances, find_bend(distances), figures)


def measure_distances(features: Floats) -> Floats:
    """The K-distance plot: distances to the MIN_POINTS-th nearest room, itself counted, ascending, shape (rooms,)."""
    nearest = NearestNeighbors(n_neighbors=min(MIN_POINTS, len(features))).fit(features)
    return np.sort(nearest.kneighbors(features)[0][:, -1])


def find_bend(distances: Floats) -> float:
    """Where an ascending curve bends: its point furthest below the straight line between its ends."""
    curve = distances[: max(int(len(distances) * BEND_SHARE), 1)]
    line = np.linspace(curve[0], curve[-1], len(curve))
    return float(curve[np.argmax(line - curve)])


def measure_clusters(rooms: RoomSet, clusters: Clusters) -> dict[str, float | None]:
    """Agreement of labels and clusters; shares from 0 to 1.

    clusters: their number. outliers: the share of rooms in no cluster. corridors_in_outliers: the share of them that
    is C, or a corridor of a campus. homogeneity, completeness: over the labels of the set. homogeneity_r_c: over ROOM
    and CORRIDOR. homogeneity_r_c_clustered: the same without the outliers, which otherwise are one cluster.
    accuracy_clustered: of the naive rule on rooms in clusters. accuracy_outliers_together: on all, outliers being one
    cluster. accuracy_outliers_majority: on all, every outlier with the commonest class of the set. always_majority: the
    accuracy of the commonest class for all rooms. four_doorways: of CORRIDOR for all rooms with four doorways or more.
    """
    inside, corridors = clusters != OUTLIER, rooms.corridors
    named = name_by_majority(corridors, clusters)
    majority_for_outliers = np.where(inside, named, corridors.mean() > 0.5)
    some_outside, some_inside = bool((~inside).any()), bool(inside.any())
    is_c = np.isin(rooms.labels, CORRIDOR_LABELS)
    doorways = rooms.geometry[:, GENERAL_FEATURES.index("doors")]
    return {
        "clusters": len(np.unique(clusters[inside])),
        "outliers": float((~inside).mean()),
        "corridors_in_outliers": float(is_c[~inside].mean()) if some_outside else None,
        "homogeneity": float(homogeneity_score(rooms.labels, clusters)),
        "completeness": float(completeness_score(rooms.labels, clusters)),
        "homogeneity_r_c": float(homogeneity_score(corridors, clusters)),
        "homogeneity_r_c_clustered": float(homogeneity_score(corridors[inside], clusters[inside]))
        if some_inside
        else None,
        "accuracy_clustered": float((named == corridors)[inside].mean()) if some_inside else None,
        "accuracy_outliers_together": float((named == corridors).mean()),
        "accuracy_outliers_majority": float((majority_for_outliers == corridors).mean()),
        "always_majority": float(max(corridors.mean(), 1 - corridors.mean())),
        "four_doorways": float((corridors == (doorways >= CORRIDOR_DOORWAYS)).mean()),
    }


def name_by_majority(corridors: NDArray[np.bool_], clusters: Clusters) -> NDArray[np.bool_]:
    """The naive rule: whether most rooms of each room's cluster are CORRIDOR, ROOM on a tie; shape (rooms,)."""
    named = np.zeros(len(clusters), bool)
    for cluster in np.unique(clusters):
        members = clusters == cluster
        named[members] = 2 * corridors[members].sum() > members.sum()
    return named
