"""Paper with headings, tables and figures, as PDF of A4 pages."""

from collections.abc import Callable, Sequence
from typing import BinaryIO, Self

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from gyrostat.reports.drawing import STYLE, literal

WIDTH, HEIGHT = 8.27, 11.69
"""Size of a page, inches."""
LEFT, RIGHT, TOP, BOTTOM = 0.7, 0.6, 0.75, 0.75
"""Margins, inches."""
SIZE, SMALL = 8.5, 7.0
"""Size of text and of tables, points."""
POINT = 1.0 / 72.0
SPACING = 1.35
LETTER = 0.58
"""Mean width of a letter over its size."""
GAP = 0.1
"""Distance of columns, inches."""
SIGNATURE_HEIGHT = 1.0
FIGURE_HEIGHT = 2.2


class Paper:
    """Pages that are filled from the top; use it as a context."""

    def __init__(self, target: BinaryIO, title: str) -> None:
        """Open the first page.

        Args:
            target: File that receives the PDF.
            title: Line at the foot of each page, and title of the file.
        """
        self.title = title
        # no date: equal reports are equal files
        self.pages = PdfPages(target, metadata={"Title": title, "CreationDate": None})
        self.number = 0
        self._open()

    def __enter__(self) -> Self:
        """Use the paper as a context."""
        return self

    def __exit__(self, *error: object) -> None:
        """Write the last page."""
        self._close()
        self.pages.close()

    def _open(self) -> None:
        self.number += 1
        self.page = Figure(figsize=(WIDTH, HEIGHT))
        self.y = HEIGHT - TOP

    def _close(self) -> None:
        foot = f"{literal(self.title)}, page {self.number}"
        self._put(LEFT, 0.45, foot, SMALL, colour="#6b7077")
        with mpl.rc_context(STYLE):
            self.pages.savefig(self.page)

    def _put(
        self, x: float, y: float, text: str, size: float, *, bold: bool = False, colour: str = "k"
    ) -> None:
        self.page.text(
            x / WIDTH,
            y / HEIGHT,
            text,
            size=size,
            weight="bold" if bold else "normal",
            color=colour,
            va="top",
            family="DejaVu Sans",
        )

    def _need(self, height: float) -> None:
        """Open another page if so much height, inches, is not left."""
        if self.y - height < BOTTOM:
            self._close()
            self._open()

    def _rule(self, y: float) -> None:
        line = Line2D(
            [LEFT / WIDTH, 1.0 - RIGHT / WIDTH], [y / HEIGHT] * 2, lw=0.5, color="#b0b4ba"
        )
        self.page.add_artist(line)

    def heading(self, text: str, size: float = 11.5) -> None:
        """Write a heading, with room for some lines below it."""
        self._need(2.5 * size * POINT + 0.8)
        self.y -= 0.6 * size * POINT
        self._put(LEFT, self.y, literal(text), size, bold=True)
        self.y -= 1.6 * size * POINT

    def text(self, text: str) -> None:
        """Write a paragraph."""
        lines = wrapped(text, WIDTH - LEFT - RIGHT, SIZE)
        self._need(len(lines) * SPACING * SIZE * POINT)
        for line in lines:
            self._put(LEFT, self.y, literal(line), SIZE)
            self.y -= SPACING * SIZE * POINT
        self.y -= 0.04

    def table(self, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """Write a table; cells that are too long are wrapped, rows are not divided."""
        widths = column_widths([header, *rows], WIDTH - LEFT - RIGHT)
        self._row(header, widths, bold=True)
        for row in rows:
            if self._row(row, widths):
                self._row(header, widths, bold=True)
                self._row(row, widths)
        self.y -= 0.08

    def _row(self, row: Sequence[str], widths: Sequence[float], *, bold: bool = False) -> bool:
        """Write a row; True, without writing, if it needs a further page, which is then open."""
        cells = [wrapped(c, w - GAP, SMALL) for c, w in zip(row, widths, strict=True)]
        height = max(map(len, cells)) * SPACING * SMALL * POINT + 0.05
        page = self.number
        self._need(height)
        if self.number != page and not bold:
            return True
        x = LEFT
        for lines, width in zip(cells, widths, strict=True):
            for k, line in enumerate(lines):
                y = self.y - k * SPACING * SMALL * POINT
                self._put(x, y, literal(line), SMALL, bold=bold)
            x += width
        self.y -= height
        self._rule(self.y + 0.02)
        return False

    def figure(self, draw: Callable[[Axes], None]) -> None:
        """Draw a figure over the width of the page."""
        self._need(FIGURE_HEIGHT + 0.75)
        box = (
            (LEFT + 0.6) / WIDTH,
            (self.y - FIGURE_HEIGHT - 0.25) / HEIGHT,
            (WIDTH - LEFT - RIGHT - 0.7) / WIDTH,
            FIGURE_HEIGHT / HEIGHT,
        )
        with mpl.rc_context(STYLE):
            draw(self.page.add_axes(box))
        self.y -= FIGURE_HEIGHT + 0.75

    def signatures(self, roles: Sequence[str]) -> None:
        """Write fields for name, date and signature of each role."""
        self._need(SIGNATURE_HEIGHT)
        self.y -= 0.55
        width = (WIDTH - LEFT - RIGHT) / len(roles)
        for k, role in enumerate(roles):
            x = LEFT + k * width
            line = Line2D(
                [x / WIDTH, (x + width - 0.25) / WIDTH], [self.y / HEIGHT] * 2, lw=0.7, color="k"
            )
            self.page.add_artist(line)
            self._put(x, self.y - 0.05, f"{role}: name, date, signature", SMALL)
        self.y -= 0.4


def wrapped(text: str, width: float, size: float) -> list[str]:
    """Divide a text into lines of a width, inches, at blanks, or within words that are too long.

    Args:
        text: Text.
        width: Width of a line, inches.
        size: Size of a letter, points.
    """
    most = max(int(width / (LETTER * size * POINT)), 4)
    lines, line = [], ""
    for word in text.split(" "):
        while len(word) > most:
            if line:
                lines.append(line)
                line = ""
            lines.append(word[:most])
            word = word[most:]
        if line and len(line) + 1 + len(word) > most:
            lines.append(line)
            line = word
        else:
            line = f"{line} {word}" if line else word
    return [*lines, line]


def column_widths(rows: Sequence[Sequence[str]], total: float) -> list[float]:
    """Widths of columns, inches, that fill a width: short columns get what they need.

    Args:
        rows: Rows of the table, header included.
        total: Width of the table, inches.
    """
    unit = LETTER * SMALL * POINT
    need = [max(len(row[k]) for row in rows) * unit + GAP for k in range(len(rows[0]))]
    widths, left, open_columns = [0.0] * len(need), total, set(range(len(need)))
    while open_columns:
        share = left / len(open_columns)
        short = {k for k in open_columns if need[k] <= share}
        if not short:
            for k in open_columns:
                widths[k] = share
            break
        for k in short:
            widths[k] = need[k]
            left -= need[k]
        open_columns -= short
    return widths
