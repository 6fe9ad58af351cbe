"""What of a surrogate is exported: named inputs, named outputs, and the function between them."""

from collections.abc import Callable
from decimal import ROUND_CEILING, Context
from pathlib import Path
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from acf_jax.export.brief import brief
from acf_jax.model import Impact, Rig
from acf_jax.surrogate import CorrectedSurrogate, Surrogate, load_corrected, load_surrogate
from acf_jax.surrogate.box import UNITS
from acf_jax.surrogate.corrected_file import is_corrected

Answers = tuple[Float[Array, ""] | Bool[Array, ""], ...]

BEYOND = 0.1  # of each range: drawn samples leave it by so much

MEANINGS = {
    "m": "moving mass",
    "d": "damping",
    "k_f": "actuator's stiffness",
    "k_c": "contact's stiffness",
    "v_e": "contact velocity",
    "f_p": "pretension",
    "mobility": "inverse mass of a body that recoils",
}


class Quantity(NamedTuple):
    """One input or output."""

    name: str
    unit: str
    meaning: str


class Range(NamedTuple):
    """What a surrogate was trained for; a fixed value where both ends are equal."""

    name: str
    unit: str
    low: float
    high: float


class Formula(NamedTuple):
    """A surrogate as a function of one sample.

    `function` takes the inputs as one vector and returns the outputs, then whether the sample is in the range.
    Outside it every output is infinite: a force that no limit allows.
    """

    inputs: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    ranges: tuple[Range, ...]
    condition: str  # what besides the ranges makes a sample one that the surrogate answers for
    error: str  # what the error bound rests on
    header: str  # of the surrogate's file, JSON
    function: Callable[[Float[Array, " inputs"]], Answers]
    brief: Callable[
        [Float[Array, " inputs"]], Answers
    ]  # the same to 1e-6, by the fewest operations on vectors
    draw: Callable[[np.random.Generator, int], np.ndarray]  # (N, inputs), over the range and a little beyond


def read_formula(path: Path | None) -> Formula:
    """The formula of a model.eqx of either kind; without a path, of the one shipped with acf_jax."""
    if path is not None and is_corrected(path):
        return of_corrected(load_corrected(path)[0])
    return of_paper(load_surrogate(path))


def of_paper(surrogate: Surrogate) -> Formula:
    """Peak force and error bound of a surrogate of the paper's model."""

    def function(x: Float[Array, " 6"]) -> Answers:
        sample = Rig(*x[:4]), Impact(*x[4:])
        return _answers(
            surrogate.is_inside(*sample), surrogate.force(*sample), surrogate.error_bound(*sample)
        )

    box = surrogate.box

    def draw(random: np.random.Generator, count: int) -> np.ndarray:
        low, high = np.array(box.low), np.array(box.high)
        m, zeta, k_f, k_c, v_e, f_p = (low + (high - low) * _shares(random, count, len(UNITS))).T
        d = 2 * zeta * np.sqrt(np.maximum(m * (k_f + k_c), 0.0))
        return np.stack([m, d, k_f, k_c, v_e, f_p], axis=-1)

    units = UNITS | {"d": "N s/m"}
    return Formula(
        inputs=tuple(
            Quantity(name, units[name], MEANINGS[name]) for name in ("m", "d", "k_f", "k_c", "v_e", "f_p")
        ),
        outputs=(
            Quantity("f_max", "N", "peak contact force"),
            Quantity("error_bound", "N", "largest error of f_max among held-out samples"),
        ),
        ranges=tuple(Range(*row) for row in zip(UNITS, UNITS.values(), box.low, box.high, strict=True)),
        condition="zeta = d/(2 sqrt(m (k_f + k_c))), and the force has a first peak",
        error="experience, not proof: the largest error that held-out samples as near to the fold had",
        header=surrogate.header,
        function=function,
        brief=brief(surrogate) or function,
        draw=draw,
    )


def of_corrected(surrogate: CorrectedSurrogate) -> Formula:
    """Peak force, its time and error bound of a surrogate of a corrected model; what is fixed is no input."""
    domain = surrogate.domain
    free = domain.free

    def function(x: Float[Array, " inputs"]) -> Answers:
        values: dict[int, Any] = dict(enumerate(domain.low)) | {i: x[n] for n, i in enumerate(free)}
        found = surrogate.predict(jnp.stack([jnp.asarray(value) for value in values.values()]))
        return _answers(found.is_inside, found.force, found.time, found.error_bound)

    def draw(random: np.random.Generator, count: int) -> np.ndarray:
        return domain.at(_shares(random, count, len(free)))[:, free]

    of = "contact force" if surrogate.which == "contact" else "sensed force"
    return Formula(
        inputs=tuple(
            Quantity(name, domain.units[i], MEANINGS.get(name, "parameter of an effect"))
            for i in free
            for name in [domain.names[i]]
        ),
        outputs=(
            Quantity("f_max", "N", f"peak {of}"),
            Quantity(
                "t_max",
                "s",
                f"its time after contact, wrong by less than {_rounded_up(float(surrogate.bounds.time))} s",
            ),
            Quantity("error_bound", "N", "what errors of f_max stayed below"),
        ),
        ranges=tuple(
            Range(*row) for row in zip(domain.names, domain.units, domain.low, domain.high, strict=True)
        ),
        condition="the force is largest at its first peak",
        error="experience, not proof: held-out samples and a search for the worst one, with a margin",
        header=surrogate.header,
        function=function,
        brief=function,
        draw=draw,
    )


def _rounded_up(bound: float) -> str:
    """Two digits of a bound, which still is one."""
    return f"{Context(prec=2, rounding=ROUND_CEILING).create_decimal(bound):g}"


def _answers(inside: Bool[Array, ""], *values: Float[Array, ""]) -> Answers:
    return *(jnp.where(inside, value, jnp.inf) for value in values), inside


def _shares(random: np.random.Generator, count: int, inputs: int) -> np.ndarray:
    """Points of the unit cube, dense at its faces; every other one of a cube a little larger."""
    shares = np.sin(np.pi / 2 * random.random((count, inputs))) ** 2
    shares[::2] = (1 + BEYOND) * shares[::2] - BEYOND / 2
    return shares
