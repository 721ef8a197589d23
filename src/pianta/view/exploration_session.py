"""An exploration on the page: a timeline of maps and of the floors that they read as."""

from __future__ import annotations

from typing import Any, ClassVar

from pianta.exploration.steps import FILE_NAME, SavedExploration, read_exploration
from pianta.gridmap import GridMap
from pianta.io._files import count_noun
from pianta.io.floors import read_floor
from pianta.io.maps import read_npz_map
from pianta.view.result_sessions import ResultSession, describe_shapes
from pianta.view.sessions import UNFIT, RefusedError


class ExplorationSession(ResultSession[SavedExploration]):
    """A folder of `pianta explore`; its parts are the steps."""

    kind: ClassVar[str] = "exploration"
    patterns: ClassVar[tuple[str, ...]] = (FILE_NAME, "step-*.npz", "step-*.geojson")

    def _read(self) -> SavedExploration:
        saved = read_exploration(self.file)
        if not saved.steps:
            raise RefusedError(UNFIT, f"{self.name} has no steps, explore with --steps 12")
        return saved

    def _list_facts(self, content: SavedExploration) -> list[str]:
        last = content.steps[-1]
        share = f"{100 * last.share:.0f} % of {content.reachable_area:.0f} m²"
        return [count_noun(len(content.steps), "step"), share, f"{last.distance:.0f} m", content.outcome]

    def _describe(self, content: SavedExploration, version: str) -> dict[str, Any]:
        steps = [step.model_dump(include={"scan", "distance", "time", "area", "share"}) for step in content.steps]
        about = content.model_dump(include={"world", "policy", "outcome", "reachable_area"})
        return {**self._describe_part(content, self._choose_part(content), version), "steps": steps, "about": about}

    def _choose_part(self, content: SavedExploration) -> int:
        return len(content.steps) - 1

    def _count_parts(self, content: SavedExploration) -> int:
        return len(content.steps)

    def _describe_part(self, content: SavedExploration, part: int, version: str) -> dict[str, Any]:
        step = content.steps[part]
        floor, grid = read_floor(self.folder / f"{step.name}.geojson"), self._open_picture(content, part)
        tracks = [track[:count] for track, count in zip(content.tracks, step.pose_counts, strict=False)]
        return {**describe_shapes(floor, grid, self._address_of(part, version)), "tracks": tracks}

    def _open_picture(self, content: SavedExploration, part: int) -> GridMap | None:
        return read_npz_map(self.folder / f"{content.steps[part].name}.npz")
