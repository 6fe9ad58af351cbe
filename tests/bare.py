"""Commands as they run where `pip install .` brought nothing that was not asked for."""

import sys
from importlib import metadata

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

WITHOUT = """
import runpy, sys
from importlib.abc import MetaPathFinder

absent = set(sys.argv.pop(1).split(","))

class Absent(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in absent:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
runpy.run_module("acf_jax", run_name="__main__", alter_sys=True)
"""


def bare(*arguments: str) -> list[str]:
    """`python -m acf_jax` with these arguments, without the modules that only extras bring."""
    return [sys.executable, "-c", WITHOUT, ",".join(absent_modules()), *arguments]


def absent_modules() -> list[str]:
    """The modules of this environment that `pip install .` alone would not have brought."""
    brought = _pip_brings("acf-jax", set())
    return [
        module
        for module, owners in metadata.packages_distributions().items()
        if not brought & set(map(canonicalize_name, owners))
    ]


def _pip_brings(distribution: str, found: set[str]) -> set[str]:
    """The distribution and all that `pip install` brings with it, no extra asked for."""
    name = canonicalize_name(distribution)
    if name not in found:
        found.add(name)
        for line in metadata.requires(name) or ():
            needed = Requirement(line)
            if not needed.marker or needed.marker.evaluate({"extra": ""}):
                _pip_brings(needed.name, found)
    return found
