"""Import every module of the installed mjsim; only packages of extras may be missing.

python scripts/make/import_all.py
"""

import importlib
import pkgutil

import mjsim

EXTRAS = {"gymnasium", "httpx", "playwright", "rosbags"}
"""Packages that some modules need as they are imported, and that are not installed with mjsim."""


def main() -> None:
    """Import all modules one by one, and print their number."""
    count = 0
    for module in pkgutil.walk_packages(mjsim.__path__, "mjsim."):
        if module.name.endswith("__main__"):
            continue
        try:
            importlib.import_module(module.name)
        except ModuleNotFoundError as error:
            if error.name not in EXTRAS:
                raise
        count += 1
    print(f"{mjsim.__path__[0]}: {count} modules can be imported")


if __name__ == "__main__":
    main()
