"""A classifier that is trained on our simulator: BayesFlow's model comparison, with one class an explanation.

The classes are no cause, each law, each pair of laws, and an unknown cause. Three laws have no class, and sets of them
are left out of the training: one or two were drawn of each triple. Probabilities are raised to one power, which is
fitted on rigs that no training saw.
"""

import itertools
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

# Keras reads it when it is imported. JAX is installed wherever this package is.
os.environ.setdefault("KERAS_BACKEND", "jax")

import keras
import numpy as np
from bayesflow.approximators import ModelComparisonApproximator
from bayesflow.datasets import OfflineDataset
from bayesflow.networks import MLP
from scipy.optimize import minimize_scalar
from scipy.special import softmax

from acf_jax.effects import library
from acf_jax.errors import InputError
from acf_jax.evidence.posterior import UNKNOWN
from benchmarks.peers_diagnosis.cases import Case, Explanation, Named
from benchmarks.peers_diagnosis.features import features
from benchmarks.peers_diagnosis.traces import read_traces

MOST = 2  # laws named together
CLASSES: tuple[Explanation, ...] = (
    *(some for n in range(MOST + 1) for some in itertools.combinations(sorted(library()), n)),
    UNKNOWN,
)
CALIBRATION = 0.2  # share of the sets, of whole rigs, that calibrate
POWERS = 0.2, 5.0  # least and largest that the calibration tries
TINY = 1e-12  # least probability of a class, whose logarithm is then finite
NETWORKS = 3  # whose probabilities are averaged
WIDTHS, DROPOUT = (256, 256, 256, 256), 0.5  # the best of seven shapes on drawn sets that were held back
EPOCHS, BATCH = 30, 128  # with 20 or 60 epochs the log loss of these sets is larger
RATE = 1e-3  # at first; it falls to 0 along a cosine. With half or twice of it the log loss is larger
FEWEST = 500  # sets to train on
CLIP = 6.0  # standard deviations: beyond them a feature says no more


@dataclass(frozen=True)
class Trained:
    """The networks, with what scales their inputs and outputs."""

    mean: np.ndarray  # (f,)
    std: np.ndarray  # (f,)
    networks: tuple[ModelComparisonApproximator, ...]
    power: float

    def probabilities(self, x: np.ndarray) -> np.ndarray:
        """Probability of each class, (sets, classes), for features (sets, f)."""
        told = {"inference_conditions": _scaled(x, self.mean, self.std)}
        p = np.mean([network.predict(conditions=told) for network in self.networks], 0)
        return softmax(self.power * np.log(np.maximum(p, TINY)), -1)


def train(x: np.ndarray, explanations: Sequence[Explanation], rig: np.ndarray, seed: int = 0) -> Trained:
    """Train on the sets of most rigs, calibrate on those of the others.

    **Arguments:** `x`: features (sets, f). `explanations`: what is large in each. `rig`: (sets,) number of its rig.
    """
    number = {e: k for k, e in enumerate(CLASSES)}
    y = np.array([number.get(e, -1) for e in explanations])
    held = rig >= np.quantile(rig, 1 - CALIBRATION)
    learnt, judged = ~held & (y >= 0), held & (y >= 0)
    mean, std = x[learnt].mean(0), x[learnt].std(0) + TINY
    scaled = _scaled(x[learnt], mean, std)
    networks = tuple(_network(scaled, y[learnt], seed + k) for k in range(NETWORKS))
    log_p = np.log(Trained(mean, std, networks, 1.0).probabilities(x[judged]))
    truth = np.arange(len(log_p)), y[judged]

    def loss(power: float) -> float:
        return float(-np.log(softmax(power * log_p, -1)[truth]).mean())

    power = float(minimize_scalar(loss, bounds=POWERS, method="bounded").x)
    return Trained(mean, std, networks, power)


def rank(p: np.ndarray, withheld: str = "") -> list[tuple[Explanation, float]]:
    """Explanations with their probabilities, the most probable first, from those of the classes, (classes,).

    A withheld law is known to no method: its classes are absent.
    """
    known = {e: float(q) for e, q in zip(CLASSES, p, strict=True) if withheld not in e}
    total = sum(known.values())
    return sorted(((e, q / total) for e, q in known.items()), key=lambda item: -item[1])


def classify(case: Case, trained: Trained) -> Named:
    """What the classifier says of a case."""
    begin = time.perf_counter()
    x = features(read_traces(case.data))
    scored = rank(trained.probabilities(x[None])[0], case.withheld)
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


def _scaled(x: np.ndarray, mean: np.ndarray, std: np.ndarray) -> np.ndarray:
    return np.clip((x - mean) / std, -CLIP, CLIP).astype(np.float32)


def _network(x: np.ndarray, y: np.ndarray, seed: int) -> ModelComparisonApproximator:
    """One trained network, for scaled features (sets, f) and the numbers of their classes (sets,)."""
    keras.utils.set_random_seed(seed)
    network = ModelComparisonApproximator(
        num_models=len(CLASSES), classifier_network=MLP(WIDTHS, dropout=DROPOUT, norm="layer")
    )
    told = {"inference_variables": np.eye(len(CLASSES), dtype=np.float32)[y], "inference_conditions": x}
    sets = OfflineDataset(told, BATCH, adapter=None)
    falling = keras.optimizers.schedules.CosineDecay(RATE, EPOCHS * sets.num_batches)
    network.compile(optimizer=keras.optimizers.AdamW(falling))
    network.fit(dataset=sets, epochs=EPOCHS, verbose=0)
    return network
