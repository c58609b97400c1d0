"""Programs in Python that start by themselves."""

import sys

HEAD = f"""#!/bin/sh
'''exec' "{sys.executable}" "$0" "$@"
' '''
"""
"""The first lines of a program: a shell starts Python, as its path may hold spaces, which `#!` cannot have."""
