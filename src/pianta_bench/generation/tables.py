"""Tables 7.1 and 7.2, clusters, convergence, and how much generated buildings differ from real ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from statistics import fmean, median
from types import MappingProxyType

from pianta.evaluation.graph_sets import STATISTICS, DiscrepancyRatio
from pianta_bench.generation import convergence, costs, distances, scores, stability
from pianta_bench.generation.clusters import keep_finite
from pianta_bench.generation.measure import (
    CORR,
    LEARNING,
    METRICS,
    NCUT,
    PUBLISHED_COSTS,
    REAL,
    REAL_AREAS,
    REAL_COPIES,
    REAL_HALF,
    TABLE_7_1,
    THESIS,
    TRAINING,
)
from pianta_bench.graphs.tables import LABELS as METRIC_LABELS
from pianta_bench.graphs.tables import TWO_DIGITS
from pianta_bench.harness.records import Figures, Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table, read_published

MODELS = [CORR, NCUT]
GENERATED = [CORR, NCUT, REAL_AREAS, PUBLISHED_COSTS, THESIS]
# The published part that a part is compared with; the thesis' samples are those of its `corr`.
PUBLISHED_PARTS = MappingProxyType({CORR: CORR, NCUT: NCUT, REAL_AREAS: CORR, PUBLISHED_COSTS: CORR, THESIS: CORR})
PUBLISHED_FLOORS = 50  # thesis, section 7.4
PUBLISHED_MEANS: Mapping[tuple[str, str], float] = MappingProxyType(
    {(record["part"], record["metric"]): float(record["mean"]) for record in read_published(TABLE_7_1)}
)
PUBLISHED_DIGITS = 3  # of the means
SIGNIFICANT = 0.05  # level of the Kolmogorov-Smirnov test; the usual one
LABELS = {**METRIC_LABELS, THESIS: "thesis' own", "labelled": "labels of the type only"}
METRIC_DIGITS = {metric: 2 if metric in TWO_DIGITS else 3 for metric in METRICS}

PUBLISHED_TYPE = "school"
ROWS = "Rows of Table 7.1"

GAPS = ("distance", "published distance", "p-value")
NEARER = "nearer to the real mean than published"
ALIKE = f"two-sample KS p > {SIGNIFICANT}"
CLUSTERS = (
    "functional areas",
    "clusters",
    "clusters by WL",
    "areas of the smallest cluster",
    "areas of the largest cluster",
    "clusters of one area",
    "similarity within a cluster",
    "similarity of a cluster to others",
    "loose clusters",
    "mixed clusters",
)
PROPOSAL = "proposal"
RATIO = "share of the distance of real floors"
HELD_OUT = [CORR, NCUT, REAL_AREAS, REAL_HALF]
PROPOSALS = (
    (costs.STEP_2, costs.FUNCTIONAL),
    (costs.STEP_2, costs.FUNCTIONAL_AT_ONCE),
    (costs.STEP_2, costs.FLOORS),
    (costs.STEP_4, costs.FLOORS),
    (costs.STEP_4, costs.FLOORS_AT_ONCE),
)


def pool_cells(ratios: list[DiscrepancyRatio]) -> Cell:
    """The pooled ratio of models, with its standard error instead of a standard deviation."""
    return Cell(keep_finite(scores.pool_ratios(ratios).ratio), scores.measure_ratio_error(ratios), count=len(ratios))


SetTable = partial(Table, labels=LABELS)
WorkTable = partial(Table, rows=("work",), summarise=Cell.only, digits=3)
# {samples}, {failed} and others are filled in by `tabulate`.
TABLES = (
    Table(
        title="Held out: discrepancy of models of half A from half B",
        rows=("statistic",),
        where={"metric": "pooled discrepancy", "part": HELD_OUT},
        summarise=pool_cells,
        digits=2,
        notes=(
            "{models} models, each of a half A of the real floors, drawn at random; no building has",
            "floors in both halves.",
            "From half B, of {subsamples} subsamples of a model's buildings, as many as half A has,",
            "over that of half A; of all models, ± its standard error.",
            f"{REAL_HALF}: its floors drawn with replacement: about the best possible for a",
            "model that knows only half A.",
        ),
    ),
    Table(
        title="Held out: models of half A separated from half B",
        rows=("classifier", "left_out"),
        where={"metric": scores.HELD_OUT_ACCURACY, "part": [*HELD_OUT, REAL_COPIES]},
        factor=100,
        unit="% right",
        notes=(
            "A graph of each side is left out; mean ± sd over models. Siblings: all floors of",
            "the building of the real one, and all that follow floors of the building of the",
            "other; as many of both sides remain. Buildings of real areas follow no floor.",
            f"{REAL_HALF}: its floors as they are; {REAL_COPIES}: each {{multiple}} times, as often as",
            "a model makes a building that follows it.",
        ),
    ),
    SetTable(
        title="Distance to the nearest real floor",
        where={"metric": list(distances.DISTANCES), "part": [REAL, *GENERATED]},
        summarise=Cell.median,
        digits={distances.STEPS: 0, distances.EDITS: 3, distances.WL_DISTANCE: 3},
        notes=(
            "Medians. real: of a real floor to the nearest one of another building;",
            "others: of a generated graph to the nearest real floor.",
            "edits: upper bound of the edit distance, over nodes and edges of both graphs;",
            "steps: areas of a cluster more or less, of areas that corr cuts again.",
        ),
    ),
    Table(
        title="Distance to the nearest real floor, as a share of that of real floors",
        rows=("row",),
        where={"metric": RATIO, "row": list(distances.DISTANCES), "part": GENERATED},
        labels=LABELS,
        summarise=Cell.only,
        digits=2,
    ),
    SetTable(
        title="Cluster configuration of the nearest real floor",
        where={"metric": [distances.SAME, distances.ONE_STEP], "part": [REAL, *GENERATED]},
        summarise=lambda values: Cell(fmean(values), count=len(values)),
        factor=100,
        unit="% of the graphs",
    ),
    SetTable(
        title="Table 7.1, metrics of {type}s: real, and generated by corr",
        where={"metric": list(METRICS), "part": [REAL, CORR]},
        digits=METRIC_DIGITS,
        published=TABLE_7_1,
        notes=(f"Floors: {{floors}} real (thesis {PUBLISHED_FLOORS}), {{count}} of each model (200).",),
    ),
    SetTable(
        title="Table 7.1, metrics of {type}s: the others",
        where={"metric": list(METRICS), "part": GENERATED[1:]},
        digits=METRIC_DIGITS,
        published=TABLE_7_1,
        notes=(
            f"{REAL_AREAS}: corr; areas of real floors as they are.",
            f"{PUBLISHED_COSTS}: corr; Γ1 by the distances to all floors, one door for each edge",
            "of Ĥ, P_conn by Ξ Λ Λ Υ alone.",
            "{samples}",
        ),
    ),
    SetTable(
        title="Table 7.1, distances of the means from the real ones, and Kolmogorov-Smirnov tests",
        rows=("row",),
        columns=("part", "figure"),
        where={"figure": list(GAPS)},
        summarise=Cell.only,
        digits=3,
        is_printed=False,
    ),
    SetTable(
        title=ROWS,
        rows=("figure",),
        where={"figure": [NEARER, ALIKE]},
        summarise=lambda values: Cell(int(sum(values))),
        unit="rows",
        notes=(
            "{failed}",
            "Nearer: than the thesis' generated mean is to its real one, both as published;",
            "if these are equal no row is nearer. KS: Kolmogorov-Smirnov.",
        ),
    ),
    Table(
        title="Section 7.3.3, clusters of functional areas",
        where={"metric": list(CLUSTERS), "part": MODELS},
        digits={metric: 3 if "similarity" in metric else 0 for metric in CLUSTERS},
        published="section_7_3_3.csv",
        notes=(
            f"The thesis has {PUBLISHED_FLOORS} schools, here are {{floors}} {{type}}s.",
            "loose: areas not more similar to each other than to those of all other clusters;",
            "mixed: not more than to those of one other cluster.",
            "Similarity: mean ± sd over clusters, of two areas of one or of two clusters.",
            "by WL: by the Weisfeiler-Lehman kernel; all other rows: by Graph Hopper.",
        ),
    ),
    Table(
        title="Clusters as the set of floors grows (section 7.3.3)",
        rows=("floors",),
        where={"metric": stability.CLUSTERS, "floors": [f"{size} floors" for size in stability.SIZES], "part": MODELS},
        notes=(f"Mean ± sd over {stability.DRAWS} sets of floors, drawn at random.",),
    ),
    SetTable(
        title="Validity of generated {type}s",
        where={"metric": list(scores.VALIDITY), "part": GENERATED},
        summarise=Cell.only,
        factor=100,
        unit="%",
        notes=("novel: no copy of a real one; unique: no copy of an earlier one.",),
    ),
    SetTable(
        title="Discrepancy of generated {type}s from real ones",
        rows=("statistic",),
        where={"metric": scores.DISCREPANCY, "side": "ratio", "statistic": list(STATISTICS), "part": GENERATED},
        summarise=Cell.only,
        digits=2,
        notes=(
            "Squared, from a half of the real floors, over that of the other half, means of",
            "{trials} splits. These models have seen both halves.",
        ),
    ),
    SetTable(
        title="Generated {type}s separated from all real ones",
        rows=("classifier", "left_out"),
        where={"metric": scores.ACCURACY, "part": GENERATED},
        factor=100,
        unit="% right",
        notes=(
            f"NSPDK: radius {scores.RADIUS}, distance {scores.DISTANCE}; WL: {scores.ITERATIONS} rounds.",
            f"{scores.FOREST}: {{trees}} trees.",
            f"Of {{draws}} draws of as many as are real, {scores.FOREST} {{forest_draws}}.",
            "One out: below 50 for equal sets; pair out: 50, copies below.",
        ),
    ),
    WorkTable(
        title="Table 7.2, an iteration for a building",
        where={"metric": costs.ITERATION, "work": list(costs.STEPS), "part": MODELS},
        factor=1000,
        published="table_7_2.csv",
        unit="ms",
        notes=(
            "Median of all iterations, over the {batch} buildings that run side by side.",
            "Published are orders of magnitude, with WL.",
            "Step 3 (published: 1 ms) is part of step 1, whose iterations are sweeps.",
        ),
    ),
    WorkTable(
        title="Table 7.2, an iteration for a building, by Graph Hopper",
        where={"metric": costs.HOPPER_ITERATION, "work": list(costs.STEPS), "part": MODELS},
        factor=1000,
        published="table_7_2_graph_hopper.csv",
        unit="ms",
        notes=(f"As above, {costs.HOPPER_BUILDINGS} buildings side by side; step 1 uses no kernel.",),
    ),
    WorkTable(
        title="Time on this machine",
        where={"metric": costs.SECONDS, "work": [TRAINING, LEARNING, *costs.STEPS, costs.ALL_STEPS], "part": MODELS},
        digits=2,
        unit="s",
        notes=(
            f"{TRAINING}: on {{floors}} floors; {LEARNING}: less than 60 s in the thesis.",
            "Steps are of all {count} buildings.",
        ),
    ),
    WorkTable(
        title="Rows of the Gram matrix from scratch",
        where={"metric": costs.GRAM_ROW, "part": MODELS},
        factor=1000,
        unit="ms",
        notes=(
            f"Of the WL Gram matrix, {costs.WL_ITERATIONS} rounds, of a graph of mean size. Medians.",
            "All at once: those of {count} graphs are computed together.",
        ),
    ),
    WorkTable(
        title="Proposals, in times of such a row",
        where={"metric": PROPOSAL},
        notes=(
            "Proposal: an iteration for one building, which hashes again only what changed,",
            "{batch} buildings side by side. Over a row: the gain of both; over a row of all at",
            "once, side by side too: of the first alone.",
        ),
    ),
    convergence.TABLE,
)


def tabulate(results: Results) -> list[FilledTable]:
    """Table 7.1, clusters, scores of sets and of models of a half, Table 7.2 and other times, and convergence."""
    gaps = [*derive_gaps(results)]
    derived = derive_discrepancies(results), derive_distances(results), derive_proposals(results)
    records = [*results.records, *gaps, *chain(*derived)]
    names = {
        **results.options["repeats"],
        "count": results.options["count"],
        "type": results.options["type"],
        "floors": len(results.objects["graphs"][REAL]),
        "batch": results.values(metric=costs.BATCH)[0],
        "samples": _describe_samples(results),
        "stopped": convergence.describe_stops(
            {part: model.mixing for part, model in results.objects["models"].items()}
        ),
        "failed": "\n".join(_list_failed(gaps)),
    }
    tables: tuple[Table, ...] = TABLES
    if results.options["type"] != PUBLISHED_TYPE:
        # The thesis prints figures of schools only.
        tables = tuple(replace(table, published="") for table in TABLES if table.title != ROWS)
    return [table.fill(records, **names) for table in tables]


def derive_gaps(results: Results) -> Iterator[Record]:
    """How far the mean of each metric of Table 7.1 is from the real one, by generated part."""
    for part in GENERATED:
        for metric in METRICS if part in results.objects["graphs"] else ():
            real, generated = (results.values(part=each, metric=metric) for each in (REAL, part))
            published = PUBLISHED_MEANS[REAL, metric], PUBLISHED_MEANS[PUBLISHED_PARTS[part], metric]
            for figure, value in compare_figures(real, generated, published).items():
                yield {"part": part, "row": metric, "figure": figure, "value": value}


def compare_figures(real: Sequence[float], generated: Sequence[float], published: tuple[float, float]) -> Figures:
    """Distance of the means here and published, p-value of the two-sample Kolmogorov-Smirnov test, NEARER and ALIKE.

    published: the means of real and of generated graphs. Distance and p-value are None if one of the sets is empty.
    If the published means are equal, none is nearer.
    """
    from scipy.stats import ks_2samp

    published_distance = round(abs(published[1] - published[0]), PUBLISHED_DIGITS)
    if not real or not generated:
        return {**dict.fromkeys(GAPS), GAPS[1]: published_distance, NEARER: False, ALIKE: False}
    distance, p_value = abs(fmean(generated) - fmean(real)), float(ks_2samp(real, generated).pvalue)
    return {
        **dict(zip(GAPS, (distance, published_distance, p_value), strict=True)),
        NEARER: distance < published_distance,
        ALIKE: p_value > SIGNIFICANT,
    }


def derive_discrepancies(results: Results) -> Iterator[Record]:
    """The held-out discrepancies of each model, a DiscrepancyRatio each."""
    for part in HELD_OUT:
        for statistic in STATISTICS:
            fields = {"part": part, "statistic": statistic}
            sides = (
                results.values(metric=scores.HELD_OUT_DISCREPANCY, side=side, **fields)
                for side in ("generated", "real")
            )
            for pair in zip(*sides, strict=True):
                yield {**fields, "metric": "pooled discrepancy", "value": DiscrepancyRatio(*pair)}


def derive_distances(results: Results) -> Iterator[Record]:
    """The median distance of each generated part to its nearest floor, over that of real floors; None if that is 0."""
    for metric in distances.DISTANCES:
        real = median(results.values(part=REAL, metric=metric))
        for part in GENERATED:
            if values := results.values(part=part, metric=metric):
                yield {"part": part, "metric": RATIO, "row": metric, "value": median(values) / real if real else None}


def derive_proposals(results: Results) -> Iterator[Record]:
    """An iteration over a row of the Gram matrix, and a row of all at once over one alone."""
    for part in MODELS:
        iterations, rows = (
            {record["work"]: record["value"] for record in results.select(part=part, metric=metric)}
            for metric in (costs.ITERATION, costs.GRAM_ROW)
        )
        for work, row in (*PROPOSALS, (costs.FLOORS_AT_ONCE, costs.FLOORS)):
            seconds = (iterations | rows)[work]
            value = None if seconds is None else seconds / rows[row]
            yield {"part": part, "metric": PROPOSAL, "work": f"{work} / {row}", "value": value}


def _list_failed(gaps: Iterable[Record]) -> Iterator[str]:
    """Notes that name the rows of Table 7.1 that do not count."""
    failed: dict[tuple[str, str], list[str]] = {}
    for gap in gaps:
        if gap["figure"] in {NEARER, ALIKE}:
            names = failed.setdefault((gap["part"], gap["figure"]), [])
            names += [METRIC_LABELS[gap["row"]]] * (not gap["value"])
    for (part, figure), names in failed.items():
        heading = "not nearer" if figure == NEARER else "p too small"
        yield f"{LABELS.get(part, part)}, {heading}: {', '.join(names) or 'none'}."


def _describe_samples(results: Results) -> str:
    if results.options["type"] != PUBLISHED_TYPE:
        return "The thesis has samples of schools only."
    if THESIS not in results.objects["graphs"]:
        return "The thesis' own samples are not in the data and have no column."
    return f"{LABELS[THESIS]}: {len(results.objects['graphs'][THESIS])} of its 200 by corr, measured here."
