"""YAML of untrusted origin, without aliases."""

from __future__ import annotations

import yaml


class PlainLoader(yaml.BaseLoader):
    """YAML whose scalars all stay text, without aliases, by which a short file can expand endlessly."""

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        """Refuse aliases."""
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("it has aliases (*name), write the values out")
        return super().compose_node(parent, index)
