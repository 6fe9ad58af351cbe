"""What measured peak forces say about a rig: one product, its interval, and what they leave open."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.typing import NDArray
from scipy.special import stdtrit

from acf_jax.errors import InputError
from acf_jax.model import Impact, Rig, find_peak

LEAST = 0.8  # of its pretension: a peak below that does not include it
MOST = 2000  # peaks; each is left out in turn

Values = NDArray[np.float64]


@dataclass(frozen=True)
class Peaks:
    """Measured peaks, one row a trial."""

    v_e: Values  # m/s, contact velocity, (N,)
    f_p: Values  # N, pretension, (N,)
    f_max: Values  # N, measured peak force, (N,)
    names: tuple[
        str, ...
    ] = ()  # what messages call each, such as a row of a file; "peak 1" and so on by default


@dataclass(frozen=True)
class Identification:
    """The product that peaks identify; errors are root mean squares, relative to the measured peaks."""

    sqrt_k_c_m: float  # N s/m
    interval: tuple[float, float]  # N s/m, 95 %
    error: float  # with the fitted product
    error_left_out: float | None  # each trial predicted from the others; None for one trial
    f_max: Values  # N, peaks of the fitted model


@dataclass(frozen=True)
class Information:
    """Fisher information of the peaks on (ln m, ln k_c, zeta, epsilon).

    A standard deviation is for peaks with the given relative scatter; infinite where the peaks say nothing.
    """

    scatter: float  # relative, of one peak
    std_alone: dict[str, float]  # of a quantity, if all the others were known
    std_together: dict[str, float]  # if none of them were
    rank: int  # combinations known to better than 10 %


def ideal_peak(sqrt_k_c_m: float, v_e: Values, f_p: Values) -> Values:
    """F_C,max = sqrt(F_P^2 + k_C m v^2), the peak for k_F = d = 0, N."""
    return np.hypot(f_p, sqrt_k_c_m * v_e)


def relative_error(model: Values, measured: Values) -> float:
    """Root mean square of (model - measured)/measured."""
    return float(np.sqrt(np.mean(((model - measured) / measured) ** 2)))


def identify(peaks: Peaks) -> Identification:
    """Fit sqrt(k_C m), the one number that peaks identify, by least squares of the relative error.

    minimise sum_i (sqrt(F_P,i^2 + k_C m v_i^2)/F_i - 1)^2

    **Arguments:** `peaks`, N measured peaks.

    **Returns:** `Identification`; the 95 % interval follows from the residuals, by Student's t.

    **Raises:** `InputError` when the peaks cannot hold the product, or are more than `MOST`.
    """
    if peaks.v_e.size > MOST:
        raise InputError(
            f"holds {peaks.v_e.size:,} peaks; give {MOST:,} at most, which tell one number as well"
        )
    below = np.flatnonzero(peaks.f_max < LEAST * peaks.f_p)
    if below.size:
        k = below[0]
        name = peaks.names[k] if peaks.names else f"peak {k + 1}"
        raise InputError(
            f"{below.size} of {peaks.f_max.size} peaks lie below their pretension, the first of them {name}, "
            f"{peaks.f_max[k]:g} N at {peaks.f_p[k]:g} N; peak_force_n must include the pretension, do not take it off"
        )
    product = _fit(peaks)
    f_max = ideal_peak(product, peaks.v_e, peaks.f_p)
    error, size = relative_error(f_max, peaks.f_max), peaks.v_e.size
    interval, left_out = (float("nan"),) * 2, None
    if size > 1:
        slope = product * peaks.v_e**2 / (f_max * peaks.f_max)
        std = error * np.sqrt(size / (size - 1)) / np.linalg.norm(slope)
        half = float(stdtrit(size - 1, 0.975) * std)
        interval = (max(product - half, 0.0), product + half)
        left_out = _error_left_out(peaks)
    return Identification(product, interval, error, left_out, f_max)


def information(peaks: Peaks, identified: Identification) -> Information:
    """What the peaks tell about mass, stiffnesses and damping apart, near the fitted model.

    I = J^T J / scatter^2,  J = d ln F_C,max / d(ln m, ln k_c, zeta, epsilon)

    In zeta and epsilon, which start at zero, J is one-sided. m and k_c enter at zeta = epsilon = 0 by
    their product alone, so how the product is split between them does not matter.

    **Arguments:** `peaks`, N measured peaks. `identified`: what `identify` made of them.

    **Returns:** `Information`; a single peak tells no scatter, so none of its figures is finite then.
    """
    names = ("m", "k_c", "zeta", "epsilon")

    def log_peak(parameters: Float[Array, "4"], v_e: Float[Array, ""], f_p: Float[Array, ""]) -> Array:
        ln_m, ln_k_c, zeta, epsilon = parameters
        m, k_c = jnp.exp(ln_m), jnp.exp(ln_k_c)
        k_f = k_c * epsilon / (1 - epsilon)
        rig = Rig(m, 2 * zeta * jnp.sqrt(m * (k_f + k_c)), k_f, k_c)
        return jnp.log(find_peak(rig, Impact(v_e, f_p)).f_max)

    start = jnp.array([0.0, 2 * np.log(identified.sqrt_k_c_m), 0.0, 0.0])
    jacobian = jax.jit(jax.vmap(jax.jacfwd(log_peak), (None, 0, 0)))(start, peaks.v_e, peaks.f_p)
    size = peaks.v_e.size
    scatter = identified.error * np.sqrt(size / (size - 1)) if size > 1 else float("nan")
    j = np.asarray(jacobian)
    _, singular, directions = np.linalg.svd(j, full_matrices=size < 4)  # four directions in any case
    singular = np.pad(singular, (0, 4 - singular.size))
    known = singular > 1e-9 * singular[0]
    alone = scatter / np.linalg.norm(j, axis=0)
    # The product's own direction, ln sqrt(k_c m), is (ln m + ln k_c)/2.
    quantities = np.vstack([np.eye(4), [0.5, 0.5, 0.0, 0.0]])
    # A quantity with a share in an unknown direction is unknown.
    open_share = np.linalg.norm(quantities @ directions[~known].T, axis=1)
    shares = quantities @ (directions[known].T / singular[known])
    together = np.where(open_share > 1e-6, np.inf, scatter * np.linalg.norm(shares, axis=1))
    std_together = dict(zip((*names, "sqrt_k_c_m"), map(float, together), strict=True))
    std_alone = dict(zip(names, map(float, alone), strict=True))
    # d ln F/d ln sqrt(k_c m) is the sum of the equal derivatives by ln m and ln k_c
    std_alone["sqrt_k_c_m"] = float(scatter / np.linalg.norm(j[:, 0] + j[:, 1]))
    rank = int((scatter < 0.1 * singular[known]).sum())
    return Information(float(scatter), std_alone, std_together, rank)


def _fit(peaks: Peaks) -> float:
    moving = peaks.v_e > 0
    excess = peaks.f_max**2 - peaks.f_p**2
    above = moving & (excess > 0)
    if not above.any():
        raise InputError(
            "no peak exceeds its pretension at a contact velocity above zero, so nothing can be identified; "
            "check the columns and their units (m/s, N)"
        )
    product = float(np.median(np.sqrt(excess[above]) / peaks.v_e[above]))
    step = 0.0
    for _ in range(100):  # Gauss and Newton, in the logarithm so that the product stays positive
        f_max = ideal_peak(product, peaks.v_e, peaks.f_p)
        slope = (product * peaks.v_e) ** 2 / (f_max * peaks.f_max)
        step = float(np.clip(-slope @ (f_max / peaks.f_max - 1) / (slope @ slope), -0.5, 0.5))
        product *= float(np.exp(step))
        if abs(step) < 1e-14:
            return product
    if abs(step) > 1e-6:
        raise InputError(
            "the peaks scatter about their pretension, so the product that fits best is zero; check that peak_force_n "
            "is the peak and that it includes the pretension, or measure at higher contact velocities"
        )
    return product


def _error_left_out(peaks: Peaks) -> float | None:
    errors = []
    for k in range(peaks.v_e.size):
        rest = np.arange(peaks.v_e.size) != k
        try:
            product = _fit(Peaks(peaks.v_e[rest], peaks.f_p[rest], peaks.f_max[rest]))
        except InputError:
            return None  # only the trial left out held the product
        errors.append(ideal_peak(product, peaks.v_e[k], peaks.f_p[k]) / peaks.f_max[k] - 1)
    return float(np.sqrt(np.mean(np.square(errors))))
