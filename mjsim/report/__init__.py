"""A recording -> statistics, plots and a page; it needs nothing but the file."""

from mjsim.report.page import key_table, write_report
from mjsim.report.statistics import statistics

__all__ = ["key_table", "statistics", "write_report"]
