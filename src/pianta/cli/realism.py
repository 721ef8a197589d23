"""The verb realism: whether floors are built like real ones, and why not."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from pianta.cli.json_output import Json, check_json, write_json
from pianta.cli.terminal import Quiet, print_error, print_result, track_items
from pianta.errors import BuildingWarning, ModelError, OptionError, PiantaError
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.io._files import real_path, short_repr
from pianta.io._folders import atomic_folder, check_output_folder, choose_names
from pianta.io.buildings.read import list_buildings, read_buildings
from pianta.labels import LabelSet, standard_building_type

if TYPE_CHECKING:
    from pianta.building_types.description import BuildingDescription
    from pianta.realism.model import Realism, RealismModel
    from pianta.rooms.completion import CoarseFloor

EXAMPLES = (
    "pianta realism world.xml --reference offices",
    "pianta realism worlds/*.xml --reference offices -o pictures",
    "pianta realism world.xml --reference offices --unrealistic other_worlds --json world.json",
    "pianta realism building/floor.geojson --type office",
)
# In the folder of pictures, for `pianta view`.
RESULTS = "realism.json"
LABEL_SETS = (LabelSet.R_C, LabelSet.F_C_E_S)

Floors = Annotated[list[str], typer.Argument(metavar="FLOOR", help="Files of floors, or folders of them.")]
ReferenceFolders = Annotated[
    list[str] | None,
    typer.Option(
        "--reference",
        metavar="BUILDINGS",
        help="Real floors, files or folders of them, may be repeated; the included floors unless given.",
    ),
]
Unrealistic = Annotated[
    list[str] | None,
    typer.Option(metavar="BUILDINGS", help="Unrealistic floors, may be repeated; optional."),
]
Type = Annotated[
    list[str] | None,
    typer.Option("--type", metavar="NAME", help="Of the included floors only those of a type, may be repeated."),
]
Labels = Annotated[
    str | None,
    typer.Option(help="Label set: R/C or F/C/E/S. Unless given: R/C, or that of the included floors."),
]
Out = Annotated[
    Path | None, typer.Option("--out", "-o", help="Folder for NAME.png, a picture of every floor, and realism.json.")
]
Reasons = Annotated[bool, typer.Option("--reasons", help="Print the reasons for several floors too.")]


@dataclass(frozen=True)
class Reference:
    """What floors are compared with.

    model: of the reference floors. summary: a line that describes it. buildings: the building of each of its files, by
    resolved path. failed: whether a file could not be read.
    """

    model: RealismModel
    summary: str
    buildings: Mapping[Path, str] = field(default_factory=dict)
    failed: bool = False

    def assess(self, floor: Floor, path: Path) -> Assessment:
        """Compare the floor of a file with the reference, without its own building if that is in the reference.

        The building is found by the path of the file, or else by a reference floor that is the same.
        """
        from pianta.building_types.description import describe_building
        from pianta.rooms.completion import fill_missing_labels

        coarse = fill_missing_labels(floor, self.model.label_set)
        try:
            description = describe_building(coarse.floor, self.model.label_set)
            building = self.buildings.get(real_path(path)) or self.model.find_building(description)
            model = self.model if building is None else self.model.leave_out(building)
            realism = model.assess_description(description, [room.id for room in coarse.floor.rooms])
        except PiantaError as error:
            raise type(error)(f"floor {short_repr(path)}: {error}") from error
        return Assessment(coarse, realism, building is not None)


@dataclass(frozen=True)
class Assessment:
    """The realism of a floor; left_out: whether its building was left out of the reference."""

    coarse: CoarseFloor
    realism: Realism
    left_out: bool

    @property
    def floor(self) -> Floor:
        """The floor with a label of each room in the label set."""
        return self.coarse.floor

    def __str__(self) -> str:
        """The result in a line."""
        labelled, rooms = len(self.coarse.predicted), len(self.floor.rooms)
        notes = [f"labels of {labelled} of {rooms} rooms by pianta"] if labelled else []
        notes += ["its building left out of the reference"] if self.left_out else []
        noted = f" ({'; '.join(notes)})" if notes else ""
        return f"{self.floor.source}: {self.realism.score:.2f}, {self.realism.verdict}{noted}"

    def as_json(self) -> dict[str, object]:
        """The result, as values that JSON can hold."""
        notes = {"labels_by_pianta": self.coarse.predicted, "left_out": self.left_out}
        return {"floor": self.floor.source} | notes | self.realism.as_json()


def assess_floors(
    floors: Floors,
    *,
    reference: ReferenceFolders = None,
    unrealistic: Unrealistic = None,
    building_type: Type = None,
    labels: Labels = None,
    json_file: Json = None,
    out: Out = None,
    reasons: Reasons = False,
    quiet: Quiet = False,
) -> None:
    """Assess whether floors are built like real ones, and why not.

    The score of a floor is its typicality: the share of the reference floors
    that are less typical. It is 0 for a floor that is less typical than all
    of them, and 0.5 for the median real floor. With --unrealistic the score is
    the probability that the floor is realistic.

    Floors are layout XML, KTH XML, MIT XML, HouseExpo JSON or floor.geojson of
    `pianta read`.
    Rooms without a manual label are labelled by pianta. A floor that is in the
    reference is compared without its own building. If a floor cannot be read,
    the others are still assessed; the exit code is then 1.
    """
    quiet = check_json(json_file, quiet=quiet)
    if out:
        check_output_folder(out)
    files = list_buildings(floors)
    chosen = _read_reference(reference, unrealistic, building_type, labels, quiet=quiet)
    if not quiet:
        print_result(chosen.summary)
    assessments = _assess_all(files, chosen, show_reasons=len(files) == 1 or reasons, quiet=quiet)
    write_json(_describe([assessment.as_json() for assessment in assessments], chosen.model), json_file)
    if out:
        _save_pictures(assessments, chosen.model, out)
    if chosen.failed or len(assessments) < len(files):
        raise typer.Exit(1)


def _assess_all(files: Sequence[Path], reference: Reference, *, show_reasons: bool, quiet: bool) -> list[Assessment]:
    """Assess the floors of files, and print each result; an error of one of several files is printed, too."""
    assessments = []
    for path, result in read_buildings(files, track=partial(track_items, quiet=quiet)):
        try:
            if isinstance(result, PiantaError):
                raise result
            assessment = reference.assess(result, path)
        except PiantaError as error:
            if len(files) == 1:
                raise
            print_error(error)
            continue
        assessments.append(assessment)
        if not quiet:
            print_result(str(assessment))
        if show_reasons and not quiet:
            print_result(f"  most like {', '.join(assessment.realism.alike)}")
            for reason in assessment.realism.reasons or ("nothing is unusual",):
                print_result(f"  {reason}")
    return assessments


def _describe(floors: Sequence[Mapping[str, object]], model: RealismModel) -> dict[str, object]:
    return {
        "label_set": str(model.label_set),
        "reference": [floor.source for floor in model.reference_floors],
        "unrealistic": [floor.source for floor in model.unrealistic_floors],
        "floors": floors,
    }


def _save_pictures(assessments: Sequence[Assessment], model: RealismModel, out: Path) -> None:
    """Write a picture of each floor into the folder of the option --out, and the results with the shapes of floors."""
    from pianta.io.floors import describe_floor
    from pianta.plot.figure import save_figure
    from pianta.plot.realism import draw_realism

    names = name_pictures([assessment.floor.source for assessment in assessments])
    with atomic_folder(out) as new:
        for name, assessment in zip(names, assessments, strict=True):
            save_figure(draw_realism(assessment.floor, assessment.realism), new / name)
        floors = [{**each.as_json(), "shapes": describe_floor(each.floor)} for each in assessments]
        write_json(_describe(floors, model), new / RESULTS)


def name_pictures(sources: Sequence[str]) -> list[str]:
    """A file name for the picture of each floor, all different: its stem; if stems repeat, its name; then a number.

    Folders become part of the name.
    """
    names = [source.replace("/", "_") for source in sources]
    stems = [name.rpartition(".")[0] or name for name in names]
    return [f"{name}.png" for name in choose_names(stems, names)]


def _read_reference(
    reference: Sequence[str] | None,
    unrealistic: Sequence[str] | None,
    types: Sequence[str] | None,
    labels: str | None,
    *,
    quiet: bool,
) -> Reference:
    """The reference that the options --reference, --unrealistic, --type and --labels give."""
    from pianta.realism.model import train_realism

    label_set = _read_label_set(labels)
    if not reference:
        return _use_included(unrealistic, types, label_set)
    if types:
        raise OptionError("--reference makes --type useless, leave either out")
    _check_classes(reference, unrealistic or ())
    label_set = label_set or LabelSet.R_C
    groups = [list_buildings(paths) for paths in (reference, unrealistic or ())]
    real, others = (_read_floors(files, label_set, quiet=quiet) for files in groups)
    coarse = [[each.coarse.floor for each in floors] for floors in (real, others)]
    model = train_realism(coarse[0], label_set=label_set, unrealistic=coarse[1])
    buildings = _map_files_to_buildings(others, model.unrealistic_floors, model.unrealistic_buildings)
    buildings |= _map_files_to_buildings(real, model.reference_floors, model.buildings)
    failed = len(real) + len(others) < sum(map(len, groups))
    return Reference(model, _summarise(model, [*real, *others]), buildings, failed)


def _map_files_to_buildings(
    floors: Sequence[ReferenceFloor], descriptions: Sequence[BuildingDescription], buildings: Sequence[str]
) -> dict[Path, str]:
    """The building of each file whose floor is in a model.

    floors: all that were read. descriptions: of the floors in the model, which have the same sources. buildings: of
    these descriptions, in order.
    """
    paths = {each.coarse.floor.source: each.path for each in floors}
    return {paths[each.source]: building for each, building in zip(descriptions, buildings, strict=True)}


def _check_classes(reference: Sequence[str], unrealistic: Sequence[str]) -> None:
    """Raise OptionError for files that are given both as realistic and as unrealistic."""
    real = {real_path(file) for file in list_buildings(reference)}
    both = [short_repr(file) for file in list_buildings(unrealistic) if real_path(file) in real]
    if both:
        raise OptionError(f"--reference and --unrealistic both give {join_faults(both)}, leave each out of either")


def _use_included(
    unrealistic: Sequence[str] | None, types: Sequence[str] | None, label_set: LabelSet | None
) -> Reference:
    """The floors that come with pianta, all or those of some types, as reference."""
    from pianta.building_types.model_file import read_default_building_type_model
    from pianta.realism.model import reference_from_types

    if unrealistic:
        raise OptionError("--unrealistic needs --reference, give the folder of real floors")
    names = [standard_building_type(name) for name in types or ()]
    model = reference_from_types(read_default_building_type_model(), names)
    if label_set not in (None, model.label_set):
        raise OptionError(f"the floors that come with pianta have labels of {model.label_set}, give --reference")
    chosen = f" of type {' and '.join(types)}" if types else ""
    return Reference(model, f"{_summarise(model)}, of those{chosen} that come with pianta")


def _read_label_set(labels: str | None) -> LabelSet | None:
    """The label set of the option --labels, None without it; raises OptionError for any other text."""
    if labels is None:
        return None
    label_sets = {str(label_set).lower(): label_set for label_set in LABEL_SETS}
    if labels.lower() not in label_sets:
        raise OptionError(f"--labels is {labels!r}, give {' or '.join(map(str, LABEL_SETS))}")
    return label_sets[labels.lower()]


class ReferenceFloor(NamedTuple):
    """A floor with labels in the label set, and the resolved path of its file."""

    path: Path
    coarse: CoarseFloor
    has_defects: bool


def _read_floors(files: Sequence[Path], label_set: LabelSet, *, quiet: bool) -> list[ReferenceFloor]:
    """Read reference floors; defects in their files are counted, not printed, as a reference is read many times."""
    from pianta.rooms.completion import fill_missing_labels

    floors = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", BuildingWarning)
        for path, result in read_buildings(files, track=partial(track_items, quiet=quiet)):
            has_defects = bool(caught)
            if isinstance(result, PiantaError):
                print_error(result)
            else:
                floors.append(ReferenceFloor(real_path(path), fill_missing_labels(result, label_set), has_defects))
            caught.clear()
    if files and not floors:
        raise ModelError(f"none of {len(files)} reference buildings could be read, so there is nothing to compare with")
    return floors


def _summarise(model: RealismModel, floors: Sequence[ReferenceFloor] = ()) -> str:
    """The reference in a line."""
    counts = f"{len(model.reference_floors)} floors of {len(set(model.buildings))} buildings"
    against = f" against {len(model.unrealistic_floors)} unrealistic floors" if model.unrealistic_floors else ""
    by_pianta, defective = sum(len(each.coarse.predicted) for each in floors), sum(each.has_defects for each in floors)
    notes = [f"labels {model.label_set}"]
    notes += [f"{by_pianta} of them by pianta"] if by_pianta else []
    notes += [f"{defective} files with defects"] if defective else []
    return f"reference: {counts}{against}, {', '.join(notes)}"
