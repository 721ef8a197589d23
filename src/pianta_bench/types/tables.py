"""Tables 4.2 to 4.4 and Figs. 4.3 and 4.4 as tables, beside the published ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from statistics import fmean, stdev

from pianta.building_types.map_types import MIN_TYPE_PROBABILITY
from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table, read_published
from pianta_bench.types.campus import MIT
from pianta_bench.types.classifiers import ALGORITHMS
from pianta_bench.types.clusters import EPSILON, MIN_POINTS, RoomClusters
from pianta_bench.types.maps import BY_CHANCE, CALIBRATION, RIGHT, UNKNOWN, WRONG, WRONG_ABOVE_LIMIT
from pianta_bench.types.measure import BY_AREA, BY_NAME, DIVISION_OF_THESIS, REPRESENTATION_OF_THESIS
from pianta_bench.types.room_sets import GENERAL_LABELS

NOTES = (
    "S, M and B follow from a label's name (docs), or from the area, halfway between those of Table 4.2.",
    "The thesis' rooms are others: 1300 of houses, 1400 of schools, 2600 of offices; its union has all three.",
)
MEANS = ("mean", "sd of algorithms", "sd of folds")
THESIS_FIELDS = {"sizes": BY_NAME, "features": REPRESENTATION_OF_THESIS, "folds_of": DIVISION_OF_THESIS}
# Means over houses, schools and offices, %, but for the number of clusters and homogeneity (sections 4.2.4 and 4.3.1).
PUBLISHED_CLUSTERS = {record["metric"]: record["mean"] for record in read_published("figure_4_4.csv")}
SIZES_TITLES = {BY_NAME: "S, M and B by name", BY_AREA: "S, M and B by area alone"}

TABLE_4_2 = Table(
    title="Table 4.2, rooms of each label: {part}, {rooms} rooms",
    rows=("label",),
    columns=("metric",),
    where={
        "label": list(GENERAL_LABELS),
        "metric": ["share", "area", "area sd", "doorways", "doorways sd", "axes ratio", "axes ratio sd"],
    },
    labels={"share": "rooms\n%", "area": "area\nm²", "area sd": "sd", "doorways sd": "sd ", "axes ratio sd": "sd  "},
    summarise=Cell.only,
    published="table_4_2.csv",
)
FIGURE_4_3 = Table(
    title="Fig. 4.3, accuracy in cross-validation, {sizes}",
    rows=("part", "features", "folds_of"),
    columns=("algorithm",),
    where={"algorithm": [*ALGORITHMS, *MEANS]},
    labels={"sd of algorithms": "sd\nalg.", "sd of folds": "sd\nfolds"},
    factor=100,
    published="figure_4_3.csv",
    unit="%",
)
TABLE_4_3 = Table(
    title="Table 4.3, true labels (rows) and given ones: {part}",
    rows=("label",),
    columns=("given",),
    where={"label": [*GENERAL_LABELS, "TN", "FN"], "given": [*GENERAL_LABELS, "TP", "FP"]},
    summarise=Cell.only,
    factor=100,
    published="table_4_3.csv",
    unit="%, mean over algorithms",
)
TABLE_4_4 = Table(
    title="Table 4.4, accuracy when trained on a type and tested on another, {sizes}",
    rows=("part", "features"),
    columns=("algorithm",),
    where={"algorithm": [*ALGORITHMS, "mean"]},
    factor=100,
    published="table_4_4.csv",
    unit="%, over 10 trainings",
)
MAP_TYPES = Table(
    title="Building types of robots' maps, the building left out of the model",
    unit="maps",
    rows=("part",),
    columns=("metric",),
    where={"metric": [RIGHT, UNKNOWN, WRONG, WRONG_ABOVE_LIMIT]},
    summarise=lambda values: Cell(float(sum(values)), count=len(values)),
    digits=0,
    notes=(f"A type is given from a probability of {MIN_TYPE_PROBABILITY} on. Neither: right if no type is given.",),
)
MAP_CALIBRATION = Table(
    title="Expected calibration error, 10 bins by the most probable of school, office and neither",
    unit="%",
    rows=("item",),
    columns=("metric",),
    where={"part": CALIBRATION, "metric": [CALIBRATION, BY_CHANCE]},
    summarise=Cell.only,
    factor=100,
    notes=("The building is left out of the model. By chance alone: what exact probabilities would have on average.",),
)
CLUSTER_LABELS = {
    "outliers": "out-\nliers, %",
    "corridors_in_outliers": "C of\nthem, %",
    "below": "below\nε, %",
    "clusters": "clus-\nters",
    "homogeneity": "homo-\ngeneity",
    "completeness": "complete-\nness",
}
RULE_LABELS = {
    "homogeneity_r_c": "homog.\nR/C",
    "homogeneity_r_c_clustered": "without\noutliers",
    "accuracy_clustered": "rule, in\nclusters",
    "accuracy_outliers_together": "outliers\ntogether",
    "accuracy_outliers_majority": "outliers\nmajority",
    "always_majority": "all ma-\njority",
    "four_doorways": "4+\ndoors",
}
SHARES = {"outliers", "corridors_in_outliers", "below", *[*RULE_LABELS][2:]}
FIGURE_4_4 = Table(
    title=f"Fig. 4.4, clusters of rooms: DBSCAN, MinPts {MIN_POINTS}, ε {EPSILON:g}; homogeneity over L_general",
    rows=("part", "features"),
    columns=("metric",),
    where={"metric": ["clusters", "outliers", "corridors_in_outliers", "homogeneity", "completeness", "bend", "below"]},
    labels=CLUSTER_LABELS,
    summarise=Cell.only,
    digits={"homogeneity": 2, "completeness": 2},
    notes=(
        "The thesis, means over houses, schools and offices: {clusters} clusters, {outliers} % outliers, of which "
        "{corridors_in_outliers} % are C.".format(**PUBLISHED_CLUSTERS),
    ),
)
RULE = Table(
    title="Section 4.3.1, ROOM or CORRIDOR: homogeneity, and accuracy of the naive rule in %",
    rows=("part", "features"),
    columns=("metric",),
    where={"metric": list(RULE_LABELS)},
    labels=RULE_LABELS,
    summarise=Cell.only,
    digits={"homogeneity_r_c": 2, "homogeneity_r_c_clustered": 2},
    notes=("The thesis: homogeneity {homogeneity_r_c}, rule {rule} %.".format(**PUBLISHED_CLUSTERS),),
)


CAMPUS_CLUSTERS = replace(
    FIGURE_4_4,
    title=f"Fig. 4.4e, clusters of the rooms of MIT: DBSCAN, MinPts {MIN_POINTS}, ε {EPSILON:g}; over all labels",
    labels={**CLUSTER_LABELS, "corridors_in_outliers": "corri-\ndors, %"},
    notes=(
        "{rooms} rooms of {buildings} buildings, with {labels} labels.",
        "The thesis: 32,000 rooms, 90 labels, 0.2 % outliers, 75 % of them CORR; completeness above H, S and O.",
    ),
)


def tabulate(results: Results) -> list[FilledTable]:
    """The tables of chapter 4, for each set of rooms; or those of the building types of maps."""
    if "sets" not in results.details:
        return [MAP_TYPES.fill(results.records), MAP_CALIBRATION.fill(results.records)]
    campus = [*_tabulate_campus(results)]
    sets = results.details["sets"]
    if not sets:
        return campus
    parts = [each["name"] for each in sets]
    labels = [_in_percent(record) for record in results.records if "label" in record]
    tables = [TABLE_4_2.narrow(part=each["name"]).fill(labels, part=each["name"], rooms=each["rooms"]) for each in sets]
    for sizes, title in SIZES_TITLES.items():
        records = results.select(metric="accuracy", sizes=sizes)
        means = derive_means(records, ("part", "features", "folds_of"))
        features = list(dict.fromkeys(record["features"] for record in records))
        divisions = list(dict.fromkeys(record["folds_of"] for record in records))
        table = FIGURE_4_3.narrow(part=parts, features=features, folds_of=divisions)
        tables.append(table.fill([*records, *means], sizes=title))
    confusion = results.select(metric="confusion", **THESIS_FIELDS)
    for part in parts:
        own = [record for record in confusion if record["part"] == part]
        tables.append(TABLE_4_3.narrow(part=part).fill([*own, *derive_totals(own)], part=part))
    pairs = list(dict.fromkeys(record["part"] for record in results.select(metric="transfer")))
    for sizes, title in SIZES_TITLES.items() if pairs else ():
        records = results.select(metric="transfer", sizes=sizes)
        means = derive_means(records, ("part", "features"))[:: len(MEANS)]
        features = list(dict.fromkeys(record["features"] for record in records))
        table = TABLE_4_4.narrow(part=pairs, features=features)
        tables.append(table.fill([*records, *means], sizes=title))
    clusters = [*percent_clusters(results.objects["clusters"])]
    tables += [FIGURE_4_4.fill(clusters), RULE.fill(clusters)]
    return [*tables[:-1], replace(tables[-1], notes=(*tables[-1].notes, *NOTES)), *campus]


def _tabulate_campus(results: Results) -> Iterator[FilledTable]:
    """Table 4.2 and Fig. 4.4e of MIT; nothing if its rooms were not read."""
    campus = results.details.get("campus")
    if campus:
        labels = [_in_percent(record) for record in results.select(part=MIT) if "label" in record]
        published = [record["label"] for record in read_published("table_4_2.csv") if record["part"] == MIT]
        where = {**TABLE_4_2.where, "label": [*dict.fromkeys([*campus["frequent"], *published])]}
        yield replace(TABLE_4_2, where=where).narrow(part=MIT).fill(labels, part=MIT, rooms=campus["rooms"])
        records = [*percent_clusters(results.objects["campus"])]
        counts = {"rooms": campus["rooms"], "buildings": campus["buildings"], "labels": len(campus["labels"])}
        yield CAMPUS_CLUSTERS.fill(records, **counts)


def _in_percent(record: Record) -> Record:
    return {**record, "value": 100 * record["value"]} if record["metric"] == "share" else record


def derive_means(records: Sequence[Record], names: Sequence[str]) -> list[Record]:
    """For each group of records with the same fields: the mean over algorithms, and its standard deviations."""
    groups: dict[tuple[str, ...], dict[str, list[float]]] = {}
    for record in records:
        by_algorithm = groups.setdefault(tuple(record[name] for name in names), {})
        by_algorithm.setdefault(record["algorithm"], []).append(record["value"])
    derived: list[Record] = []
    for key, folds in groups.items():
        means = [fmean(values) for values in folds.values()]
        figures = fmean(means), stdev(means), fmean(map(stdev, folds.values()))
        fields = dict(zip(names, key, strict=True))
        derived += [{**fields, "algorithm": name, "value": value} for name, value in zip(MEANS, figures, strict=True)]
    return derived


def derive_totals(confusion: Sequence[Record]) -> Iterator[Record]:
    """TP and FP of each true label, and TN of each predicted one, as in Table 4.3."""
    for record in confusion:
        value = record["value"]
        rest = None if value is None else 1 - value
        if record["label"] == "FN":
            yield {**record, "label": "TN", "value": rest}
        elif record["label"] == record["given"]:
            yield {**record, "given": "TP"}
            yield {**record, "given": "FP", "value": rest}


def percent_clusters(clusters: Sequence[RoomClusters]) -> Iterator[Record]:
    """The figures of clusters, shares in %, and the share of rooms whose distance is below ε."""
    for each in clusters:
        figures = {**each.figures, "bend": each.bend, "below": float((each.distances <= EPSILON).mean())}
        for metric, value in figures.items():
            percent = value if value is None or metric not in SHARES else 100 * value
            yield {"part": each.rooms, "features": each.scale, "metric": metric, "value": percent}
