"""What `show` gives: a picture as SVG, and a page of its own as HTML."""

from __future__ import annotations

import html
import json
import os
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from ...errors import ParameterError
from ...files import write_atomically

STATIC = Path(__file__).parent.parent / "static"
"""The files of the studio's page."""


@dataclass(frozen=True)
class View:
    """Something shown.

    Attributes
    ----------
    svg : str
        The picture, as it stands still.
    page : str
        The same as a whole HTML document, with what can be moved.
    height : int
        Pixels, in a notebook.
    """

    svg: str = field(repr=False)
    page: str = field(repr=False)
    height: int = 480

    def _repr_html_(self) -> str:
        """For notebooks: the page in a frame that can reach nothing else."""
        style = f"width:100%;height:{self.height}px;border:1px solid #8884;border-radius:6px"
        return f'<iframe sandbox="allow-scripts" style="{style}" srcdoc="{html.escape(self.page, quote=True)}"></iframe>'

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        """HTML where it is shown, SVG elsewhere."""
        return {"text/html": self._repr_html_(), "image/svg+xml": self.svg, "text/plain": repr(self)}

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the picture (``.svg``) or the page (``.html``), all of it or nothing.

        Raises
        ------
        ParameterError
            For another ending.
        """
        target = Path(path)
        contents = {".svg": self.svg, ".html": self.page}
        if target.suffix not in contents:
            raise ParameterError(f"a view is saved as .svg or .html, got {target.name!r}")
        write_atomically(target, contents[target.suffix])


@cache
def _script(names: tuple[str, ...]) -> str:
    """The studio's modules as one, without their comments: what they import of each other is there already."""
    lines = []
    for name in names:
        for line in (STATIC / "js" / name).read_text("utf-8").splitlines():
            if not line.startswith("import ") and not line.lstrip().startswith(("//", "/** ")):
                lines.append(line.strip().removeprefix("export "))
    return "\n".join(lines)


def page_of(title: str, data: Any, begin: str, scripts: tuple[str, ...]) -> str:
    """A whole HTML document.

    Parameters
    ----------
    title : str
    data : object
        What JSON can say; the script finds it as ``data``.
    begin : str
        The call that starts it.
    scripts : tuple of str
        Modules of the studio's page, those that others import first.
    """
    said = json.dumps(data, allow_nan=False, ensure_ascii=False).replace("</", "<\\/").replace("<!--", "<\\!--")
    css = "\n".join((STATIC / "css" / name).read_text("utf-8") for name in ("net.css", "notebook.css"))
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title><style>{css}</style></head>'
        f'<body><script type="module">\n{_script(scripts)}\nconst data = {said};\n{begin}\n</script></body></html>\n'
    )
