"""Sparse regression of the equation of motion by PySINDy, its terms mapped to causes.

Under the nominal rig a trace gives the motion: x = v_E t - (F - F_P)/k_C, x' and x'' by Savitzky and Golay's filter.
What the nominal equation leaves, m x'' + d x' + k_F x - F, is what a cause acts with. Terms by which the rig itself may
be off are projected out; forward regression (FROLS) picks from the rest, as many as BIC has it (Mangan et al., 'Model
selection for dynamical systems via sparse regression and information criteria', Proc. R. Soc. A 473, 2017). Brunton,
Proctor and Kutz, PNAS 113 (2016); de Silva et al., 'PySINDy', JOSS 5 (2020).

No term, no cause. 'unknown' where the terms stand for more than `MOST` causes, or explain less than half of what
noise and scatter do not.
"""

import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pysindy.differentiation import SmoothedFiniteDifference
from pysindy.optimizers import FROLS
from scipy.linalg import qr

from acf_jax.evidence.posterior import UNKNOWN
from benchmarks.peers_diagnosis.cases import Case, Explanation, Named
from benchmarks.peers_diagnosis.traces import Traces, read_traces

MOST = 3  # causes named together
WINDOW = 0.3  # of an impact time, of the smoothing; the best of 0.2 to 0.6 on 40 sets of seed 8301
EDGE = 0.1  # of an impact time at both ends of a trace that is not used: there derivatives are poor
CHANCE = 4.0  # mean square left, over that of noise and scatter, that is no chance
LEFT = 0.5  # share of the variance beyond noise that may be left of what is explained
INDEPENDENT = 1e-6  # length that is left of a unit column beside others
HINGES = (0.4, 0.6, 0.8)  # of the largest stroke or compression, where a stop or a bottom may begin


class Term(NamedTuple):
    """A term of the library, and the cause that it stands for; none for the rig itself."""

    name: str
    cause: str
    values: np.ndarray  # (samples,)


class Motion(NamedTuple):
    """What a trace says under the nominal rig; all (samples,), SI units."""

    t: np.ndarray
    force: np.ndarray
    force_1: np.ndarray  # its derivatives
    impulse: np.ndarray  # N s, integral of the force
    x: np.ndarray
    x_1: np.ndarray
    x_2: np.ndarray
    s: np.ndarray  # compression beyond that of the pretension
    s_1: np.ndarray
    v_e: np.ndarray
    f_p: np.ndarray


def motions(traces: Traces) -> Motion:
    """The motion of all trials, one after the other, without the ends of each trace."""
    k_c = traces.rig[3]
    parts = []
    for k in range(len(traces.v_e)):
        used = traces.used[k]
        t, force = traces.time[k, used], traces.force[k, used]
        if t.size <= _window(traces):
            continue
        mean, force_1, force_2 = derivatives(force, t, _window(traces))
        v_e, f_p = traces.v_e[k], traces.f_p[k]
        s = (mean - f_p) / k_c
        impulse = np.concatenate([[0.0], np.cumsum(0.5 * (mean[1:] + mean[:-1]) * np.diff(t))])
        inside = (t > t[0] + EDGE * traces.impact_time) & (t < t[-1] - EDGE * traces.impact_time)
        rows = [t, mean, force_1, impulse, v_e * t - s, v_e - force_1 / k_c, -force_2 / k_c, s]
        rows += [force_1 / k_c, np.full_like(t, v_e), np.full_like(t, f_p)]
        parts.append(np.array(rows)[:, inside])
    columns = np.concatenate(parts, 1) if parts else np.zeros((11, 0))
    return Motion(*columns)


def terms(motion: Motion) -> tuple[list[Term], list[Term]]:
    """Terms of the rig, and terms of causes.

    The rig's are those of d, k_F and of m or k_C. A cause's term is what it adds to the force, to first order. Four
    causes have none: a gain of the sensor is a stiffness here, and masses that ring need derivatives beyond x''.
    """
    q = motion
    one = np.ones_like(q.t)
    deep, far = float(q.s.max(initial=1e-9)), float(q.x.max(initial=1e-9))
    rig = [Term("x'", "", q.x_1), Term("x", "", q.x), Term("F", "", q.force)]
    causes = [
        Term("1", "gravity", one),
        Term("sign x'", "coulomb_friction", np.tanh(q.x_1 / (0.02 * float(np.abs(q.x_1).max(initial=1e-9))))),
        Term("F_P", "pretension_error", q.f_p),
        Term("F_P t", "force_regulation", q.f_p * q.t),
        Term("s s'", "contact_damping", q.s * q.s_1),
        Term("s'", "contact_damping", q.s_1),
        Term("s^2", "contact_hardening", q.s * np.abs(q.s)),
        Term("s^3", "contact_hardening", q.s**3),
        Term("int F", "pad_relaxation", q.impulse),
        Term("F'", "sensor_lag", q.force_1),
        Term("t^2", "robot_deceleration", q.t**2),
        Term("v_E t^2", "robot_deceleration", q.v_e * q.t**2),
        Term("F t", "robot_compliance", q.force * q.t),
    ]
    causes += [Term(f"(s - {h:g})+", "pad_bottoming", np.maximum(q.s - h * deep, 0.0)) for h in HINGES]
    causes += [Term(f"(x - {h:g})+", "end_stop", np.maximum(q.x - h * far, 0.0)) for h in HINGES]
    return rig, causes


def name_causes(traces: Traces, withheld: str = "") -> Explanation:
    """The causes whose terms are picked, or 'unknown'."""
    motion = motions(traces)
    if motion.t.size < 50:
        return ()
    m, d, k_f, _ = traces.rig
    left = m * motion.x_2 + d * motion.x_1 + k_f * motion.x - motion.force
    rig, causes = terms(motion)
    causes = [term for term in causes if term.cause != withheld]
    basis, _ = np.linalg.qr(_normed([term.values for term in rig]))
    target = left - basis @ (basis.T @ left)
    columns = _normed([term.values for term in causes])
    columns -= basis @ (basis.T @ columns)
    lengths = np.linalg.norm(columns, axis=0)
    alive = np.flatnonzero(lengths > 1e-3)  # the others are combinations of the rig's terms
    columns = columns[:, alive] / lengths[alive]
    kept = independent_of(columns)
    causes, columns = [causes[k] for k in alive[kept]], columns[:, kept]
    samples = motion.t.size
    independent = max(samples / _window(traces), float(len(causes) + 2))
    picked, rest = pick(columns, target, independent)
    found = sorted({causes[k].cause for k in picked})
    before, after = float((target**2).mean()), float((rest**2).mean())
    by_chance = noise(traces) ** 2 + traces.spread[0] ** 2 * float((motion.force**2).mean())
    is_left = after > CHANCE * by_chance and after - by_chance > LEFT * (before - by_chance)
    return UNKNOWN if len(found) > MOST or is_left else tuple(found)


def independent_of(columns: np.ndarray) -> np.ndarray:
    """Which of unit columns (samples, terms) are kept, so that none is a combination of others.

    There FROLS breaks down; terms of the velocity are, where all trials have one.
    """
    _, r, order = qr(columns, mode="economic", pivoting=True)
    return np.sort(order[: len(r)][np.abs(np.diag(r)) > INDEPENDENT])


def pick(columns: np.ndarray, target: np.ndarray, independent: float) -> tuple[list[int], np.ndarray]:
    """The terms that FROLS picks one after the other, as many as BIC has it, and what is left of the target.

    **Arguments:** `columns`: (samples, terms) of unit length. `target`: (samples,). `independent`: how many samples
    count as independent.
    """
    options: list[tuple[float, list[int], np.ndarray]] = []
    for number in range(MOST + 2):
        coefficients = np.zeros(columns.shape[1])
        if number:
            coefficients = FROLS(max_iter=number, alpha=0.0).fit(columns, target).coef_[0]
        kept = np.flatnonzero(coefficients).tolist()
        rest = target - columns @ coefficients
        size = max(float((rest**2).mean()), 1e-30)
        options.append((independent * np.log(size) + len(kept) * np.log(independent), kept, rest))
    _, kept, rest = min(options, key=lambda option: option[0])
    return kept, rest


def identify(case: Case) -> Named:
    """What sparse regression says of a case, without a probability."""
    begin = time.perf_counter()
    found = name_causes(read_traces(case.data), case.withheld)
    return Named(((found, 1.0),), time.perf_counter() - begin, is_sure=True)


def derivatives(force: np.ndarray, t: np.ndarray, window: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The smoothed force and its first two derivatives; all (n,)."""
    smooth = SmoothedFiniteDifference(smoother_kws={"window_length": window, "polyorder": 3})
    once = smooth(force[:, None], t)
    mean = smooth.smoothed_x_[:, 0]
    return mean, once[:, 0], smooth(once, t)[:, 0]


def noise(traces: Traces) -> float:
    """Standard deviation of what is left of the equation that noise alone makes, N: mostly that of x''."""
    m, d, k_f, k_c = traces.rig
    t = np.arange(4000) * float(np.median(traces.interval))
    drawn = np.random.default_rng(0).standard_normal(t.size) * traces.noise * np.sqrt(traces.dependent)
    mean, once, twice = derivatives(drawn, t, _window(traces))
    return float((m / k_c * twice + d / k_c * once + (k_f / k_c + 1) * mean).std())


def _window(traces: Traces) -> int:
    """Samples of the smoothing, an odd number."""
    return max(5, int(WINDOW * traces.impact_time / float(np.median(traces.interval))) | 1)


def _normed(columns: Sequence[np.ndarray]) -> np.ndarray:
    stacked = np.stack(columns, 1)
    return stacked / np.maximum(np.linalg.norm(stacked, axis=0), 1e-30)
