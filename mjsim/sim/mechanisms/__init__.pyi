from .pushes import Push as Push
from .world_mechanisms import Mechanisms as Mechanisms
