"""Tests: one folder for each package of mjsim, what concerns the whole beside them; and what tests share."""
