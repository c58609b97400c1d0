"""A process that casts rays for another; `mjsim.light.crew` starts it."""

import os

from mjsim.light.work import serve

if __name__ == "__main__":
    answers = os.fdopen(os.dup(1), "wb")
    # Output printed by libraries must not mix with the answers.
    os.dup2(2, 1)
    serve(os.fdopen(os.dup(0), "rb"), answers)
