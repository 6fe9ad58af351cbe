"""Progress for a program that watches a command: JSON lines on standard error where the environment asks for them."""

import json
import os
import sys
import time
from collections.abc import Mapping
from typing import Any

ASKED = "ACF_JAX_PROGRESS"  # json: a line {"stage": NAME, "done": N, "total": N, "at": SECONDS} at each step
KNOWN = "known"  # and a line {"known": {...}} where a command knows something before it is done


def wants_lines() -> bool:
    """Whether the environment asks for lines in place of a bar."""
    return os.environ.get(ASKED) == "json"


def tell(stage: str, done: int = 0, total: int = 0) -> None:
    """One line: the stage, how many are done, of how many; a total of 0 is not known. `at` is since the epoch."""
    line = {"stage": stage, "done": done, "total": total, "at": time.time()}
    print(json.dumps(line), file=sys.stderr, flush=True)


def tell_known(found: Mapping[str, Any]) -> None:
    """One line of what is known already."""
    print(json.dumps({KNOWN: found}), file=sys.stderr, flush=True)
