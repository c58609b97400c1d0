from .pool import usable_cores as usable_cores
from .results import Sweep as Sweep
from .results import key_lines as key_lines
from .sweep import run_plan as run_plan
from .sweep import sweep as sweep
from .sweep_plan import SweepPlan as SweepPlan
from .sweep_plan import parse_seeds as parse_seeds
from .sweep_plan import parse_settings as parse_settings
