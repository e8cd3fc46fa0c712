"""Results that are drawn, and shown with their picture in a notebook."""

from html import escape
from typing import TYPE_CHECKING

from gyrostat.core.field_table import field_table
from gyrostat.core.handed_down import handed_down
from gyrostat.core.views import lines

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Pictured:
    """Result of which the reports have a picture."""

    def plot(self) -> "Figure":
        """Draw the result.

        Returns:
            Figure of Matplotlib to edit, or to save by its `savefig`. A notebook shows it where it
            is the value of a cell; it is no figure of pyplot.
        """
        return handed_down("picture")(self)

    def _repr_html_(self) -> str:
        """Text of the result and its picture, for a notebook."""
        return handed_down("notebook_html")(self)


class Listed:
    """Part of a result whose text has its uncertainty and unit, which a notebook shows."""

    def _repr_html_(self) -> str:
        """Table of the part, as the command line has it."""
        return f"<pre>{escape(chr(10).join(lines(self)))}</pre>"


class Described:
    """Part whose fields a notebook shows with their values, uncertainties, meanings and units."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        """Table of the fields."""
        return field_table(self)


class PicturedText(Pictured):
    """Result whose text is the sentences of the command line, which the reports have."""

    def __str__(self) -> str:
        """Sentences of the command line."""
        return handed_down("text_of")(self)
