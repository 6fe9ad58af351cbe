"""A corrected model as a diagnosis would leave it, without the diagnosis, and a small training on it."""

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from acf_jax.diagnosis.model_file import SCHEMA, GapModel, Variant, write_model
from acf_jax.diagnosis.space import parameters

RIG = (1.9, 60.0, 800.0, 8e4)
RIG_STD = (0.02, 6.0, 100.0, 1e3)


def variant(effects: tuple[str, ...], own: tuple[float, ...], probability: float) -> Variant:
    """An explanation with 3 % uncertainty of its effects' parameters."""
    std = np.array([*RIG_STD, *(0.03 * x for x in own)])
    return Variant(
        effects=effects,
        probability=probability,
        names=tuple(name for name, _ in parameters(effects)),
        theta=(*RIG, *own),
        covariance=tuple(map(tuple, np.diag(std**2).tolist())),
    )


def gap_model(
    effects: tuple[str, ...] = ("gravity",),
    own: tuple[float, ...] = (-8.0,),
    alternatives: tuple[Variant, ...] = (),
    form_error: float = 0.0,
) -> GapModel:
    """A model whose corrected variant has `effects` with the values `own`."""
    plain = variant((), (), 0.0)
    return GapModel(
        schema=SCHEMA,
        description="made for a test",
        nominal=plain,
        recalibrated=plain,
        corrected=variant(effects, own, 0.9),
        alternatives=alternatives,
        peak_form_error=form_error,
        step_s=1.25e-4,
        sample_rate_hz=8000.0,
        v_range=(0.05, 0.35),
        f_p_range=(50.0, 90.0),
    )


SMALL: dict[str, Any] = {
    "output": "run",
    "ranges": {
        "k_c": {"low": 4e4, "high": 9e4, "unit": "N/m", "scale": "log"},
        "mobility": {"low": 0, "high": 1, "unit": "1/kg"},
    },
    "samples": {"train": 4096, "held_out": 1024, "test": 1024},
    "network": {"width": 16, "depth": 2},
    "optimiser": {
        "learning_rate": 1e-2,
        "warm_up_steps": 50,
        "steps": 1500,
        "batch": 256,
        "steps_per_checkpoint": 500,
    },
}


def configuration(
    folder: Path, effect: str = "gravity", own: tuple[float, ...] = (-8.0,), **more: Any
) -> Path:
    """The small configuration and the model that it names, as files."""
    (folder / "model.json").write_text(write_model(gap_model((effect,), own)), "utf-8")
    content = SMALL | {"labels": {"model": str(folder / "model.json")}} | more
    path = folder / "small.yaml"
    path.write_text(yaml.safe_dump(content), "utf-8")
    return path
