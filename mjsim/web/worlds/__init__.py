"""The worlds of a studio's folder: their files, texts, drafts, items, modules and pictures as the page needs them."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
