"""The verb realism: whether an environment is built like real ones, and why not."""

from __future__ import annotations

import json
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pianta import __version__
from pianta.cli.terminal import print_error, print_result, track_items
from pianta.errors import BuildingWarning, ModelError, OptionError, PiantaError
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder, check_output_folder
from pianta.io.buildings.read import list_buildings, name_sources, read_building
from pianta.labels import LabelSet, standard_building_type

if TYPE_CHECKING:
    from pianta.realism.model import Realism, RealismModel
    from pianta.rooms.completion import CoarseFloor

EXAMPLES = (
    "pianta realism world.xml --reference offices",
    "pianta realism worlds/*.xml --reference offices -o judged",
    "pianta realism world.xml --reference offices --unrealistic other_worlds --json world.json",
    "pianta realism building/floor.geojson --type office",
)
LABEL_SETS = (LabelSet.R_C, LabelSet.F_C_E_S)

Floors = Annotated[list[str], typer.Argument(metavar="FLOOR", help="Files of floors, or folders of them.")]
ReferenceFolders = Annotated[
    list[str] | None,
    typer.Option(
        "--reference",
        metavar="BUILDINGS",
        help="Real floors, files or folders of them, may be repeated; those that come with pianta unless given.",
    ),
]
Unrealistic = Annotated[
    list[str] | None,
    typer.Option(metavar="BUILDINGS", help="Floors known to be unrealistic, may be repeated; none are needed."),
]
Type = Annotated[
    list[str] | None,
    typer.Option("--type", metavar="NAME", help="Of the floors that come with pianta only those of a type."),
]
Labels = Annotated[
    str | None,
    typer.Option(help="What is known of rooms: R/C or F/C/E/S; R/C, or as the floors of pianta, unless given."),
]
Json = Annotated[
    Path | None, typer.Option("--json", metavar="FILE", help="File for scores and reasons of every floor, as JSON.")
]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="Folder for NAME.png, a picture of every floor.")]
Reasons = Annotated[bool, typer.Option("--reasons", help="Print the reasons for several floors too.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors.")]


@dataclass(frozen=True)
class Reference:
    """What floors are judged by.

    model: of the reference floors. buildings: of the files that it was learnt from, by their places on the disk.
    about: what it is, in a line. failed: whether a file could not be read.
    """

    model: RealismModel
    buildings: Mapping[Path, str]
    about: str
    failed: bool = False

    def assess(self, file: str) -> Judged:
        """Judge the floor of a file; by the others when the file, or one of the same floor, is in the reference."""
        from pianta.building_types.description import describe_building
        from pianta.rooms.completion import fill_missing_labels

        coarse = fill_missing_labels(read_building(file), self.model.label_set)
        try:
            told = describe_building(coarse.floor, self.model.label_set)
            building = self.buildings.get(Path(file).resolve()) or self.model.find_building(told)
            model = self.model if building is None else self.model.leave_out(building)
            ids = [room.id for room in coarse.floor.rooms]
            return Judged(coarse, model.assess_description(told, ids), building is not None)
        except PiantaError as error:
            raise type(error)(f"floor {short_repr(file)}: {error}") from error


@dataclass(frozen=True)
class Judged:
    """A floor with what is said of it. left_out: whether its building is among the reference and was left out."""

    coarse: CoarseFloor
    realism: Realism
    left_out: bool

    @property
    def notes(self) -> str:
        """What a reader must know about the labels and the reference, in brackets."""
        rooms, found = len(self.coarse.floor.rooms), len(self.coarse.predicted)
        notes = [f"labels of {found} of {rooms} rooms by pianta"] if found else []
        notes += ["its building left out of the reference"] if self.left_out else []
        return f" ({'; '.join(notes)})" if notes else ""


def judge_floors(
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
    """Judge whether floors are built like real ones, and say why not.

    The score of a floor is its typicality: the share of the reference floors
    that are less like the others than it is. It is 0 for a floor that is less
    so than any of them, and 0.5 for the median real floor. With --unrealistic the
    score is the probability that the floor is realistic.

    Floors are layout XML, KTH XML, MIT XML, HouseExpo JSON or floor.geojson of
    `pianta read`.
    Rooms that nobody has labelled are labelled by pianta. A floor that is in
    the reference is judged without its building. A floor that cannot be read
    does not stop the others; the exit code is then 1.
    """
    _check_outputs(json_file, out)
    files = [str(file) for file in list_buildings(floors)]
    known = _learn(reference, unrealistic, building_type, labels, quiet=quiet)
    if not quiet:
        print_result(known.about)
    judged = _judge_all(files, known, show=len(files) == 1 or reasons, quiet=quiet)
    if json_file:
        with atomic_folder(json_file.parent) as new:
            content = {"pianta": __version__, **_describe(known.model), "floors": _list_floors(judged)}
            text = json.dumps(content, indent=1, allow_nan=False) + "\n"
            (new / json_file.name).write_text(text, encoding="utf-8")
    if out:
        _draw_all(judged, out)
    if known.failed or len(judged) < len(files):
        raise typer.Exit(1)


def name_pictures(names: Sequence[str]) -> list[str]:
    """A file name for the picture of each floor, all different: its stem; where stems repeat its name; then a number.

    Folders become part of it. Names that differ in case alone are one on some disks.
    """
    flat = [name.replace("/", "_") for name in names]
    stems = [name.rpartition(".")[0] or name for name in flat]
    occurrences = Counter(stem.casefold() for stem in stems)
    pictures: dict[str, str] = {}
    for name, stem in zip(flat, stems, strict=True):
        chosen = stem if occurrences[stem.casefold()] == 1 else name
        numbered = (f"{chosen}.png" if number == 1 else f"{chosen}-{number}.png" for number in count(1))
        free = next(candidate for candidate in numbered if candidate.casefold() not in pictures)
        pictures[free.casefold()] = free
    return list(pictures.values())


def _learn(
    reference: Sequence[str] | None,
    unrealistic: Sequence[str] | None,
    types: Sequence[str] | None,
    labels: str | None,
    *,
    quiet: bool,
) -> Reference:
    from pianta.realism.model import train_realism

    label_set = _read_label_set(labels)
    if not reference:
        return _use_default(unrealistic, types, label_set)
    if types:
        raise OptionError("--reference makes --type useless, leave either out")
    _check_classes(reference, unrealistic or ())
    label_set = label_set or LabelSet.R_C
    real, others = (_read_floors(paths, label_set, quiet=quiet) for paths in (reference, unrealistic or ()))
    model = train_realism(real.floors, label_set=label_set, unrealistic=others.floors)
    known = zip(model.reference_floors, model.buildings, strict=True)
    unrealistic_pairs = zip(model.unrealistic_floors, model.unrealistic_buildings, strict=True)
    buildings = {others.places[description.source]: building for description, building in unrealistic_pairs}
    buildings |= {real.places[description.source]: building for description, building in known}
    return Reference(model, buildings, _tell_reference(model, real, others), real.failed or others.failed)


def _check_classes(reference: Sequence[str], unrealistic: Sequence[str]) -> None:
    """Refuse files that are said to be both realistic and not."""
    real = {file.resolve() for file in list_buildings(reference)}
    both = [short_repr(file) for file in list_buildings(unrealistic) if file.resolve() in real]
    if both:
        raise OptionError(f"--reference and --unrealistic both give {join_faults(both)}, leave each out of either")


def _use_default(
    unrealistic: Sequence[str] | None, types: Sequence[str] | None, label_set: LabelSet | None
) -> Reference:
    """The floors that come with pianta, those of some types."""
    from pianta.building_types.model_file import read_default_building_type_model
    from pianta.realism.model import reference_from_types

    if unrealistic:
        raise OptionError("--unrealistic needs --reference, give the folder of real floors")
    model = reference_from_types(
        read_default_building_type_model(), [standard_building_type(name) for name in types or ()]
    )
    if label_set not in (None, model.label_set):
        raise OptionError(f"the floors that come with pianta have labels of {model.label_set}, give --reference")
    kinds = f" of type {' and '.join(types)}" if types else ""
    return Reference(model, {}, f"{_tell_reference(model)}, of those{kinds} that come with pianta")


def _read_label_set(labels: str | None) -> LabelSet | None:
    if labels is None:
        return None
    known = {str(label_set).lower(): label_set for label_set in LABEL_SETS}
    if labels.lower() not in known:
        raise OptionError(f"--labels is {labels!r}, give {' or '.join(map(str, LABEL_SETS))}")
    return known[labels.lower()]


@dataclass(frozen=True)
class ReferenceFloors:
    """Floors with labels in the label set, and their places on the disk by source.

    found: how many labels pianta has found. repaired: how many files had defects. failed: whether one was not read.
    """

    floors: tuple[Floor, ...]
    places: Mapping[str, Path]
    found: int
    repaired: int
    failed: bool


def _read_floors(paths: Sequence[str], label_set: LabelSet, *, quiet: bool) -> ReferenceFloors:
    """Read floors; of defects in their files only the number is told, as a reference is given many times."""
    from pianta.rooms.completion import fill_missing_labels

    files = [str(file) for file in list_buildings(paths)]
    floors: list[CoarseFloor] = []
    places, repaired = {}, 0
    for file, source in zip(track_items(files, quiet=quiet), name_sources(files), strict=True):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", BuildingWarning)
            try:
                floor = replace(read_building(file), source=source)
            except PiantaError as error:
                print_error(error)
                continue
        floors.append(fill_missing_labels(floor, label_set))
        places[source] = Path(file).resolve()
        repaired += bool(caught)
    if files and not floors:
        raise ModelError(f"none of {len(files)} reference buildings could be read, so there is nothing to compare with")
    found = sum(len(floor.predicted) for floor in floors)
    return ReferenceFloors(tuple(each.floor for each in floors), places, found, repaired, len(floors) < len(files))


def _tell_reference(model: RealismModel, *read: ReferenceFloors) -> str:
    """What the reference is, in a line."""
    counts = f"{len(model.reference_floors)} floors of {len(set(model.buildings))} buildings"
    against = f" against {len(model.unrealistic_floors)} unrealistic floors" if model.unrealistic_floors else ""
    repaired, found = sum(floors.repaired for floors in read), sum(floors.found for floors in read)
    notes = [f"labels {model.label_set}", *[f"{found} of them by pianta"] * bool(found)]
    notes += [f"{repaired} files with defects"] * bool(repaired)
    return f"reference: {counts}{against}, {', '.join(notes)}"


def _judge_all(files: Sequence[str], known: Reference, *, show: bool, quiet: bool) -> dict[str, Judged]:
    """What is said of each floor by its name, told on the way; one that fails is told too, and stops no others."""
    judged = {}
    for file, name in zip(track_items(files, quiet=quiet), name_sources(files), strict=True):
        try:
            found = known.assess(file)
        except PiantaError as error:
            if len(files) == 1:
                raise
            print_error(error)
            continue
        judged[name] = replace(found, coarse=replace(found.coarse, floor=replace(found.coarse.floor, source=name)))
        if not quiet:
            _tell_judged(name, found, show=show)
    return judged


def _tell_judged(name: str, judged: Judged, *, show: bool) -> None:
    print_result(f"{name}: {judged.realism.score:.2f}, {judged.realism.verdict}{judged.notes}")
    if show:
        print_result(f"  most like {', '.join(judged.realism.alike)}")
        for reason in judged.realism.reasons or ("nothing is unusual",):
            print_result(f"  {reason}")


def _describe(model: RealismModel) -> dict[str, object]:
    return {
        "label_set": str(model.label_set),
        "reference": [floor.source for floor in model.reference_floors],
        "unrealistic": [floor.source for floor in model.unrealistic_floors],
    }


def _list_floors(judged: Mapping[str, Judged]) -> list[dict[str, object]]:
    return [
        {"floor": name, "labels_by_pianta": each.coarse.predicted, "left_out": each.left_out} | each.realism.as_json()
        for name, each in judged.items()
    ]


def _draw_all(judged: Mapping[str, Judged], out: Path) -> None:
    from pianta.plot.figure import save_figure
    from pianta.plot.realism import draw_realism

    with atomic_folder(out) as new:
        for file, each in zip(name_pictures([*judged]), judged.values(), strict=True):
            save_figure(draw_realism(each.coarse.floor, each.realism), new / file)


def _check_outputs(json_file: Path | None, out: Path | None) -> None:
    """Refuse, before any work, a JSON file or a folder of pictures that cannot be written."""
    for folder in (json_file and json_file.parent, out):
        if folder:
            check_output_folder(folder)
    if json_file and json_file.is_dir():
        raise OptionError(f"JSON file {short_repr(json_file)} is a folder, give the name of a file")
