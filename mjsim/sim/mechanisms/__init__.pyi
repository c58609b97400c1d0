from .led import Mechanisms as Mechanisms
from .pushes import Push as Push
