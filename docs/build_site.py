"""Build the site of the documentation: `make site`, or `python docs/build_site.py FOLDER`.

The pages are those of docs/, and the pages elsewhere in the repository that belong to them. They are copied to
FOLDER/source, where links between them are adapted, and Sphinx makes FOLDER/html of them. Warnings are errors. Nothing
comes from the internet, neither now nor in the pages, which is checked.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import build_main

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
MODELS = ROOT / "src" / "pianta" / "models"
# Pages elsewhere in the repository, and where they are in the site.
ELSEWHERE = {
    ROOT / "CHANGELOG.md": DOCS / "reference" / "changelog.md",
    ROOT / "benchmarks" / "README.md": DOCS / "results" / "benchmarks.md",
    ROOT / "training" / "README.md": DOCS / "results" / "training.md",
    ROOT / "README.md": DOCS / "index.md",
    **{card: DOCS / "reference" / "models" / card.name for card in MODELS.glob("*.md") if card.name != "README.md"},
    MODELS / "README.md": DOCS / "reference" / "models" / "index.md",
}
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
# What makes a browser ask another server while it shows a page, unlike links that a reader follows.
REMOTE = re.compile(
    r"<(?:script|img|iframe|source|video)\b[^>]*\bsrc=[\"']?(?:https?:)?//[^\s>]+"
    r"|<link\b(?=[^>]*\brel=[\"']?(?:stylesheet|preload|icon|preconnect|prefetch))[^>]*\bhref=[\"']?(?:https?:)?//[^\s>]+"
    r"|url\([\"']?(?:https?:)?//[^)]+\)|@import\s+[\"'](?:https?:)?//[^\"']+",
    re.IGNORECASE,
)


def main() -> int:
    """Build the site; the exit code is that of Sphinx, or 1 for pages that would load something from elsewhere."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "site").resolve()
    source, html = folder / "source", folder / "html"
    shutil.rmtree(folder, ignore_errors=True)
    copy_pages(source)
    options = ["-b", "html", "-c", str(source / "site"), "-W", "--keep-going", "-q", "-d", str(folder / "doctrees")]
    code = build_main([*options, str(source), str(html)])
    remote = find_remote(html) if code == 0 else []
    for line in remote:
        sys.stderr.write(f"{line}\n")
    return code or bool(remote)


def copy_pages(source: Path) -> None:
    """Copy all pages into the folder that Sphinx reads, with their links adapted."""
    shutil.copytree(DOCS, source, ignore=shutil.ignore_patterns("*.py[cod]", "__pycache__", "draw_*.py"))
    for page, position in ELSEWHERE.items():
        if page != ROOT / "README.md":
            target = source / position.relative_to(DOCS)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(page, target)
    pages = {position: page for page, position in ELSEWHERE.items() if page != ROOT / "README.md"}
    for path in [*source.rglob("*.md"), *source.rglob("*.ipynb")]:
        position = DOCS / path.relative_to(source)
        text = path.read_text(encoding="utf-8")
        adapted = adapt_links(text, pages.get(position, position), position)
        if path == source / "reference" / "models" / "index.md":
            adapted += list_pages(sorted(card.stem for card in MODELS.glob("*.md") if card.name != "README.md"))
        # A figure stays on one line with its deviation.
        path.write_text(adapted.replace(" ± ", "\u00a0±\u00a0"), encoding="utf-8")


def list_pages(names: list[str]) -> str:
    """A hidden table of contents, in MyST."""
    return "\n".join(["", "```{toctree}", ":hidden:", *names, "```", ""])


def adapt_links(text: str, page: Path, position: Path) -> str:
    """The text of a page with links that lead to the same pages from its position in the site."""

    def adapt(match: re.Match[str]) -> str:
        mark, name, link = match.groups()
        path, hash_sign, anchor = link.partition("#")
        if not path or re.match(r"\w+:", path):
            return match.group()
        target = Path(os.path.normpath(page.parent / path))
        target = ELSEWHERE.get(target, target)
        if not target.is_relative_to(DOCS):
            return name
        return f"{mark}[{name}]({os.path.relpath(target, position.parent)}{hash_sign}{anchor})"

    return LINK.sub(adapt, text)


def find_remote(html: Path) -> list[str]:
    """What pages and styles would load from another server."""
    requests = []
    for path in sorted(html.rglob("*")):
        if path.suffix in {".html", ".css"}:
            text = path.read_text(encoding="utf-8", errors="replace")
            requests += [f"{path.relative_to(html)}: {match.group()[:200]}" for match in REMOTE.finditer(text)]
    return requests


if __name__ == "__main__":
    sys.exit(main())
