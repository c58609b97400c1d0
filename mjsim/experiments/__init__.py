"""The classic experiments: five runs that show what a simulator of mobile robots is for, each with its verdict."""

from mjsim.experiments.classic import EXPERIMENTS, run_experiments
from mjsim.experiments.finding import Finding, Picture, Result

__all__ = ["EXPERIMENTS", "Finding", "Picture", "Result", "run_experiments"]
