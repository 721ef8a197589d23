"""The picture of a floor as SVG, which stays sharp at any size."""

from __future__ import annotations

from pathlib import Path

from pianta.building import Building, Storey
from pianta.io.writers._formats import WriteOptions
from pianta.labels import ALL_SCHEMAS
from pianta.plot.floor import list_samples, plot_floor
from pianta.plot.picture import add_legend, find_extent, new_picture, plot_scale_bar, show_extent
from pianta.plot.room_marks import plot_names

# A floor with more rooms has a larger picture, so that lines are thin beside its rooms; chosen by hand.
USUAL_ROOMS = 40
# matplotlib makes ids of this text instead of chance, so that the same floor gives the same bytes.
SALT = "pianta"


def write_pictures(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """picture.svg, or STOREY.svg for each storey: the rooms on the map with ids and names, doors, and a legend."""
    for storey in building:
        _draw(storey, target / f"{storey.name or 'picture'}.svg")
    return []


def _draw(storey: Storey, path: Path) -> None:
    from matplotlib import rc_context

    if not storey.floor.rooms and storey.grid is None:
        path.write_text('<svg xmlns="http://www.w3.org/2000/svg"/>\n', encoding="utf-8")
        return
    extent = find_extent(storey.floor, storey.grid)
    figure, ax = new_picture(extent)
    figure.set_size_inches(figure.get_size_inches() * max(1.0, (len(storey.floor) / USUAL_ROOMS) ** 0.5))
    plot_floor(storey.floor, storey.grid, ax=ax, schemas=ALL_SCHEMAS)
    plot_names(storey.floor, ax, schemas=ALL_SCHEMAS)
    show_extent(extent, ax)
    plot_scale_bar(ax=ax, area_trust=storey.area_trust)
    samples = list_samples(storey.floor, ALL_SCHEMAS)
    if samples:
        add_legend(figure, samples)
    for image in ax.images:
        # The cells of the map themselves, which take half the time of pixels
        image.set_interpolation("none")
    with rc_context({"svg.hashsalt": SALT}):
        figure.savefig(path, format="svg", metadata={"Date": None})
