from .classic import EXPERIMENTS as EXPERIMENTS
from .classic import run_experiments as run_experiments
from .finding import Finding as Finding
from .finding import Plot as Plot
from .finding import Result as Result
from .page import lines as lines
