"""A training run as a command: `python -m acf_jax train`, and `python -m train.fit` in the repository."""

import sys
from collections.abc import Callable
from contextlib import nullcontext, redirect_stdout
from typing import TYPE_CHECKING

from acf_jax.cli._ending import resumable
from acf_jax.cli._json import echo_json

if TYPE_CHECKING:
    from acf_jax.provenance import Origin
    from acf_jax.training.config import AnyConfig


def train(make_config: "Callable[[], AnyConfig]", origin: "Origin", resume: bool, as_json: bool) -> int:
    """Run the training and print what it did; the exit code, 1 for a loss that diverges.

    **Arguments:** `make_config`: called once JAX is in float64, which labels need whatever the network's precision.
    """
    from acf_jax.training.devices import is_first
    from acf_jax.training.loop import Diverged
    from acf_jax.training.run import run

    words = redirect_stdout(sys.stderr) if as_json else nullcontext()
    try:
        with resumable("--resume goes on from the last checkpoint"), words:
            metrics = run(make_config(), resume, origin=origin)
    except Diverged as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    if as_json and is_first():
        echo_json(metrics)
    return 0
