from .needed_files import INSTALLED as INSTALLED
from .offers import faults_in as faults_in
from .python_host import PythonHost as PythonHost
