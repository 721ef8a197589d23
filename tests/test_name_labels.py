"""Priors of labels from room names in several languages, and dictionaries of users."""

import json
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import LabelError
from pianta.labels import FCES, OFFICE, SCHEMAS, SCHOOL, GeneralLabel, Label, LabelSchema
from pianta.rooms.name_dictionary import (
    match_phrase,
    normalize_name,
    read_default_room_name_dictionary,
    read_room_name_dictionary,
    room_name_prior,
)
from pianta.worlds.plans.name_sheets import NAMES
from tests.mutation import mutated

WORDS = read_default_room_name_dictionary()
HOUSE = LabelSchema(
    "house",
    (
        Label("BEDROOM", FCES.FUNCTIONAL, GeneralLabel.MEDIUM, "#000000"),
        Label("LIVING ROOM", FCES.FUNCTIONAL, GeneralLabel.BIG, "#000000"),
        Label("BATHROOM", FCES.SERVICE, GeneralLabel.SMALL, "#000000"),
        Label("HALL", FCES.CONNECTION, GeneralLabel.HALL, "#000000"),
    ),
)
OWN = {
    "format": "pianta room words",
    "version": "1.0",
    "kinds": [{"function": "functional", "labels": {"House": ["bedroom"]}, "words": {"nl": ["slaapkamer", "gym"]}}],
}


def likely(name: str, schema: LabelSchema | None) -> set[str]:
    prior = room_name_prior(name, schema, WORDS)
    assert prior is not None
    assert sum(prior.values()) == pytest.approx(1)
    most = max(prior.values())
    return {label for label, probability in prior.items() if probability > 0.9 * most}


@pytest.mark.parametrize(
    ("name", "word"),
    [
        ("CLASSROOM 12", "classroom"),
        ("Class-Room", "class room"),
        ("7TH GRADE CLASSROOM", "grade classroom"),
        ("204 French", "french"),
        ("Boys' Toilet", "boys toilet"),
        ("PRINCIPAL'S OFFICE", "principals office"),
        ("Assistant Principal", "assistant principal"),
        ("Classrooms", "classroom"),
        ("AULA4", "aula"),
        ("CONFERENCEROOM", "conference room"),
        ("W.C.", "w c"),
        ("Büro 3", "buro"),
        ("CLA55 ROOM", "class room"),
        ("Cafetera", "cafeteria"),
        ("KITCHEM", "kitchen"),
        ("Ouidance", "guidance"),
        ("Schullehrerzimmer", "lehrerzimmer"),
        ("Direktionszimmer", "direktion"),
        ("OCCUPATIONAL XYZ", None),
        ("Luperto", None),
        ("ROOM", None),
        ("12", None),
        ("", None),
        ("Title One Room", None),
    ],
)
def test_words_are_found(name, word):
    result = match_phrase(name, WORDS)
    assert (result.phrase if result else None) == word


@pytest.mark.parametrize(
    ("schema", "names", "labels"),
    [
        (SCHOOL, ["Classroom", "AULA 3", "KLASSE 4B", "Salle de classe", "Clase", "sala de aula"], {"CLASSROOM"}),
        (SCHOOL, ["Gym", "PALESTRA", "Turnhalle", "Gymnase", "GIMNASIO", "Ginásio"], {"GYM"}),
        (SCHOOL, ["Library", "Biblioteca", "Bücherei", "Bibliothèque"], {"LIBRARY"}),
        (SCHOOL, ["Corridor", "Corridoio", "Gang", "Couloir", "PASILLO", "Corredor"], {"CORRIDOR"}),
        (SCHOOL, ["Stairs", "Scala", "TREPPENHAUS", "Escalier", "Escalera", "Escada"], {"STAIRS"}),
        (SCHOOL, ["Toilet", "Bagno", "WC", "Sanitaires", "Aseos", "Banheiro"], {"BATHROOM", "WASHROOM"}),
        (SCHOOL, ["Kitchen", "Cucina", "Küche", "Cuisine", "Cocina", "Cozinha"], {"KITCHEN"}),
        (SCHOOL, ["Lift", "Ascensore", "Aufzug", "Ascenseur", "Ascensor", "Elevador"], {"ELEVATOR"}),
        (SCHOOL, ["Lab", "Laboratorio", "Physik", "Laboratoire", "Taller", "Informática"], {"LAB"}),
        (SCHOOL, ["Office", "Ufficio", "Büro", "Bureau", "Despacho"],
         {"SMALL ADMINISTRATIVE", "MEDIUM ADMINISTRATIVE", "BIG ADMINISTRATIVE"}),
        (OFFICE, ["Office", "Ufficio", "Büro", "Bureau", "Despacho", "Gabinete"], {"OFFICE"}),
        (OFFICE, ["Meeting Room", "Sala riunioni", "Besprechung", "Salle de réunion", "Sala de juntas"],
         {"CONFERENCE ROOM"}),
        (OFFICE, ["Reception", "Portineria", "Empfang", "Accueil", "Recepción"], {"RECEPTION"}),
        (OFFICE, ["Open space", "Großraumbüro", "Plateau"], {"OPENSPACE"}),
        (None, ["Entrance", "Ingresso", "Eingang", "Entrée", "Entrada"], {"ENTRANCE"}),
        (None, ["Storage", "Deposito", "Lager", "Réserve", "Almacén"], {"SERVICE"}),
    ],
)  # fmt: skip
def test_names_in_all_languages_determine_the_label(schema, names, labels):
    assert [likely(name, schema) for name in names] == [labels] * len(names)


def test_printed_names_of_the_synthetic_set_are_nearly_all_known():
    unknown = [name for names in NAMES.values() for name in names if match_phrase(name, WORDS) is None]
    assert unknown == ["Attività", "SALLE 101"]


def test_a_word_of_two_languages_stays_undecided():
    """Aula is a classroom in Italian, Spanish and Portuguese, and a hall in German."""
    prior = room_name_prior("Aula", SCHOOL, WORDS)
    assert prior is not None
    assert prior["CLASSROOM"] > prior["HALL"] > 0.2


def test_unknown_names_have_no_prior_and_worse_matches_a_weaker_one():
    assert room_name_prior("Luperto", SCHOOL, WORDS) is None
    exact, part, misspelt = (room_name_prior(name, OFFICE, WORDS) for name in ("Kitchen", "Lunchkitchen", "Kitchem"))
    assert exact is not None
    assert part is not None
    assert misspelt is not None
    assert exact["KITCHEN"] > part["KITCHEN"] > misspelt["KITCHEN"] > 0.8


def test_a_type_without_labels_for_a_word_uses_those_of_its_function():
    assert likely("Classroom", HOUSE) == {"BEDROOM", "LIVING ROOM"}
    assert likely("Kitchen", HOUSE) == {"BATHROOM"}
    assert room_name_prior("Stairs", HOUSE, WORDS) is None


def test_every_word_of_the_dictionary_has_a_label_in_each_schema():
    for type_name in WORDS.entries:
        assert set(type_name.labels) == set(SCHEMAS)
        for building_type, labels in type_name.labels.items():
            assert set(labels) <= set(SCHEMAS[building_type].by_name)
        assert {"en", "it", "de", "fr", "es"} <= set(type_name.words)
    training = {label for type_name in WORDS.entries for label in type_name.labels["school"]}
    assert training == set(SCHOOL.by_name)
    training = {label for type_name in WORDS.entries for label in type_name.labels["office"]}
    assert training == set(OFFICE.by_name)


@pytest.mark.parametrize(
    ("text", "folded"), [("Bücherei  2", "bucherei 2"), ("W.-C.", "w c"), ("Boy’s", "boys"), ("…", "")]
)
def test_folding(text, folded):
    assert normalize_name(text) == folded


@given(st.text(max_size=30))
def test_any_name_has_a_valid_prior_or_none(name):
    prior = room_name_prior(name, SCHOOL, WORDS)
    assert prior is None or (set(prior) == set(SCHOOL.by_name) and sum(prior.values()) == pytest.approx(1))
    assert normalize_name(normalize_name(name)) == normalize_name(name)


def test_words_of_users_take_precedence(tmp_path):
    path = tmp_path / "words.json"
    path.write_text(json.dumps(OWN))
    words = read_room_name_dictionary(path)
    prior = room_name_prior("Slaapkamer", HOUSE, words)
    assert prior is not None
    assert prior["BEDROOM"] > 0.9
    gym = room_name_prior("Gym", None, words)
    assert gym is not None
    assert gym["FUNCTIONAL"] > 0.9
    assert likely("Kitchen", OFFICE) == {"KITCHEN"}
    assert room_name_prior("Kitchen", OFFICE, words) == room_name_prior("Kitchen", OFFICE, WORDS)


def broken(**changes: object) -> str:
    return json.dumps(OWN | changes)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[]", "object"),
        ("{", "JSON"),
        (broken(version="2.0"), "2.0"),
        (broken(format="pianta labels"), "format"),
        (broken(kinds=[]), "kinds"),
        (broken(kinds=[{"function": "NOISE", "words": {"en": ["a"]}}]), "kinds[0].function"),
        (broken(kinds=[{"function": "SERVICE", "words": {"en": ["…"]}}]), "letter"),
        (broken(kinds=[{"function": "SERVICE", "words": {"en": ["x" * 101]}}]), "100"),
        (broken(kinds=[{"function": "SERVICE", "labels": {"a": [""]}, "words": {"en": ["a"]}}]), "name"),
        (broken(colour="red"), "colour"),
        (" " * (256 * 2**10 + 1), "262144"),
    ],
)
def test_a_faulty_dictionary_is_refused_in_one_line(tmp_path, content, message):
    path = tmp_path / "words.json"
    path.write_text(content)
    with pytest.raises(LabelError) as caught:
        read_room_name_dictionary(path)
    assert message in str(caught.value)
    assert path.name in str(caught.value)
    assert "\n" not in str(caught.value)


@given(st.data())
def test_a_damaged_dictionary_gives_one_line_or_is_read(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("words") / "words.json"
    path.write_bytes(data.draw(mutated(json.dumps(OWN).encode())))
    with suppress(LabelError):
        read_room_name_dictionary(path)


def test_without_a_type_a_name_has_the_functions_of_all_types():
    """An office is SERVICE in a school and FUNCTIONAL in an office building."""
    office = room_name_prior("Office", None, WORDS)
    assert office is not None
    assert office["SERVICE"] == pytest.approx(office["FUNCTIONAL"])
    assert office["SERVICE"] > 10 * office["ENTRANCE"]
    classroom = room_name_prior("Classroom", None, WORDS)
    assert classroom is not None
    assert classroom["FUNCTIONAL"] > 10 * classroom["SERVICE"]
