from .script import ScriptRun as ScriptRun
from .script import run_script as run_script
