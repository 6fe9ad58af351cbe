"""The training loop: one network, its checkpoints, and what stops it."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax

from acf_jax.surrogate.load import Shape, new_network
from acf_jax.training.checkpoint import State, is_finite, load_state, save_state
from acf_jax.training.config import Optimiser
from acf_jax.training.devices import Shards, agree, is_first
from acf_jax.training.progress import progress


class Diverged(RuntimeError):
    """The loss is not finite; the last good checkpoint is kept."""


def fit_network(
    name: str,
    shards: Shards,
    shape: Shape,
    settings: Optimiser,
    seed: int,
    path: Path,
    identity: dict[str, Any],
    resume: bool,
) -> tuple[eqx.nn.MLP, list[float]]:
    """A network fitted to scaled samples, and the mean loss of each chunk of steps.

    **Arguments:** `shards`: scaled samples. `path`: of the checkpoint, from which it goes on where there is one and
    `resume` says so. `identity`: what the state depends on.

    **Raises:** `Diverged`; `InputError` where the checkpoint has another identity.
    """
    network_key, batch_key = jax.random.split(jax.random.key(seed))
    outputs: int | Literal["scalar"] = "scalar" if shards.y.ndim == 2 else shards.y.shape[-1]
    network = new_network(shards.x.shape[-1], shape, shards.x.dtype, network_key, outputs)
    parameters, static = eqx.partition(network, eqx.is_inexact_array)
    optimiser = optax.adam(
        optax.warmup_cosine_decay_schedule(
            0.0,
            settings.learning_rate,
            settings.warm_up_steps,
            settings.steps,
            settings.learning_rate * settings.final_fraction,
        )
    )
    run_steps = make_steps(static, optimiser, shards, settings.batch, batch_key)
    state = State(parameters, optimiser.init(parameters), 0, [])
    if resume:
        state = load_state(path, state, identity)
        agree(path, state.step)
    with progress(name, state.step, settings.steps) as told:
        while state.step < settings.steps:
            count = min(settings.steps_per_checkpoint, settings.steps - state.step)
            stepped = run_steps(state.parameters, state.optimiser, state.step, count)
            parameters, memory, mean = jax.tree.map(np.asarray, stepped)
            new = State(parameters, memory, state.step + count, [*state.losses, float(mean)])
            if not is_finite(new):
                kept = (
                    f"the state of step {state.step} is kept in {path}" if state.step else "nothing is kept"
                )
                raise Diverged(
                    f"{name}: the loss is not finite between steps {state.step} and {new.step}; "
                    f"{kept}. Lower optimiser.learning_rate (now {settings.learning_rate:g}) or raise "
                    "optimiser.warm_up_steps"
                )
            state = new
            if is_first():
                save_state(path, state, identity)
                told(state.step, state.losses[-1])
    return eqx.combine(jax.tree.map(jnp.asarray, state.parameters), static), state.losses


def make_steps(
    static: Any,
    optimiser: optax.GradientTransformation,
    shards: Shards,
    batch: int,
    key: jax.Array,
) -> Callable[[Any, Any, int, int], tuple[Any, Any, jax.Array]]:
    """(parameters, optimiser's memory, first step, count) to both after `count` steps and their mean loss.

    The batch of a step is drawn from the key and the step's number alone, so that a resumed run draws
    what an uninterrupted one would have drawn, and many devices what one would have. Each device then has an
    equal share of the batch. NaN in a target is no target.
    """
    ends = np.cumsum(shards.counts)
    starts = ends - shards.counts

    def loss(parameters: Any, x: jax.Array, y: jax.Array) -> jax.Array:
        # The batch is the last axis: each layer is then one matrix product without a transposition.
        predicted = jax.vmap(eqx.combine(parameters, static), in_axes=1)(x.T)
        return jnp.mean(jnp.where(jnp.isnan(y), 0.0, predicted - y) ** 2)

    def one_step(
        x: jax.Array, y: jax.Array, carry: tuple[Any, Any], step: jax.Array
    ) -> tuple[tuple[Any, Any], jax.Array]:
        parameters, memory = carry
        rows = jax.random.randint(jax.random.fold_in(key, step), (batch,), 0, ends[-1])
        device = jnp.searchsorted(ends, rows, side="right")
        place = (device, rows - jnp.asarray(starts)[device])
        drawn = jax.lax.with_sharding_constraint((x[place], y[place]), shards.split)
        value, slope = jax.value_and_grad(loss)(parameters, *drawn)
        updates, memory = optimiser.update(slope, memory, parameters)
        return (optax.apply_updates(parameters, updates), memory), value

    @partial(jax.jit, static_argnames="count", out_shardings=shards.everywhere)
    def run_steps(
        parameters: Any, memory: Any, first: int, x: jax.Array, y: jax.Array, *, count: int
    ) -> tuple[Any, Any, jax.Array]:
        carry, losses = jax.lax.scan(partial(one_step, x, y), (parameters, memory), first + jnp.arange(count))
        return *carry, losses.mean()

    return lambda parameters, memory, first, count: run_steps(
        parameters, memory, first, shards.x, shards.y, count=count
    )
