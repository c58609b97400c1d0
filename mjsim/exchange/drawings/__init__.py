"""Floor plans from SVG and DXF: lines of a drawing become walls, openings and furniture."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
