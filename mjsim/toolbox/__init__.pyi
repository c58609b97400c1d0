from .module_figures import figures_told as figures_told
from .module_figures import module_figures as module_figures
from .script import ScriptRun as ScriptRun
from .script import run_script as run_script
