"""Halley's method, kept inside a bracket, for optimistix."""

from collections.abc import Callable
from typing import Any, cast

import equinox as eqx
import jax.numpy as jnp
import optimistix as optx
from jaxtyping import Array, Bool, Float, PyTree, Scalar

# f, f' and f'' at a point
Derivatives = tuple[Scalar, Scalar, Scalar]
Residual = Callable[[Scalar, PyTree], tuple[Scalar, tuple[Scalar, Scalar]]]


def halley_step(y: Scalar, derivatives: Derivatives, lower: Scalar, upper: Scalar) -> Scalar:
    """y - 2 f f'/(2 f'^2 - f f''), moved back into [lower, upper]; y itself where the step has no meaning."""
    f, slope, curvature = derivatives
    denominator = slope * slope - f * curvature / 2
    sound = denominator > 0
    step = f * slope / jnp.where(sound, denominator, 1.0)
    return jnp.clip(jnp.where(sound, y - step, y), lower, upper)


def next_step(step: Scalar, width: Scalar) -> Scalar:
    """The size expected of the step after `step`: its cube, in units of the bracket's width."""
    return step * (step / width) ** 2


class _HalleyState(eqx.Module):
    step: Float[Array, ""]


class Halley(optx.AbstractRootFinder[Scalar, Scalar, Any, _HalleyState]):
    """Bracketed Halley iteration for a scalar root: each step cubes the error.

    `fn(y, args)` returns f and, as its auxiliary output, (f', f''): an analytic pair costs next to
    nothing where f solves a differential equation. `options` holds the bracket `lower`, `upper`.

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
        return _HalleyState(jnp.full_like(y, jnp.inf))

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
