from .prescribed import Mechanisms as Mechanisms
from .pushes import Push as Push
