"""A classifier that is trained on our simulator: a network that says how probable each law is, and an unknown cause.

One output a law and one for 'unknown', so that combinations need no class of their own: the probability of an
explanation is the product of its laws' and of the others' absence. Outputs are calibrated on sets that no training saw
(Platt scaling, one pair of numbers for all). BayesFlow's and sbi's model comparison have one class an explanation, of
which there are 698 with up to three laws; that takes far more sets than this.
"""

import itertools
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit
from sklearn.neural_network import MLPClassifier
from sklearn.preprocessing import StandardScaler

from acf_jax.effects import library
from acf_jax.errors import InputError
from acf_jax.evidence.posterior import UNKNOWN
from benchmarks.peers_diagnosis.cases import Case, Explanation, Named
from benchmarks.peers_diagnosis.features import features
from benchmarks.peers_diagnosis.traces import read_traces

LABELS = (*library(), *UNKNOWN)
CALIBRATION = 0.2  # share of the sets, of whole rigs, that calibrate
MOST = 3  # laws named together
CANDIDATES = 8  # the most probable laws, which are combined
TINY = 1e-6
NETWORKS = 3  # whose probabilities are averaged
LAYERS, ALPHA = (256, 128), 1.0  # the best of five shapes on drawn sets that were held back
FEWEST = 500  # sets to train on
CLIP = 6.0  # standard deviations: beyond them a feature says no more


@dataclass(frozen=True)
class Trained:
    """The networks, with what scales their inputs and outputs."""

    scaler: StandardScaler
    networks: tuple[MLPClassifier, ...]
    slope: float
    offset: float

    def outputs(self, x: np.ndarray) -> np.ndarray:
        """Probability of each label, (sets, labels), for features (sets, f)."""
        return expit(self.slope * _logits(self.scaler, self.networks, x) + self.offset)


def labels_of(explanations: Sequence[Explanation]) -> np.ndarray:
    """(sets, labels) 0 or 1."""
    return np.array([[label in e for label in LABELS] for e in explanations], float)


def train(x: np.ndarray, explanations: Sequence[Explanation], rig: np.ndarray, seed: int = 0) -> Trained:
    """Train on the sets of most rigs, calibrate on those of the others.

    **Arguments:** `x`: features (sets, f). `explanations`: what is large in each. `rig`: (sets,) number of its rig.
    """
    y = labels_of(explanations)
    held = rig >= np.quantile(rig, 1 - CALIBRATION)
    scaler = StandardScaler().fit(x[~held])
    networks = tuple(
        MLPClassifier(LAYERS, alpha=ALPHA, early_stopping=True, random_state=seed + k).fit(
            _scaled(scaler, x[~held]), y[~held]
        )
        for k in range(NETWORKS)
    )
    raw, truth = _logits(scaler, networks, x[held]), y[held]

    def loss(ab: np.ndarray) -> float:
        p = np.clip(expit(ab[0] * raw + ab[1]), TINY, 1 - TINY)
        return float(-(truth * np.log(p) + (1 - truth) * np.log(1 - p)).mean())

    slope, offset = minimize(loss, [1.0, 0.0], method="Nelder-Mead").x
    return Trained(scaler, networks, float(slope), float(offset))


def combine(p: np.ndarray, withheld: str = "") -> list[tuple[Explanation, float]]:
    """Explanations with their probabilities, the most probable first, from one output (labels,) a label.

    An unknown cause excludes laws. A withheld law is known to no method: it is absent.
    """
    p = np.clip(p, TINY, 1 - TINY)
    laws = [k for k, label in enumerate(LABELS[:-1]) if label != withheld]
    odds = {LABELS[k]: float(p[k] / (1 - p[k])) for k in laws}
    probable = sorted(odds, key=lambda name: -odds[name])[:CANDIDATES]
    weight: dict[Explanation, float] = {
        tuple(sorted(some)): float(np.prod([odds[name] for name in some]))
        for n in range(MOST + 1)
        for some in itertools.combinations(probable, n)
    }
    total = sum(weight.values())
    scored = {e: float(1 - p[-1]) * w / total for e, w in weight.items()} | {UNKNOWN: float(p[-1])}
    return sorted(scored.items(), key=lambda item: -item[1])


def classify(case: Case, trained: Trained) -> Named:
    """What the classifier says of a case."""
    begin = time.perf_counter()
    x = features(read_traces(case.data))
    scored = combine(trained.outputs(x[None])[0], case.withheld)
    return Named(tuple(scored), time.perf_counter() - begin)


def load(path: Path) -> tuple[np.ndarray, list[Explanation], np.ndarray]:
    """What `python -m benchmarks.peers_diagnosis draw` wrote: features, explanations, numbers of rigs."""
    try:
        with np.load(path, allow_pickle=False) as kept:
            x, told, rig = kept["features"], kept["explanations"].tolist(), kept["rig"]
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path}: cannot be read ({error}); draw the training sets again") from None
    if len(x) < FEWEST:
        raise InputError(f"{path}: holds {len(x)} sets, {FEWEST} are needed; draw more rigs")
    return x, [tuple(e.split("+")) if e else () for e in told], rig


def _scaled(scaler: StandardScaler, x: np.ndarray) -> np.ndarray:
    return np.clip(scaler.transform(x), -CLIP, CLIP)


def _logits(scaler: StandardScaler, networks: Sequence[MLPClassifier], x: np.ndarray) -> np.ndarray:
    p = np.mean([network.predict_proba(_scaled(scaler, x)) for network in networks], 0)
    p = np.clip(p, TINY, 1 - TINY)
    return np.log(p / (1 - p))
