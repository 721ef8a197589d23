"""The weights that come with pianta, each with a model card beside it; only files and where they lie."""

from pathlib import Path

MODELS = Path(__file__).parent
