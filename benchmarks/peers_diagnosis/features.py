"""A data set as a vector of fixed length, whatever its trials and sampling rate: what a recalibrated rig leaves.

The paper's model is recalibrated on all traces, each trial with its own velocity, pretension and trigger. What it
leaves is averaged over shares of the impact time, and regressed there on speed and pretension.
"""

from typing import NamedTuple

import numpy as np

from benchmarks.peers_diagnosis.traces import Traces
from validation.worlds.interface import Rig
from validation.worlds.paper import contact_force

BINS = 24
SPAN = 1.5  # impact times
ITERATIONS = 3
STEP = 1e-4  # relative, of finite differences
RIDGE = 0.02  # of the regression on speed and pretension, whose terms are shares of their means
LEAST = 0.05  # share of its nominal value that a constant of the rig keeps
ZERO = 1.0  # N, standard deviation of the sensor's zero
COMMON = 0.15  # sampling intervals, standard deviation of the delay of all triggers


class Binned(NamedTuple):
    """Means over shares of the impact time."""

    time: np.ndarray  # (trials, bins) s
    force: np.ndarray  # (trials, bins) N
    samples: np.ndarray  # (trials, bins)


class Recalibrated(NamedTuple):
    """The paper's model refitted."""

    left: np.ndarray  # (trials, bins) N, of the force
    shift: np.ndarray  # (5,) of m, d, k_F, k_C and the sensor's zero, in standard deviations
    own: np.ndarray  # (trials, 2) of velocity and pretension, in standard deviations


def binned(traces: Traces) -> Binned:
    """The samples of each trial averaged over `BINS` shares of `SPAN` impact times."""
    trials = len(traces.v_e)
    bins = np.floor(traces.time / (SPAN * traces.impact_time) * BINS).astype(int)
    inside = traces.used & (bins >= 0) & (bins < BINS)
    index = (np.arange(trials)[:, None] * BINS + bins)[inside]

    def summed(values: np.ndarray) -> np.ndarray:
        return np.bincount(index, values[inside], trials * BINS).reshape(trials, BINS)

    count = summed(np.ones_like(traces.time))
    number = np.maximum(count, 1.0)
    return Binned(summed(traces.time) / number, summed(traces.force) / number, count)


def recalibrate(traces: Traces, seen: Binned) -> Recalibrated:
    """Refit rig, zero and delay by Gauss and Newton's method, what each trial has of its own integrated out."""
    variance = traces.noise**2 * traces.dependent / np.maximum(seen.samples, 1e-6)
    interval = float(np.median(traces.interval))
    theta, shared = traces.rig.copy(), np.zeros(2)
    std = np.concatenate([traces.rig_std, [ZERO, COMMON * interval]])
    own_std = np.stack([traces.spread[0] * traces.v_e, traces.spread[1] * traces.f_p, traces.trigger], -1)
    for iteration in range(ITERATIONS + 1):
        by_speed, by_force = _unit(theta, seen.time - shared[1])
        model = traces.v_e[:, None] * by_speed + traces.f_p[:, None] * by_force + shared[0]
        slope = _slope(traces, theta, seen.time - shared[1])
        left = seen.force - model
        own = np.stack([by_speed, by_force, -slope], -1) * own_std[:, None, :]
        over = own / variance[..., None]
        inner = np.eye(3) + np.einsum("tbk,tbl->tkl", own, over)
        size = np.linalg.solve(inner, np.einsum("tbk,tb->tk", over, left)[..., None])[..., 0]
        if iteration == ITERATIONS:
            break
        jacobian = _jacobian(traces, theta, seen.time - shared[1], slope) * std
        by_own = np.linalg.solve(inner, np.einsum("tbk,tbp->tkp", over, jacobian))
        weighted = jacobian / variance[..., None] - np.einsum("tbk,tkp->tbp", over, by_own)
        u = np.concatenate([(theta - traces.rig) / std[:4], shared / std[4:]])
        normal = np.einsum("tbp,tbq->pq", jacobian, weighted) + np.eye(6)
        change = np.linalg.solve(normal, np.einsum("tbp,tb->p", weighted, left) - u)
        u = u + change * min(1.0, 3.0 / float(np.abs(change).max()))
        theta = np.maximum(traces.rig + u[:4] * std[:4], LEAST * traces.rig)
        shared = u[4:] * std[4:]
    shift = np.concatenate([(theta - traces.rig) / std[:4], shared[:1] / ZERO])
    filled = seen.samples > 0
    return Recalibrated((left - np.einsum("tbk,tk->tb", own, size)) * filled, shift, size[:, :2])


def features(traces: Traces) -> np.ndarray:
    """The vector: what is left, in units of its own size and of the noise; its size; shifts; rig and campaign."""
    seen = binned(traces)
    found = recalibrate(traces, seen)
    v, f = traces.v_e, traces.f_p
    speed, pretension = v / v.mean() - 1, f / max(float(f.mean()), 1.0) - 1
    basis = np.stack([np.ones_like(v), speed, pretension, speed**2], -1)
    weight = seen.samples / max(float(seen.samples[seen.samples > 0].mean()), 1e-6)
    gram = np.einsum("tb,tp,tq->bpq", weight, basis, basis) / len(v) + RIDGE * np.eye(4)
    moment = np.einsum("tb,tp,tb->bp", weight, basis, found.left) / len(v)
    curves = np.linalg.solve(gram, moment[..., None])[..., 0].T / traces.noise
    rms = float(np.sqrt((curves[0] ** 2).mean())) + 1e-3
    each = float(np.sqrt((found.left**2 * weight).sum() / max(weight.sum(), 1e-6))) / traces.noise + 1e-3
    certain = np.sqrt(BINS * traces.dependent / max(float(seen.samples.sum()), 1.0))
    m, d, k_f, k_c = traces.rig
    scale = [
        np.log(rms),
        np.log(each),
        np.log(rms * traces.noise / max(float(seen.force.max()), 1e-6)),
        np.log(certain),  # what noise alone makes of the first: how many samples there are
        *np.arcsinh(found.shift),
        *np.log(0.1 + np.sqrt((found.own**2).mean(0))),
    ]
    context = [
        np.log(traces.impact_time),
        np.log(m),
        np.log(max(d, 1e-3) / (2 * np.sqrt(m * k_c))),
        k_f / k_c,
        np.log(v.mean() * np.sqrt(m * k_c) / 100),
        np.log(max(float(f.mean()), 1.0) / 100),
        float(pretension.std()),
    ]
    shape, size = np.arcsinh(curves.ravel() / rms), np.arcsinh(curves.ravel())
    return np.concatenate([shape, size, scale, context])


def _unit(theta: np.ndarray, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Force per velocity and per pretension, in which the paper's model is linear."""
    one, none = np.ones((len(time), 1)), np.zeros((len(time), 1))
    rig = Rig(*theta.tolist())
    return contact_force(rig, one, none, time), contact_force(rig, none, one, time)


def _force(traces: Traces, theta: np.ndarray, time: np.ndarray) -> np.ndarray:
    return contact_force(Rig(*theta.tolist()), traces.v_e[:, None], traces.f_p[:, None], time)


def _slope(traces: Traces, theta: np.ndarray, time: np.ndarray) -> np.ndarray:
    h = STEP * traces.impact_time
    return (_force(traces, theta, time + h) - _force(traces, theta, time - h)) / (2 * h)


def _jacobian(traces: Traces, theta: np.ndarray, time: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """(trials, bins, 6) by the rig's constants, zero and delay."""
    columns = []
    for j in range(4):
        h = STEP * max(abs(theta[j]), traces.rig_std[j])
        up, down = theta.copy(), theta.copy()
        up[j], down[j] = theta[j] + h, theta[j] - h
        columns.append((_force(traces, up, time) - _force(traces, down, time)) / (2 * h))
    return np.stack([*columns, np.ones_like(time), -slope], -1)
