"""Halley's method, kept inside a bracket, for optimistix; and the peak's root by it.

Apart from `crossing`, since optimistix takes as long to import as a peak to compute.
"""

from collections.abc import Callable
from typing import Any, cast

import equinox as eqx
import jax.numpy as jnp
import optimistix as optx
from jaxtyping import Array, Bool, Float, PyTree, Scalar

from acf_jax.model.crossing import (
    MAX_STEPS,
    Crossing,
    first_step,
    half_the_digits,
    halley_step,
    next_step,
    residual,
)

Residual = Callable[[Scalar, PyTree], tuple[Scalar, tuple[Scalar, Scalar]]]


class _HalleyState(eqx.Module):
    step: Float[Array, ""]


class Halley(optx.AbstractRootFinder[Scalar, Scalar, Any, _HalleyState]):
    """Bracketed Halley iteration for a scalar root: each step cubes the error.

    `fn(y, args)` returns f and, as its auxiliary output, (f', f''): an analytic pair costs next to
    nothing where f solves a differential equation. `options` holds the bracket `lower`, `upper`, and may hold
    `step`, the size of a step that has led to the first y: where that is right already, no other is made.

    It stops when the *next* step must be below `atol + rtol (upper - lower)`, so that no evaluation is
    spent on seeing that the last step changed nothing.
    """

    rtol: float
    atol: float
    norm: Callable[[PyTree], Scalar] = optx.max_norm

    def init(
        self,
        fn: Residual,
        y: Scalar,
        args: PyTree,
        options: dict[str, Any],
        f_struct: PyTree,
        aux_struct: PyTree,
        tags: frozenset[object],
    ) -> _HalleyState:
        return _HalleyState(options.get("step", jnp.full_like(y, jnp.inf)))

    def step(
        self,
        fn: Residual,
        y: Scalar,
        args: PyTree,
        options: dict[str, Any],
        state: _HalleyState,
        tags: frozenset[object],
    ) -> tuple[Scalar, _HalleyState, Any]:
        f, (slope, curvature) = fn(y, args)
        new_y = halley_step(y, (f, slope, curvature), options["lower"], options["upper"])
        return new_y, _HalleyState(jnp.abs(new_y - y)), (slope, curvature)

    def terminate(
        self,
        fn: Residual,
        y: Scalar,
        args: PyTree,
        options: dict[str, Any],
        state: _HalleyState,
        tags: frozenset[object],
    ) -> tuple[Bool[Array, ""], optx.RESULTS]:
        width = options["upper"] - options["lower"]
        stop = next_step(state.step, width) < self.atol + self.rtol * width
        return stop, cast(optx.RESULTS, optx.RESULTS.successful)

    def postprocess(
        self,
        fn: Residual,
        y: Scalar,
        aux: Any,
        args: PyTree,
        options: dict[str, Any],
        state: _HalleyState,
        tags: frozenset[object],
        result: optx.RESULTS,
    ) -> tuple[Scalar, Any, dict[str, Any]]:
        return y, aux, {}


def find_crossing(crossing: Crossing) -> Scalar:
    """sigma to half the digits, by optimistix."""
    y, step = first_step(crossing)
    return optx.root_find(
        residual,  # type: ignore[arg-type]  # optimistix types the auxiliary output as Never
        Halley(rtol=half_the_digits(crossing), atol=0.0),
        y,
        args=crossing,
        options={"lower": jnp.zeros_like(crossing.sigma_m), "upper": crossing.sigma_m, "step": step},
        has_aux=True,
        max_steps=MAX_STEPS,
        throw=False,
    ).value
