"""The evidence of an explanation, by Laplace as the diagnosis computes it, against a nested sampler (nautilus).

    python -m benchmarks.log_evidence

Ten drawn sets of eight trials, each with another hidden cause: log Z of the law behind it. Both integrate over the
rig, the law's parameters, what all trials share, and the nuisances of each trial; the sampler takes the nuisances
linear about their best values. Lange, 'nautilus: boosting Bayesian importance nested sampling', MNRAS 525, 2023.
"""

import argparse

import jax
import jax.numpy as jnp
import numpy as np
from nautilus import Sampler
from scipy.special import logsumexp
from scipy.stats import norm

from acf_jax.evidence.marginal import marginal
from acf_jax.evidence.strengths import SIZES, ways, weigh
from acf_jax.inference.fit import Fit
from acf_jax.inference.forward import SAMPLES, unpack
from acf_jax.inference.interpolation import combine_row, taps
from acf_jax.inference.linear import normal_equations
from acf_jax.inference.observations import N_NUISANCE, Observations
from acf_jax.inference.parameters import COMMON, RIG, every_effect
from acf_jax.model import Impact
from acf_jax.simulator.simulate import simulate

TRIALS = 8
CAUSES = (
    "coulomb_friction", "gravity", "contact_damping", "contact_hardening", "pad_relaxation",
    "robot_compliance", "robot_deceleration", "sensor_lag", "sensor_scale", "sensor_resonance",
)  # fmt: skip
LIVE = 300  # points of the sampler
BATCH = 100  # points that are simulated in one call


def nested(observations: Observations, fitted: Fit, live: int = LIVE, seed: int = 0) -> float:
    """Log Z of a fit's explanation by nested sampling (Skilling, 2006), under the priors of `marginal`.

    **Arguments:** `fitted`: of no law, or of one. The sampler integrates over the way in which its strengths act that
    `marginal` finds most probable; what other ways add is taken from that.
    """
    o, at, size = observations, fitted.coordinates, len(fitted.u)
    found = weigh(fitted).ways
    acting = np.array(max(found, key=lambda way: found[way]), int)
    strengths, width = _strengths(fitted, acting)
    absent = np.setdiff1d(strengths, acting)
    free = np.setdiff1d(np.arange(size), absent)

    # the prior of a share of another one ends where the share does
    lowest, highest = norm.cdf(np.where(at.is_part, [at.low, at.high], [[-np.inf], [np.inf]]))[:, free]

    def prior(v: np.ndarray) -> np.ndarray:
        u = fitted.u.copy()
        u[absent] = 0.0
        u[free] = norm.ppf(np.clip(lowest + v * (highest - lowest), 1e-12, 1 - 1e-12))
        left = width * SIZES[0] * (SIZES[-1] / SIZES[0]) ** v[np.searchsorted(free, acting[:1])].sum()
        for k, j in enumerate(acting):  # the total is broken like a stick: its pieces are uniform
            others = len(acting) - 1 - k
            part = 1 - v[np.searchsorted(free, acting[k + 1])] ** (1 / others) if others else 1.0
            u[j] = np.sign(fitted.u[j]) * left * part
            left *= 1 - part
        return np.asarray(u)

    log_likelihood = _Likelihood(o, fitted)

    def inside(v: np.ndarray) -> np.ndarray:
        u = np.array([prior(row) for row in v])
        within = ((u >= at.low) & (u <= at.high)).all(1)
        return np.where(within, log_likelihood(np.clip(u, at.low, at.high)), -1e100)

    sampler = Sampler(
        lambda v: v,
        inside,
        len(free),
        n_live=live,
        n_networks=0,  # ellipsoids alone: training costs more than it saves in so few dimensions
        n_batch=BATCH,
        vectorized=True,
        pass_dict=False,
        seed=seed,
    )
    sampler.run(n_eff=live)
    others = logsumexp(list(found.values())) - max(found.values())
    return float(sampler.log_z + others - sum(np.log(ways(name)) for name in fitted.explanation))


class _Likelihood:
    """The log likelihood of many parameters at once, the nuisances integrated out."""

    def __init__(self, observations: Observations, fitted: Fit):
        self.o, self.fitted = observations, fitted
        self.linear = fitted.linearised()
        normal = normal_equations(self.linear, fitted.u, fitted.nuisance)
        self.inverse = normal.nuisance_inverse
        self.constant = 0.5 * np.linalg.slogdet(self.inverse)[1].sum() - 0.5 * (fitted.nuisance**2).sum()
        self.shift = fitted.nuisance[:, :N_NUISANCE] * observations.nuisance_std
        z = np.column_stack([observations.v_e + self.shift[:, 0], observations.f_p + self.shift[:, 1]])

        def one(theta: jax.Array, impact: jax.Array) -> tuple[jax.Array, jax.Array]:
            rig, effects = unpack(fitted.explanation, theta)
            found = simulate(
                rig, Impact(impact[0], impact[1]), effects, fitted.grid.h, SAMPLES, fitted.grid.steps
            )
            return found.sensed, found.contact

        over_trials = jax.vmap(one, in_axes=(None, 0))
        self.forces = jax.jit(lambda theta: jax.vmap(over_trials, in_axes=(0, None))(theta, jnp.asarray(z)))

    def __call__(self, u: np.ndarray) -> np.ndarray:
        """(k,) for coordinates (k, p)."""
        theta = self.fitted.coordinates.value(u)
        count = len(self.fitted.physical)
        padded = theta[np.arange(BATCH) % len(theta), :count]
        sensed, contact = (np.asarray(a)[: len(theta)] for a in self.forces(padded))
        return np.array([self._one(*row) for row in zip(theta[:, count:], sensed, contact, strict=True)])

    def _one(self, shared: np.ndarray, sensed: np.ndarray, contact: np.ndarray) -> float:
        zero, delay = shared
        at = taps(self.o.time - (delay + self.shift[:, 2])[:, None], self.fitted.grid.h, contact)
        predicted = combine_row(sensed, at.near, at.weight) + zero
        residual = self.o.whiten(((self.o.force - predicted) * self.o.used)[:, None])[:, 0]
        gradient = self.fitted.nuisance - np.einsum("ian,in->ia", self.linear.by_nuisance, residual)
        gain = np.einsum("ia,iab,ib->", gradient, self.inverse, gradient)
        value = self.constant - 0.5 * (residual**2).sum() + 0.5 * gain
        return float(value) if np.isfinite(value) else -1e100


def _strengths(fitted: Fit, acting: np.ndarray) -> tuple[np.ndarray, float]:
    """Where the strengths of a single law stand, and the standard deviation of the sum of those that act."""
    known = [p for name in fitted.explanation for p in every_effect()[name].parameters()]
    strengths = len(RIG) + np.flatnonzero([p.is_size for p in known])
    free = np.setdiff1d(np.arange(len(fitted.u)), np.setdiff1d(strengths, acting))
    variance, sign = np.linalg.inv(fitted.hessian[np.ix_(free, free)]), np.sign(fitted.u[acting])
    place = np.searchsorted(free, acting)
    return strengths, float(np.sqrt(sign @ variance[np.ix_(place, place)] @ sign))


def main() -> None:
    """Compare, one set after the other."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sets", type=int, default=len(CAUSES))
    chosen = parser.parse_args()
    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.dataset import assess_dataset
    from acf_jax.diagnosis.candidates import fit_nominal, fit_single
    from acf_jax.inference.baseline import Ground
    from acf_jax.inference.observations import observe
    from benchmarks.drawn_set import SEED, draw_set

    print("| law | parameters | log Z, Laplace | log Z, nested | difference |\n|--|--|--|--|--|")
    for k, cause in enumerate(CAUSES[: chosen.sets]):
        o = observe(assess_dataset(draw_set(TRIALS, cause, SEED + k)))
        fitted = fit_single(Ground.of(o, fit_nominal(o)), cause)
        laplace, sampled = marginal(fitted).log_z, nested(o, fitted)
        free = len(fitted.u) - COMMON
        print(
            f"| `{cause}` | {free} | {laplace:.2f} | {sampled:.2f} | {laplace - sampled:+.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
