"""Tests: one folder for each package of mjsim, what concerns the whole beside them; and what tests share."""

import os
import sys

# A process of tests, and what it starts, has one thread: several processes share two cores, and libraries of linear
# algebra and of pictures wait busily for threads that have no core; that took a third of the processor time.
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM", "LP_NUM_THREADS"), "1"
)
os.environ |= ONE_THREAD
# Else each process, and each program that a test starts, would compile all of mjsim and of these tests anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
