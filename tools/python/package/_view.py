"""Pages that show themselves in a notebook."""

from __future__ import annotations

import html as _html
import os
from typing import Union

from clothid import _clothid


class View:
    """A page for any browser, one file that asks no server for anything. In a notebook it shows itself."""

    def __init__(self, html: str) -> None:
        self.html = html

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the page, whole or not at all. Raises FileError."""
        _clothid.write_page(path, self.html)

    def __repr__(self) -> str:
        return f"<clothid.View: a page of {len(self.html) / 1000:.0f} kB; save(path) writes it>"

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{_html.escape(self.html)}" style="width: 100%; height: 700px; border: 0"></iframe>'
