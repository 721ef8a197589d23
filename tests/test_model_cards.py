"""Every model that comes with pianta has a card that says what it is for, and where it comes from."""

import re
from pathlib import Path

import pytest

from pianta.models import MODELS

ROOT = Path(__file__).parents[1]
INDEX = (MODELS / "README.md").read_text(encoding="utf-8")
FILES = sorted(file for file in MODELS.iterdir() if file.is_file() and file.suffix not in {".py", ".md"})
CARDS = sorted(MODELS.glob("*.md"))
HEADINGS = (
    *("For", "Takes and gives", "Architecture", "Data"),
    *("Licence", "Date", "Script", "Figures", "Limits"),
)


def card_of(file: Path) -> Path:
    return file.with_name(re.sub(r"_[01]$", "", file.stem) + ".md")


def sections(card: Path) -> dict[str, str]:
    """The text below each heading of a card."""
    parts = re.split(r"^## (.+)$", card.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def test_there_are_models():
    assert len(FILES) >= 9


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_a_model_has_a_card_and_is_in_the_index(file):
    assert card_of(file).is_file()
    # The stem, for whatever format the model has.
    assert f"`{file.stem}." in INDEX
    assert f"]({card_of(file).name})" in INDEX


def test_no_card_is_of_nothing():
    assert {card_of(file) for file in FILES} == {card for card in CARDS if card.name != "README.md"}


@pytest.mark.parametrize("card", [card for card in CARDS if card.name != "README.md"], ids=lambda card: card.stem)
def test_a_card_has_every_section(card):
    card_sections = sections(card)
    assert tuple(card_sections) == HEADINGS
    assert all(text.strip() for text in card_sections.values())
    assert re.fullmatch(r"\d{4}-\d{2}-\d{2}", card_sections["Date"].strip())
    assert "Apache-2.0" in card_sections["Licence"]


@pytest.mark.parametrize("card", [card for card in CARDS if card.name != "README.md"], ids=lambda card: card.stem)
def test_the_script_of_a_card_exists(card):
    scripts = re.findall(r"(?:training|src)/[\w/]+\.py", sections(card)["Script"])
    assert scripts
    assert [script for script in scripts if not (ROOT / script).is_file()] == []
