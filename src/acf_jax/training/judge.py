"""The errors of a surrogate of a corrected model: on samples, and where a search finds the worst."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from acf_jax.surrogate.corrected import CorrectedSurrogate, is_first_peak
from acf_jax.training.evaluate import distribution, error_table, figures
from acf_jax.training.labels import Labels, Simulator

STARTS = 128  # worst samples from which the search begins
TRIES = 16  # points around each of them, each round nearer
ROUNDS = 6
FIRST_STEP = 0.2  # of the box


class Answers(NamedTuple):
    """What the surrogate says of samples, and what it misses."""

    force: np.ndarray  # (n,) error relative to the simulation
    time: np.ndarray  # (n,) s, error
    a: np.ndarray  # (n,) third output
    is_first: np.ndarray  # (n,) bool, by the simulation: the first peak is the largest force

    def held(self, least: float) -> "Answers":
        """Those that the surrogate answers."""
        return Answers(*(column[self.a > least] for column in self))

    def tolerance(self) -> float:
        """The largest error of the force where it is learnt."""
        return float(np.abs(self.force[self.is_first]).max())


@eqx.filter_jit
def _ask(surrogate: CorrectedSurrogate, *columns: jax.Array) -> tuple[jax.Array, ...]:
    q, force, time, exists = columns
    own_force, own_time, a = surrogate(q.T)
    return own_force / force - 1, own_time - time, a, jax.vmap(is_first_peak)(q, time, exists)


def ask(surrogate: CorrectedSurrogate, labels: Labels) -> Answers:
    """Surrogate against simulation."""
    return Answers(*map(np.asarray, _ask(surrogate, *map(jnp.asarray, labels[1:]))))


def missed(answers: Answers) -> np.ndarray:
    """Size of the error where there is an answer to give."""
    return np.where(answers.is_first, np.abs(answers.force), 0.0)


def misled(answers: Answers, tolerance: float) -> np.ndarray:
    """How sure the surrogate is where it should not answer: the force is larger later, by more than the tolerance."""
    return np.where(~answers.is_first & (np.abs(answers.force) > tolerance), answers.a, -np.inf)


def search_worst(
    surrogate: CorrectedSurrogate,
    simulate: Simulator,
    labels: Labels,
    size: Callable[[Answers], np.ndarray],
    seed: int,
) -> Answers:
    """Answers at points that a random search climbs to from the samples that are worst by `size`."""
    random = np.random.default_rng(seed)
    error = size(ask(surrogate, labels))
    worst = np.argsort(-error, kind="stable")[:STARTS]
    best, top = labels.unit[worst], error[worst]
    rows, found = np.arange(len(best)), []
    for k in range(ROUNDS):
        step = FIRST_STEP * 0.5**k * random.standard_normal((TRIES, *best.shape))
        tried = np.clip(best + step, 0.0, 1.0)
        unit = tried.reshape(-1, best.shape[1])
        q = surrogate.domain.at(unit)
        found.append(ask(surrogate, Labels(unit, q, *simulate(q))))
        error = size(found[-1]).reshape(TRIES, -1)
        largest = error.argmax(0)
        is_better = error[largest, rows] > top
        best = np.where(is_better[:, None], tried[largest, rows], best)
        top = np.maximum(top, error.max(0))
    return joined(found)


def joined(parts: Sequence[Answers]) -> Answers:
    """Answers one after another."""
    return Answers(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def judge(surrogate: CorrectedSurrogate, test: dict[str, Labels], search: Answers) -> dict[str, Any]:
    """Everything the report says about errors, as plain numbers."""
    bounds = {name: float(value) for name, value in vars(surrogate.bounds).items()}
    found: dict[str, Any] = {"bounds": bounds, "samples": {}, "errors": {}, "time_s": {}}
    for name, labels in test.items():
        answers = ask(surrogate, labels)
        is_answered = answers.a > bounds["least"]
        held = answers.held(bounds["least"])
        found["samples"][name] = {"answered": held.force.size, "left_out": int((~is_answered).sum())}
        bound = bounds["force"] * (
            1 + held.force
        )  # of the surrogate's force; errors are shares of the simulated
        found["errors"][name] = figures(held.force, bound, labels.force[is_answered])
        median, p99, largest = np.quantile(np.abs(held.time[held.is_first]), [0.5, 0.99, 1.0]).tolist()
        found["time_s"][name] = {"median": median, "p99": p99, "max": largest}
        if name == "box":
            found["distribution"] = distribution(held.force)
            found["worst"] = _worst(surrogate, labels, answers, is_answered)
    found["search"] = {"tried": search.force.size, "largest": float(np.abs(search.force).max())}
    return found


def _worst(
    surrogate: CorrectedSurrogate, labels: Labels, answers: Answers, is_answered: np.ndarray, count: int = 10
) -> list[dict[str, float]]:
    order = np.argsort(-np.abs(answers.force) * is_answered, kind="stable")[:count]
    domain = surrogate.domain
    return [
        {domain.names[k]: float(labels.q[i, k]) for k in domain.free}
        | {"peak_force_n": float(labels.force[i]), "relative_error": float(answers.force[i])}
        for i in order
    ]


def summary(metrics: dict[str, Any]) -> str:
    """The errors as text for a terminal."""
    lines = error_table("model", {"corrected": metrics["errors"]["box"]})
    edges, bounds, time = metrics["errors"]["edges"], metrics["bounds"], metrics["time_s"]["box"]
    search, drawn, counts = metrics["search"], metrics["errors"]["box"], metrics["samples"]["box"]
    lines += [
        f"{'at the edges':>14} "
        + " ".join(f"{edges['relative'][key]:9.1e}" for key in ("median", "p99", "p99_9", "max"))
        + f" {edges['relative']['largest_under_prediction']:15.1e}, "
        + f"{edges['newton']['largest_under_prediction']:.1e} N",
        f"time of the peak: median error {1e3 * time['median']:.2g} ms, p99 {1e3 * time['p99']:.2g} ms, "
        f"max {1e3 * time['max']:.2g} ms",
        f"error bound: {bounds['force']:.1e} of the force. Of the fresh samples {drawn['above_bound']} of "
        f"{drawn['samples']:,} exceed it, at the edges {edges['above_bound']} of {edges['samples']:,}; a search "
        f"for the worst found {search['largest']:.1e} in {search['tried']:,} tries",
        f"left to the simulation: {counts['left_out']:,} of {counts['left_out'] + counts['answered']:,} fresh samples, "
        "where the force may be larger after its first peak than at it",
    ]
    return "\n".join(lines)
