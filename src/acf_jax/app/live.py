"""Answers of a diagnosis' model that follow a slider: peak and band over velocity, by one compiled program.

The law itself answers: the closed form, the simulation of the corrected model, or the surrogate where one was trained.
"""

import math
import threading
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from scipy.stats import norm

from acf_jax.api.model import Model
from acf_jax.api.source import source_of
from acf_jax.app.current import surrogate_of
from acf_jax.contact.body import WALL
from acf_jax.contact.model import ContactModel, spread
from acf_jax.errors import InputError
from acf_jax.report.plot import series

POINTS = 61  # of the curve
KEPT = 8  # models that stay loaded
BEYOND = 1.5  # of the highest that was tried, that a slider reaches
PROBABILITY = 0.975
_FIRST = "To first order the band stays within the limit "
_ASK = "; ask below for a speed that holds with a probability, and until the robot has stopped."

_LOCK = threading.Lock()
_MODELS: dict[tuple[bytes, ...], Model] = {}


class Asked(NamedTuple):
    """Where the sliders are."""

    v_e: float  # m/s
    f_p: float  # N
    stiffness: float  # of the contact, over that which was fitted
    limit: float  # N


def model_of(folder: Path, learnt: Path) -> Model:
    """The model of a diagnosis, by its surrogate where one was trained on it; loaded once for each content.

    **Raises:** `InputError` where a file is damaged, or no answer may be given.
    """
    model = folder / "model.json"
    key = tuple(sha256(path.read_bytes()).digest() if path.is_file() else b"" for path in (model, learnt))
    with _LOCK:
        if key not in _MODELS:
            while len(_MODELS) >= KEPT:
                _MODELS.pop(next(iter(_MODELS)))
            _MODELS[key] = Model(source_of(learnt if surrogate_of(model, learnt) else folder))
        return _MODELS[key]


def spans(model: Model) -> dict[str, tuple[float, float, float]]:
    """Least, largest and first value of each slider: the tried range and somewhat beyond, or a surrogate's range."""
    exact = model.source.exact
    tried = exact.tried
    (v_low, v_high), (f_low, f_high) = (tried.v_e, tried.f_p) if tried else ((0.02, 0.5), (20.0, 200.0))
    stiffness = (0.5, 2.0, 1.0)
    v_span, f_span = (0.5 * v_low, BEYOND * v_high), (0.5 * f_low, BEYOND * f_high)
    if (trained := model.source.trained) is not None:
        v_span, f_span = trained.domain.span("v_e") or v_span, trained.domain.span("f_p") or f_span
        k_c, k = trained.domain.span("k_c"), float(exact.main.theta[3])
        stiffness = (k_c[0] / k, k_c[1] / k, 1.0) if k_c else (1.0, 1.0, 1.0)
    return {
        "v_e": (*v_span, float(np.clip(0.5 * (v_low + v_high), *v_span))),
        "f_p": (*f_span, float(np.clip(0.5 * (f_low + f_high), *f_span))),
        "stiffness": stiffness,
        "limit": (10.0, 1000.0, 140.0),
    }


def curve(model: Model, asked: Asked) -> dict[str, Any]:
    """Expected peak force over velocity with its band of 95 % to first order, the point, and what both are worth.

    `beyond`: where the model extrapolates. `allowed`: which velocities keep the limit, in words.
    """
    law = model.source.model
    low, high, _ = spans(model)["v_e"]
    v_e = np.linspace(max(low, 1e-3), high, POINTS)
    z = np.tile(law.at(asked.v_e, asked.f_p), (POINTS + 1, 1))
    z[:-1, -2], z[:, 3] = v_e, z[:, 3] * asked.stiffness
    force, std, exists = map(np.asarray, _many(law, jnp.asarray(z)))
    force = np.where(exists, force, np.nan)
    factor = float(norm.ppf(PROBABILITY))
    upper, under = force + factor * std, force - factor * std
    allowed, why = _highest(v_e, upper[:-1], asked.limit)
    named = [] if allowed is None else [np.r_[z[-1, :-2], allowed, asked.f_p]]
    return {
        "v_e": series(v_e),
        "force": series(force[:-1]),
        "upper": series(upper[:-1]),
        "lower": series(under[:-1]),
        "beyond": [bool(law.is_extrapolated(one)) for one in z[:-1]],
        "at": {"force": _told(force[-1]), "std": _told(std[-1]), "upper": _told(upper[-1])},
        "none": law.main.peak.no_peak,
        "allowed": why,
        "notes": law.notes(z[-1], *named),
    }


def _highest(v_e: np.ndarray, upper: np.ndarray, limit: float) -> tuple[float | None, str]:
    """The highest velocity up to which all keep the limit, where there is one, and words that say it."""
    told = np.flatnonzero(np.isfinite(upper))
    if not told.size:
        return None, "No velocity shown has a first peak: nothing is known to stay within the limit."
    first = told[0]  # almost at rest a force has no first peak
    broken = np.flatnonzero(~(upper[first:] <= limit))  # a force without a first peak keeps no limit
    if not broken.size:
        highest = _floored(v_e[-1])
        return highest, _FIRST + f"at every velocity shown, up to {highest:.3f} m/s" + _ASK
    if not broken[0]:
        return None, "No velocity shown keeps the first peak within the limit."
    ends = slice(first + broken[0] - 1, first + broken[0] + 1)
    known = np.isfinite(upper[ends]).all()
    highest = _floored(np.interp(limit, upper[ends], v_e[ends]) if known else v_e[ends][0])
    return highest, _FIRST + f"up to about {highest:.3f} m/s" + _ASK


def _floored(v_e: float) -> float:
    """As it is shown, mm/s; not rounded up."""
    return math.floor(1e3 * float(v_e) + 1e-6) / 1e3


@eqx.filter_jit
def _many(model: ContactModel, z: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    peak, about = jax.vmap(lambda one: spread(model, one, WALL))(z)
    return peak.force, about.std, peak.exists


def asked_of(fields: dict[str, str], model: Model) -> Asked:
    """Where the sliders are; `InputError` for what no slider can be at."""
    faults, values = [], {}
    for name, (low, high, _) in spans(model).items():
        try:
            values[name] = float(fields[name])
        except (LookupError, ValueError):
            faults.append(f"{name}: is no number; move the slider")
            continue
        if not low - 1e-9 <= values[name] <= high + 1e-9:
            faults.append(f"{name}: must lie between {low:g} and {high:g}; move the slider")
    if faults:
        raise InputError(faults)
    return Asked(**values)


def _told(value: np.ndarray) -> float | None:
    return float(value) if np.isfinite(value) else None
