"""The server: sockets, authentication, bounds of requests, and the static page."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
