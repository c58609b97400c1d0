"""A recording -> statistics, plots and a page; it needs nothing but the file."""

from mjsim.report.page import write_report
from mjsim.report.statistics import statistics
from mjsim.report.tables import key_table

__all__ = ["key_table", "statistics", "write_report"]
