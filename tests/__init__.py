"""Tests: one folder for each package of mjsim, what concerns the whole beside them; and what tests share."""

import os

# A process of tests, and what it starts, has one thread: several processes share two cores, and libraries of linear
# algebra and of pictures wait busily for threads that have no core; that took a third of the processor time.
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM", "LP_NUM_THREADS"), "1"
)
os.environ |= ONE_THREAD
