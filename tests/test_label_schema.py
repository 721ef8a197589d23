"""Round trips of schemas in labels.yaml are exact, and other files are refused."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import LabelError, PiantaError
from pianta.io.label_schemas import MAX_FILE_BYTES, read_label_schema, save_label_schema
from pianta.labels import FCES, OFFICE, RC, SCHOOL, GeneralLabel, Label, LabelSchema, LabelSet
from tests.mutation import mutated, refused_in_one_line

PAGE = Path(__file__).parents[1] / "docs" / "methods" / "labels.md"
HEADER = "format: pianta labels\nversion: '1.0'\nbuilding_type: hospital\n"
GENERALS = {
    FCES.FUNCTIONAL: "SMB",
    FCES.CONNECTION: "CH",
    FCES.ENTRANCE: "CHSMB",
    FCES.SERVICE: "SMB",
}

names = st.text(min_size=1, max_size=30).filter(lambda name: name.strip().isprintable() and name.upper().strip())


@st.composite
def labels(draw) -> Label:
    function = draw(st.sampled_from(FCES))
    return Label(
        draw(names),
        function,
        GeneralLabel(draw(st.sampled_from(GENERALS[function]))),
        draw(st.from_regex("#[0-9a-fA-F]{6}", fullmatch=True)),
        draw(st.none() | st.sampled_from(FCES)),
        draw(st.none() | st.booleans()),
    )


schemas = st.builds(LabelSchema, names, st.lists(labels(), min_size=1, max_size=5, unique_by=lambda label: label.name))


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("schemas") / "labels.yaml"


def read_text(path, text) -> LabelSchema:
    path.write_text(HEADER + text, encoding="utf-8")
    return read_label_schema(path)


def block_of_page(language) -> str:
    (block,) = re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    return str(block)


@pytest.mark.parametrize("schema", [SCHOOL, OFFICE])
def test_schemas_of_the_thesis_survive(path, schema):
    save_label_schema(schema, path)
    assert read_label_schema(path) == schema


@pytest.mark.slow
@given(schema=schemas)
def test_round_trip_is_exact_and_stable(path, schema):
    save_label_schema(schema, path)
    content = path.read_bytes()
    assert read_label_schema(path) == schema
    save_label_schema(read_label_schema(path), path)
    assert path.read_bytes() == content


def test_each_label_is_written_on_one_line(path):
    gym = Label("GYM", FCES.SERVICE, GeneralLabel.BIG, "#a81e1e", FCES.FUNCTIONAL)
    foyer = Label("FOYER È", FCES.ENTRANCE, GeneralLabel.HALL, "#ffffff", corridor_in_graphs=True)
    save_label_schema(LabelSchema("Sports Hall", (gym, foyer)), path)
    assert path.read_text(encoding="utf-8") == (
        "format: pianta labels\n"
        "version: '1.0'\n"
        "building_type: sports hall\n"
        "labels:\n"
        "- {name: GYM, function: SERVICE, general: B, color: '#a81e1e', in_experiments: FUNCTIONAL}\n"
        "- {name: FOYER È, function: ENTRANCE, general: H, color: '#ffffff', corridor_in_graphs: true}\n"
    )


def test_missing_fields_are_derived_from_the_function(path):
    schema = read_text(
        path,
        "labels:\n"
        "- {name: ward, function: functional}\n"
        "- {name: way, function: Connection}\n"
        "- {name: lift, function: ENTRANCE}\n"
        "- {name: linen, function: SERVICE}\n",
    )
    assert schema == LabelSchema(
        "hospital",
        (
            Label("WARD", FCES.FUNCTIONAL, GeneralLabel.MEDIUM, "#1bddf2"),
            Label("WAY", FCES.CONNECTION, GeneralLabel.CORRIDOR, "#f28705"),
            Label("LIFT", FCES.ENTRANCE, GeneralLabel.MEDIUM, "#268080"),
            Label("LINEN", FCES.SERVICE, GeneralLabel.MEDIUM, "#8c8c8b"),
        ),
    )


@pytest.mark.parametrize("key", ["size", "general"])
@pytest.mark.parametrize(
    ("word", "function", "general"),
    [
        ("c", "CONNECTION", GeneralLabel.CORRIDOR),
        ("Hall", "CONNECTION", GeneralLabel.HALL),
        ("SMALL", "SERVICE", GeneralLabel.SMALL),
        ("medium", "SERVICE", GeneralLabel.MEDIUM),
        ("B", "SERVICE", GeneralLabel.BIG),
    ],
)
def test_sizes_are_letters_or_words(path, key, word, function, general):
    schema = read_text(path, f"labels: [{{name: A, function: {function}, {key}: {word}}}]")
    assert schema.labels[0].general is general


def test_names_are_normalised_and_stay_words(path):
    schema = read_text(path, "labels: [{name: '  waiting   room ', function: SERVICE}, {name: NO, function: SERVICE}]")
    assert list(schema.by_name) == ["WAITING ROOM", "NO"]
    assert read_text(path, "labels: [{name: 12, function: SERVICE}]").labels[0].name == "12"


def test_conventions_of_the_file_are_used(path):
    text = "labels: [{name: A, function: SERVICE, in_experiments: functional, corridor_in_graphs: yes}]"
    label = read_text(path, text).labels[0]
    assert (label.in_experiments, label.corridor_in_graphs) == (FCES.FUNCTIONAL, True)


def test_faults_are_listed_together(path):
    with pytest.raises(LabelError) as error:
        read_text(
            path,
            "labels:\n"
            "- {name: ' ', function: WORK, colour: '#ffffff'}\n"
            "- {name: A, function: SERVICE, size: HUGE, color: red}\n"
            "- name: a\n  function: SERVICE\n  color: #ff0000\n"
            "- {name: [B], function: SERVICE, corridor_in_graphs: maybe}\n"
            "- {name: C, function: SERVICE, size: S, general: S}\n",
        )
    parts = str(error.value).partition(f"'{path}': ")[2].split("; ")
    assert [part.partition(": ")[0] for part in parts] == [
        "labels[0].name",
        "labels[0].function",
        "labels[0].colour",
        "labels[1].size",
        "labels[1].color",
        "labels[2].name",
        "labels[2].color",
        "labels[3].name",
        "labels[3].corridor_in_graphs",
        "labels[4]",
    ]
    assert "'A'" in parts[5]
    assert "#rrggbb" in parts[6]
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("labels: []", "hospital"),
        ("labels: A", "labels"),
        ("labels: [E]", r"labels\[0\]"),
        ("floors: 3", "labels.*floors"),
        ("labels: [{name: A, function: CONNECTION, size: S}]", r"labels\[0\].*CONNECTION"),
        ("labels: [{name: A, function: SERVICE, size: S, general: S}]", "general"),
        ("labels: [{name: A, function: SERVICE, name: B, function: C}]", "'name', 'function'"),
        ("building_type: mall", "building_type"),
        ("labels: [{name: A, function: null}]", r"labels\[0\].function.*NULL"),
        ("labels: [{name: A, function: {}}]", r"labels\[0\].function"),
        ("labels: [{name: A, function: SERVICE, size: []}]", r"labels\[0\].size"),
    ],
)
def test_invalid_schemas_are_refused_in_one_line(path, text, message):
    with pytest.raises(LabelError, match=message) as error:
        read_text(path, text)
    assert f"'{path}': " in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("format: pianta labels\nversion: 2.0\nrooms: 1", r"2\.0"),
        ("format: pianta floor\nversion: '1.0'", "format"),
        ("building_type: house", "format.*version"),
        ("format: pianta labels\nversion: one", "version"),
        ("- a", "keys"),
        ("# nothing", "keys"),
        ("a: b\n---\nc: d", "YAML"),
        ("a: {b", "YAML"),
        ("? {a: b}\n: c", "YAML"),
        ("!!python/object/apply:os.getcwd []", "keys"),
        ("a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]", "aliases"),
        ("[" * 100_000, "YAML"),
        ("- " * 100_000, "YAML"),
        ("\0", "YAML"),
        ("x" * (MAX_FILE_BYTES + 1), "262145"),
    ],
)
def test_hostile_files_are_refused_in_one_line(path, text, message):
    path.write_text(text)
    with pytest.raises(LabelError, match=message) as error:
        read_label_schema(path)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 1000


@pytest.mark.slow
def test_thousands_of_faults_are_shortened(path):
    with pytest.raises(LabelError, match="9990") as error:
        read_text(path, "labels:\n" + "- {}\n" * 5000)
    assert len(str(error.value)) < 1000


def test_keys_of_later_versions_are_skipped(path):
    text = "labels: [{name: A, function: SERVICE, floors: [1]}]\ncountry: IT"
    path.write_text(HEADER.replace("1.0", "1.3") + text)
    assert read_label_schema(path).labels == (Label("A", FCES.SERVICE, GeneralLabel.MEDIUM, "#8c8c8b"),)


def test_missing_files_and_folders_are_reported(tmp_path):
    for name, message in (("none.yaml", "exist"), (".", r"\bfolder\b")):
        with pytest.raises(LabelError, match=f"label schema .*{message}"):
            read_label_schema(tmp_path / name)


@pytest.mark.slow
def test_file_stays_as_it_was_when_saving_fails(tmp_path):
    path = tmp_path / "labels.yaml"
    path.write_text("old")
    label = Label("A" * 100, FCES.SERVICE, GeneralLabel.SMALL, "#ffffff")
    giant = tuple(
        Label(f"{label.name[:90]}{number}", FCES.SERVICE, GeneralLabel.SMALL, "#ffffff") for number in range(2000)
    )
    with pytest.raises(LabelError, match="262144"):
        save_label_schema(LabelSchema("mall", giant), path)
    assert path.read_text() == "old"
    with pytest.raises(PiantaError, match="write"):
        save_label_schema(SCHOOL, tmp_path / "missing" / "labels.yaml")
    assert [file.name for file in tmp_path.iterdir()] == ["labels.yaml"]


@pytest.fixture(scope="module")
def valid(path):
    save_label_schema(OFFICE, path)
    return path.read_bytes()[:700] + b"}\n"


@pytest.mark.slow
@given(fuzz=st.data())
def test_damaged_file_is_read_or_refused(path, valid, fuzz):
    path.write_bytes(fuzz.draw(st.binary() | mutated(valid)))
    with refused_in_one_line():
        assert isinstance(read_label_schema(path), LabelSchema)


def test_example_of_the_page_is_read(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("house.yaml").write_text(block_of_page("yaml"), encoding="utf-8")
    house = read_label_schema("house.yaml")
    assert house.building_type == "house"
    assert house.by_name["LIVING ROOM"] == Label("LIVING ROOM", FCES.FUNCTIONAL, GeneralLabel.BIG, "#8c3b2e")
    assert house.by_name["BEDROOM"] == Label("BEDROOM", FCES.FUNCTIONAL, GeneralLabel.MEDIUM, "#1bddf2")
    assert house.by_name["CORRIDOR"] == Label("CORRIDOR", FCES.CONNECTION, GeneralLabel.CORRIDOR, "#f28705")
    assert {label.function for label in house.labels} == set(FCES)
    assert {label.general for label in house.labels} == set(GeneralLabel)
    names: dict[str, object] = {}
    exec(block_of_page("python"), names)  # noqa: S102
    assert names["rooms"] == [RC.ROOM, RC.CORRIDOR]
    assert names["sizes"] == [GeneralLabel.MEDIUM, GeneralLabel.HALL]
    save_label_schema(house, "again.yaml")
    assert read_label_schema("again.yaml") == house
    assert house.map_labels(["porch"], LabelSet.R_C) == [RC.ROOM]
