"""Train a surrogate of the peak force: `python -m train.fit --config configs/table1.yaml`.

Read it from top to bottom: configuration, data, training, error on fresh samples, files, report. The
same configuration and seed give the same metrics.json, interrupted and resumed or not.
"""

import argparse
import json
import platform
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext, redirect_stdout
from functools import partial
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax

import acf_jax
from acf_jax.cli._ending import end_well, resumable
from acf_jax.cli._json import echo_json
from acf_jax.files import write_text
from acf_jax.surrogate import Surrogate, load_surrogate, save_surrogate
from acf_jax.surrogate.box import UNITS, Box
from acf_jax.surrogate.features import FEATURES, AbstractFeatures
from acf_jax.surrogate.load import new_network, with_dtype
from acf_jax.surrogate.surrogate import Affine, HeldOutError
from train import evaluate
from train.checkpoint import State, is_finite, load_state, save_state
from train.config import Config, read_config, to_yaml
from train.data import Labelled, make_data
from train.progress import Progress
from train.report import write_report


class Diverged(RuntimeError):
    """The loss is not finite; the last good checkpoint is kept."""


def main(argv: Sequence[str] | None = None) -> int:
    """Train as the configuration says; the exit code is 1 for a loss that diverges, else as every command's."""
    about = __doc__.split("\n")[0]
    parser = argparse.ArgumentParser(prog="python -m train.fit", description=about, allow_abbrev=False)
    parser.add_argument("--config", type=Path, required=True, help="YAML file, such as configs/table1.yaml")
    parser.add_argument("--resume", action="store_true", help="go on from the run's last checkpoint")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="change one key: optimiser.steps=1000"
    )
    parser.add_argument("--json", action="store_true", help="print JSON: metrics.json")
    parser.add_argument("--version", action="version", version=f"%(prog)s, version {acf_jax.__version__}")
    arguments = parser.parse_args(argv)
    jax.config.update("jax_enable_x64", True)  # labels are float64, whatever the network's precision

    def work() -> int:
        config = read_config(arguments.config, tuple(arguments.set))
        words = redirect_stdout(sys.stderr) if arguments.json else nullcontext()
        try:
            with resumable("--resume goes on from the last checkpoint"), words:
                metrics = run(config, arguments.resume)
        except Diverged as error:
            print(f"error: {error}", file=sys.stderr)
            return 1
        if arguments.json:
            echo_json(metrics)
        return 0

    return end_well(work)


def run(config: Config, resume: bool = False) -> dict[str, Any]:
    """Train and judge every feature set of the configuration; returns what metrics.json holds."""
    folder, timings, clock = config.output, {}, time.perf_counter
    start = clock()
    data = {purpose: make_data(config, purpose) for purpose in ("train", "held_out", "held_out_edges")}
    timings["data_s"] = clock() - start
    train = data["train"]
    kept, apart = train.sizes().values()
    print(f"{kept:,} samples with a peak to train on, {apart:,} without set apart")

    surrogates, histories = {}, {}
    for name in config.all_features:
        start = clock()
        network, histories[name] = train_network(config, FEATURES[name], train, resume)
        timings[f"train_{name}_s"] = clock() - start
        surrogates[name] = bound_error(network, data["held_out"], data["held_out_edges"])

    start = clock()
    test = {"box": make_data(config, "test"), "edges": make_data(config, "test_edges")}
    metrics = evaluate.judge(config, {k: with_dtype(s, float) for k, s in surrogates.items()}, train, test)
    metrics["losses"] = histories
    metrics["versions"] = versions()
    best = metrics["errors"][config.features]
    more = {"config": config.model_dump(mode="json"), "versions": metrics["versions"], "errors": best}
    save_surrogate(folder / "model.eqx", surrogates[config.features], config.network, more)
    metrics["table1"] = evaluate.table1(config, load_surrogate(folder / "model.eqx"))
    timings["evaluate_s"] = clock() - start

    write_text(folder / "config.yaml", to_yaml(config))
    write_text(folder / "metrics.json", json.dumps(metrics, indent=1, allow_nan=False) + "\n")
    write_text(folder / "timings.json", json.dumps(timings, indent=1) + "\n")
    write_report(folder / "report.html", config, metrics, timings)
    print(evaluate.summary(metrics))
    print(f"report: {folder / 'report.html'}")
    return metrics


def train_network(
    config: Config, features: AbstractFeatures, data: Labelled, resume: bool
) -> tuple[Surrogate, list[float]]:
    """A surrogate fitted to the data, its error still unknown, and the mean loss of each chunk of steps."""
    settings, dtype = config.optimiser, np.dtype(config.precision)
    x = jax.jit(jax.vmap(features.coordinates))(data.rig, data.impact)[data.has_peak]
    y = jax.jit(jax.vmap(features.target))(data.rig, data.impact, data.peak)[data.has_peak]
    to_x = Affine((x.max(0) + x.min(0)) / 2, jnp.maximum((x.max(0) - x.min(0)) / 2, 1e-12))
    to_y = Affine(y.mean(), jnp.maximum(y.std(), 1e-12))
    x, y = jax.vmap(to_x)(x).astype(dtype), to_y(y).astype(dtype)

    network_key, batch_key = jax.random.split(jax.random.key(config.seed))
    network = new_network(x.shape[1], config.network, dtype, network_key)
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
    run_steps = make_steps(static, optimiser, x, y, settings.batch, batch_key)

    path = config.output / "checkpoints" / f"{features.name}.eqx"
    if not resume:
        path.unlink(missing_ok=True)
    state = load_state(path, State(parameters, optimiser.init(parameters), 0, []), config)
    with Progress(features.name, state.step, settings.steps) as progress:
        while state.step < settings.steps:
            count = min(settings.steps_per_checkpoint, settings.steps - state.step)
            parameters, memory, mean = run_steps(state.parameters, state.optimiser, state.step, count)
            new = State(parameters, memory, state.step + count, [*state.losses, float(mean)])
            if not is_finite(new):
                kept = (
                    f"the state of step {state.step} is kept in {path}" if state.step else "nothing is kept"
                )
                raise Diverged(
                    f"{features.name}: the loss is not finite between steps {state.step} and {new.step}; "
                    f"{kept}. Lower optimiser.learning_rate (now {settings.learning_rate:g}) or raise "
                    "optimiser.warm_up_steps"
                )
            state = new
            save_state(path, state, config)
            progress.update(state.step, state.losses[-1])

    box = Box(
        tuple(getattr(config.ranges, name).low for name in UNITS),
        tuple(getattr(config.ranges, name).high for name in UNITS),
    )
    edges = jnp.linspace(0, 1, evaluate.BOUND_BINS + 1)[1:]
    surrogate = Surrogate(
        network=eqx.combine(state.parameters, static),
        x=to_x,
        y=to_y,
        held_out=HeldOutError(edges, jnp.zeros_like(edges)),
        features=features,
        box=box,
    )
    return with_dtype(surrogate, dtype), state.losses


def make_steps(
    static: Any,
    optimiser: optax.GradientTransformation,
    x: jax.Array,
    y: jax.Array,
    batch: int,
    key: jax.Array,
) -> Callable[[Any, Any, int, int], tuple[Any, Any, jax.Array]]:
    """(parameters, optimiser's memory, first step, count) to both after `count` steps and their mean loss.

    The batch of a step is drawn from the key and the step's number alone, so that a resumed run draws
    what an uninterrupted one would have drawn.
    """

    def loss(parameters: Any, x: jax.Array, y: jax.Array) -> jax.Array:
        # The batch is the last axis: each layer is then one matrix product without a transposition.
        predicted = jax.vmap(eqx.combine(parameters, static), in_axes=1)(x.T)
        return jnp.mean((predicted - y) ** 2)

    def one_step(carry: tuple[Any, Any], step: jax.Array) -> tuple[tuple[Any, Any], jax.Array]:
        parameters, memory = carry
        rows = jax.random.randint(jax.random.fold_in(key, step), (batch,), 0, x.shape[0])
        value, slope = jax.value_and_grad(loss)(parameters, x[rows], y[rows])
        updates, memory = optimiser.update(slope, memory, parameters)
        return (optax.apply_updates(parameters, updates), memory), value

    @partial(jax.jit, static_argnames="count")
    def run_steps(parameters: Any, memory: Any, first: int, count: int) -> tuple[Any, Any, jax.Array]:
        carry, losses = jax.lax.scan(one_step, (parameters, memory), first + jnp.arange(count))
        return *carry, losses.mean()

    return run_steps


def bound_error(surrogate: Surrogate, *held_out: Labelled) -> Surrogate:
    """The surrogate with the largest relative errors seen on held-out samples, by distance from the fold."""
    largest = np.zeros(evaluate.BOUND_BINS)
    for data in held_out:
        answers = evaluate.ask(with_dtype(surrogate, float), data)
        bins = np.searchsorted(np.asarray(surrogate.held_out.edges), answers.u).clip(0, largest.size - 1)
        np.maximum.at(largest, bins, np.abs(answers.error))
    # A sample is never given a smaller bound than those farther from the fold than itself.
    largest = np.maximum.accumulate(largest[::-1])[::-1]
    dtype = surrogate.x.scale.dtype
    rounded_up = jnp.asarray(np.nextafter(largest.astype(dtype), np.inf, dtype=dtype))
    return eqx.tree_at(lambda s: s.held_out.largest, surrogate, rounded_up)


def versions() -> dict[str, str]:
    """What a run depends on besides its configuration."""
    packages = {"acf-jax": acf_jax, "jax": jax, "equinox": eqx, "optax": optax, "numpy": np}
    return {"python": platform.python_version()} | {name: p.__version__ for name, p in packages.items()}


if __name__ == "__main__":
    sys.exit(main())
