"""What a test needs and a user may lack: without it the test skips with a reason, and in CI it fails."""

import importlib
import os
import shutil
from types import ModuleType
from typing import NoReturn

import pytest


def missing(what: str, remedy: str) -> NoReturn:
    """Skip the running test with a printed reason, or fail it where the environment says CI=true."""
    reason = f"needs {what}: {remedy}"
    if os.environ.get("CI", "").lower() in ("1", "true"):
        pytest.fail(f"{reason} (CI must have it)", pytrace=False)
    pytest.skip(reason)


def need_module(name: str, remedy: str = "") -> ModuleType:
    """The imported module `name`, from an optional extra."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        missing(f"the Python module {name}", remedy or f"pip install {name}")


def need_program(*names: str, remedy: str = "") -> str:
    """The path of the first of the programs `names` that is installed."""
    for name in names:
        if path := shutil.which(name):
            return path
    missing(f"the program {' or '.join(names)}", remedy or f"install {names[0]}")


def need_chromium() -> str:
    """The path of a Chromium that opens reports headless."""
    return need_program("chromium", "chromium-browser", "google-chrome", remedy="apt-get install chromium")
