"""A recording -> statistics, plots and a page; it needs nothing but the file."""

from mjsim.report.page import key_figures, write_report
from mjsim.report.statistics import statistics

__all__ = ["key_figures", "statistics", "write_report"]
