from .needed_files import INSTALLED as INSTALLED
from .python_host import PythonHost as PythonHost
