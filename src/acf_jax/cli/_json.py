"""Results as JSON on standard output, and nothing else there."""

import json
import math
from typing import Any

import click


def echo_json(content: Any) -> None:
    """Print `content`; JSON has no infinity, so null stands for a number that does not exist."""
    click.echo(json.dumps(_finite(content), indent=2, allow_nan=False))


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
