"""Pictures as files: PNG for screens, PDF and SVG in sizes and fonts that are fit for print."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

from haul_ros.files import create_file

FORMATS = ("png", "pdf", "svg")
_DPI = {"png": 160, "pdf": 300, "svg": 300}
"""Of colours over time in PDF and SVG, where all else is lines and text."""
_PRINT_WIDTH = 174.0 / 25.4
"""Width [inch] of two columns of a journal, 174 mm, which fit where 180 and 190 mm are allowed too."""
_PRINT_STYLE: dict[Any, Any] = {
    "font.size": 8.0,
    "axes.titlesize": 8.0,
    "figure.titlesize": 8.0,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.0,
    "pdf.fonttype": 42,  # TrueType, which journals ask for
    "svg.fonttype": "none",  # text that can be searched and changed
}


@dataclass(frozen=True, slots=True)
class PictureFormat:
    """``suffix`` is one of `FORMATS`; ``dpi`` dots an inch, 0: those that suit it."""

    suffix: str = "png"
    dpi: int = 0

    @property
    def for_print(self) -> bool:
        """Whether it is drawn in the size of a page, with its fonts."""
        return self.suffix != "png"

    @contextmanager
    def style(self) -> Iterator[None]:
        """Figures that are made meanwhile have its fonts."""
        with rc_context(_PRINT_STYLE if self.for_print else {}):
            yield

    def save(self, figure: Figure, path: Path) -> None:
        """Write a figure, within `style`; needs no display."""
        if self.for_print:
            width, height = figure.get_size_inches()
            figure.set_size_inches(_PRINT_WIDTH, height * _PRINT_WIDTH / width)
        with create_file(path) as file:
            figure.savefig(file, format=self.suffix, dpi=self.dpi or _DPI[self.suffix])
