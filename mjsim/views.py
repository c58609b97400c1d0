"""How values look in notebooks and plots: `mjsim.notebook`, above all other parts, draws them.

Lower packages do not import it; `mjsim/__init__.py` tells them where it is.
"""

from typing import Any, ClassVar


class Viewed:
    """A value that notebooks show as a small picture and a few numbers."""

    __slots__ = ()
    _views: ClassVar["staticmethod[[], Any]"]
    """Returns the part that draws; set by `mjsim/__init__.py`, and called when something is drawn."""

    def _repr_html_(self) -> str:
        """Return what a notebook shows, as HTML."""
        return str(self._views().html_of(self))
