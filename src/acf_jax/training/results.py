"""The files that every training leaves beside its surrogate."""

import json
from typing import Any

from acf_jax.files import write_text
from acf_jax.provenance import Origin
from acf_jax.training.config import AnyConfig, to_yaml


def write_config(config: AnyConfig) -> None:
    """The configuration with every default; its first line says who wrote it."""
    write_text(config.output / "config.yaml", f"# written by acf-jax, with every default\n{to_yaml(config)}")


def write_results(
    config: AnyConfig, metrics: dict[str, Any], timings: dict[str, float], origin: Origin | None
) -> None:
    """The configuration with its defaults, what was measured, the seconds of each stage, and where it comes from."""
    write_config(config)
    write_text(config.output / "metrics.json", json.dumps(metrics, indent=1, allow_nan=False) + "\n")
    write_text(config.output / "timings.json", json.dumps(timings, indent=1) + "\n")
    if origin:
        origin.write(config.output)
