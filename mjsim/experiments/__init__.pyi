from .classic import EXPERIMENTS as EXPERIMENTS
from .classic import run_experiments as run_experiments
from .experiment_page import lines as lines
from .finding import Finding as Finding
from .finding import Plot as Plot
from .finding import Result as Result
