from .files import INSTALLED as INSTALLED
from .host import PythonHost as PythonHost
