"""A contact model with its uncertainty: force, upper quantile, and draws of the parameters."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from acf_jax.contact.body import Body
from acf_jax.contact.peak import RIG, AbstractPeak, Branches, ContactPeak
from acf_jax.dataset.tried import REACH, Tried
from acf_jax.errors import TooLittleData
from acf_jax.kept import compiled_quickly

Scalar = Float[Array, ""]
REDRAWN = 1000  # times, at most: where a hundredth of the draws is kept, e^{-10} of them is left
ROUNDING = 1e-12  # share of the variance: a direction below it is certain


class Variant(eqx.Module):
    """One explanation: its law, parameters and their covariance."""

    peak: AbstractPeak
    theta: np.ndarray  # (p,) SI units
    covariance: np.ndarray  # (p, p)
    low: np.ndarray  # (p,) what a parameter cannot fall below
    weight: float = eqx.field(static=True)


class ContactModel(eqx.Module):
    """A law of the peak contact force and what is known of its parameters.

    z = (m, d, k_F, k_C, parameters of effects, v_E, F_P); `names` and `units` are z's.
    """

    names: tuple[str, ...] = eqx.field(static=True)
    units: tuple[str, ...] = eqx.field(static=True)
    main: Variant
    others: tuple[Variant, ...]  # explanations that stand beside the main one; they share the rig's four
    relative: np.ndarray  # (p + 2,) standard deviation of z over its value, besides `covariance`
    form_error: float  # relative standard deviation of a peak: what the law itself misses
    tried: Tried | None = eqx.field(static=True)  # v_E and F_P of the trials behind it
    source: str = eqx.field(static=True)
    verdict: str | None = eqx.field(static=True, default=None)  # of the diagnosis behind it
    better: bool | None = eqx.field(
        static=True, default=None
    )  # its correction, on conditions that no fit saw
    missing: str = eqx.field(static=True, default="")  # what too little data are short of, and what to add

    def at(self, v_e: float, f_p: float) -> np.ndarray:
        """z at the parameters' best values."""
        return np.array([*self.main.theta, v_e, f_p])

    @property
    def variants(self) -> tuple[Variant, ...]:
        """Every explanation, the main one first."""
        return (self.main, *self.others)

    @property
    def is_certain(self) -> bool:
        """Whether nothing about it is uncertain."""
        return not (self.others or self.form_error or self.main.covariance.any() or self.relative.any())

    @property
    def is_simulated(self) -> bool:
        """Whether samples of some explanation cost a simulation with effects."""
        return any(v.peak.is_simulated() for v in self.variants)

    def relative_of(self, v: Variant) -> np.ndarray:
        """`relative` for z of one of the explanations: the extra parameters of one beside the main have none."""
        if v is self.main:
            return self.relative
        extra = np.zeros(len(v.theta) - len(RIG))
        return np.r_[self.relative[: len(RIG)], extra, self.relative[-2:]]

    def check_carried(self) -> None:
        """`TooLittleData` where the diagnosis behind it could not answer: nothing may be built on its model."""
        if self.verdict == "insufficient_data":
            raise TooLittleData(f"{self.source}: {self._of_verdict}: {self.missing}")

    @property
    def doubt(self) -> str:
        """What the diagnosis behind it takes from every answer; empty where it takes nothing."""
        return "; ".join(filter(None, (self._of_verdict, self._of_correction)))

    @property
    def _of_verdict(self) -> str:
        if self.verdict == "ambiguous":
            many = (
                f"{1 + len(self.others)} explanations stand"
                if self.others
                else "the first explanation alone counts here"
            )
            return f"the diagnosis is ambiguous: {many}"
        return {
            "unknown": "the diagnosis found no known cause: a curve fitted freely stands in for it",
            "insufficient_data": "the diagnosis had too little data to answer",
        }.get(self.verdict or "", "")

    @property
    def _of_correction(self) -> str:
        if self.better is not False:
            return ""
        return (
            "the corrected model is not better than the recalibrated one on conditions that the fit did not see: the"
            " recalibrated one answers, and how far the two differ counts as uncertainty"
        )

    def is_extrapolated(self, z: np.ndarray) -> list[str]:
        """What of v_E and F_P lies outside the tried range, and what of the rest is not as trials fitted it.

        Nothing where no trials are known.
        """
        if self.tried is None:
            return []
        found = self.tried.beyond(float(z[-2]), float(z[-1]))
        if not self.main.covariance.any():  # of a rig's file: no fit
            return found
        fitted, std = self.main.theta, np.sqrt(np.diag(self.main.covariance))
        far = np.flatnonzero(np.abs(z[:-2] - fitted) > REACH * std)
        return found + [
            f"{self.names[k]} = {z[k]:.4g} {self.units[k]} was not tried, the trials' own is {fitted[k]:.4g}"
            for k in far
        ]

    def notes(self, *points: np.ndarray) -> list[str]:
        """What takes from its answers at some z, each once: the diagnosis' verdict, and extrapolation."""
        beyond = dict.fromkeys(fault for z in points for fault in self.is_extrapolated(z))
        return [*filter(None, [self.doubt]), *(f"{fault}: the model extrapolates" for fault in beyond)]


class Spread(NamedTuple):
    """Where a standard deviation of the peak comes from."""

    std: Scalar  # N
    gradient: Float[Array, " p"]  # N per unit of z
    parameters: Float[Array, " p"]  # N^2, share of each entry of z
    form: Scalar  # N^2
    explanations: Scalar  # N^2


@eqx.filter_jit
def spread(
    model: ContactModel, z: Float[Array, " p"], body: Body, factor: Scalar | float = 0.0
) -> tuple[ContactPeak, Spread]:
    """Peak of one sample and its standard deviation, to first order in the parameters.

    sigma^2 = g^T Sigma g + (form error F)^2 + spread between the explanations,  g = dF/dz

    Of several branches, that whose F + factor sigma is largest. Where a deviation is not finite there is no peak: what
    is not known must not pass for certain.
    """
    main = model.main

    def forces(z: Float[Array, " p"]) -> tuple[Array, Branches]:
        found = main.peak.branches(z, body)
        return found.force, found

    gradient, branches = jax.jacfwd(forces, has_aux=True)(z)
    own = jnp.pad(gradient[:, :-2] @ jnp.asarray(main.covariance), ((0, 0), (0, 2)))
    shares = gradient * own + (gradient * (jnp.asarray(model.relative) * z)[None]) ** 2
    weights = jnp.array([v.weight for v in model.variants])
    others = [v.peak(beside(main, v, z), body).force for v in model.others]
    between = jnp.zeros(())
    if others:
        every = jnp.stack([branches.force.max(), *others])
        mean = weights @ every / weights.sum()
        between = weights @ (every - mean) ** 2 / weights.sum()
    form = (model.form_error * branches.force) ** 2
    variance = shares.sum(1) + form + between
    is_certain = variance <= 0
    std = jnp.where(is_certain, 0.0, jnp.sqrt(jnp.where(is_certain, 1.0, variance)))
    k = jnp.argmax(branches.force + factor * std) if std.size > 1 else 0
    peak = ContactPeak(branches.force[k], branches.exists & jnp.isfinite(std).all())
    return peak, Spread(std[k], gradient[k], shares[k], form[k], between)


def beside(main: Variant, other: Variant, z: Array) -> Array:
    """z of another explanation: a design's change of the rig is added to its own values."""
    n = len(RIG)
    rig = jnp.maximum(other.theta[:n] + (z[:n] - main.theta[:n]), other.low[:n])
    return jnp.concatenate([rig, jnp.asarray(other.theta[n:]), z[-2:]])


@compiled_quickly
def _block(peak: AbstractPeak, z: Float[Array, "n p"], body: Body) -> ContactPeak:
    mapped: ContactPeak = jax.vmap(peak, (0, None))(z, body)
    return mapped


def forces(peak: AbstractPeak, z: np.ndarray, body: Body) -> tuple[np.ndarray, np.ndarray]:
    """Force in N and existence of the peak of many samples, z of shape (N, p), in blocks of one size."""
    force, exists = [], []
    for start in range(0, len(z), peak.block):
        part = z[start : start + peak.block]
        padded = part[np.arange(peak.block) % len(part)]
        found = _block(peak, jnp.asarray(padded), Body(*map(jnp.asarray, body)))
        force.append(np.asarray(found.force)[: len(part)])
        exists.append(np.asarray(found.exists)[: len(part)])
    return np.concatenate(force), np.concatenate(exists)


def original_forces(peak: AbstractPeak, z: np.ndarray, body: Body) -> tuple[np.ndarray, np.ndarray]:
    """The same; samples outside a surrogate's range are left to the law that it stands for."""
    force, exists = forces(peak, z, body)
    outside = np.flatnonzero(~exists)
    if outside.size and peak.original() is not peak:
        force[outside], exists[outside] = forces(peak.original(), z[outside], body)
    return force, exists


class Sample(NamedTuple):
    """Draws of everything uncertain about one z, explanation by explanation."""

    of: tuple[np.ndarray, ...]  # (n, p) of each explanation
    form: np.ndarray  # (draws,) by what the law's own error multiplies a force

    def part(self, chosen: np.ndarray) -> "Sample":
        """Those of the draws that are chosen, (draws,) of booleans."""
        ends = np.cumsum([len(z) for z in self.of])[:-1]
        each = zip(self.of, np.split(chosen, ends), strict=True)
        return Sample(tuple(z[mine] for z, mine in each), self.form[chosen])


def draw_sample(model: ContactModel, z: np.ndarray, draws: int, seed: int = 0) -> Sample:
    """Draws of everything uncertain about z: parameters, explanation, form of the law.

    **Arguments:** `z`: (p,), SI units. `draws`: how many. `seed`: of them.

    No parameter falls below its least value: those of the fit are drawn as `deviations` says, what else would is put
    there.
    """
    random = np.random.default_rng(seed)
    weights = np.array([v.weight for v in model.variants])
    counts = random.multinomial(draws, weights / weights.sum())
    found = []
    for v, n in zip(model.variants, counts, strict=True):
        centre = np.asarray(z if v is model.main else beside(model.main, v, jnp.asarray(z)))
        sample = np.tile(centre, (n, 1))
        if n:
            sample[:, :-2] += deviations(v, n, random)
            sample += random.standard_normal(sample.shape) * model.relative_of(v) * centre
        found.append(np.maximum(sample, np.r_[v.low, 0.0, 0.0]))
    return Sample(tuple(found), 1 + model.form_error * random.standard_normal(draws))


def sample_forces(model: ContactModel, sample: Sample, body: Body) -> tuple[np.ndarray, np.ndarray]:
    """Force in N and existence of the peak of each draw.

    Draws outside a surrogate's range are left to the law that it stands for.
    """
    found = [
        original_forces(v.peak, z, body) for v, z in zip(model.variants, sample.of, strict=True) if len(z)
    ]
    if not found:
        return np.zeros(0), np.zeros(0, bool)
    force, exists = map(np.concatenate, zip(*found, strict=True))
    return force * sample.form, exists


def draw_forces(
    model: ContactModel, z: np.ndarray, body: Body, draws: int, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Forces (draws,) of draws of everything uncertain about z, N, and whether each has a peak."""
    return sample_forces(model, draw_sample(model, z, draws, seed), body)


def deviations(v: Variant, draws: int, random: np.random.Generator) -> np.ndarray:
    """Draws (draws, p) of the fit's normal law about its best values, cut off where a parameter would be too low.

    A draw that is too low is drawn again as a whole. Putting the one parameter onto its bound would leave the others
    where they compensate for a value that is not there, which widens the forces.
    """
    root, room = root_of(v.covariance), np.minimum(v.low - v.theta, 0.0) - ROUNDING * np.abs(v.theta)
    found, again = np.zeros((draws, len(v.theta))), np.arange(draws)
    for _ in range(REDRAWN):
        found[again] = random.standard_normal((len(again), root.shape[1])) @ root.T
        again = again[(found[again] < room).any(1)]
        if not again.size:
            break
    return found


def root_of(covariance: np.ndarray) -> np.ndarray:
    """(p, q) R with R R' the covariance (p, p), of the q directions that are not certain.

    By way of correlations: a stiffness and a time in SI units differ by twenty powers of ten in their variances, of
    which an eigenvalue of the covariance itself keeps the largest alone.
    """
    scale = np.sqrt(np.diag(covariance))
    unit = np.where(scale > 0, scale, 1.0)
    values, vectors = np.linalg.eigh(covariance / unit / unit[:, None])
    uncertain = values > ROUNDING
    return np.asarray(scale[:, None] * vectors[:, uncertain] * np.sqrt(values[uncertain]))
