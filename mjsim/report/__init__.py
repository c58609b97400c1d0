"""Recordings -> statistics, plots and pages, of one run or of many compared; nothing but files is needed."""

from mjsim.report.comparison import Comparison, RunFigures, Series, compare_tables
from mjsim.report.comparison_page import write_comparison
from mjsim.report.comparison_tables import comparison_lines
from mjsim.report.page import write_report
from mjsim.report.runs import compare
from mjsim.report.statistics import statistics
from mjsim.report.tables import key_table

__all__ = [
    "Comparison",
    "RunFigures",
    "Series",
    "compare",
    "compare_tables",
    "comparison_lines",
    "key_table",
    "statistics",
    "write_comparison",
    "write_report",
]
