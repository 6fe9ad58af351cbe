"""Train a surrogate of the peak force of the paper's model.

Read it from top to bottom: data, training, error on fresh samples, files, report. The same configuration and seed give
the same metrics.json, interrupted and resumed or not.
"""

import time
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from acf_jax.errors import InputError
from acf_jax.provenance import Origin
from acf_jax.surrogate import Surrogate, load_surrogate, save_surrogate
from acf_jax.surrogate.box import UNITS, Box
from acf_jax.surrogate.features import FEATURES, AbstractFeatures
from acf_jax.surrogate.load import with_dtype
from acf_jax.surrogate.surrogate import HeldOutError
from acf_jax.training import evaluate
from acf_jax.training.checkpoint import FOLDER, begin
from acf_jax.training.config import Config
from acf_jax.training.data import PURPOSES, Labelled, make_data
from acf_jax.training.devices import TrainingSet, find_devices, is_first, make_training_set
from acf_jax.training.loop import fit_network
from acf_jax.training.progress import Say
from acf_jax.training.report import write_report
from acf_jax.training.results import write_results
from acf_jax.training.versions import versions


def run(config: Config, resume: bool, say: Say, origin: Origin | None = None) -> dict[str, Any]:
    """Train and judge every feature set of the configuration; returns what metrics.json holds."""
    folder, timings, clock = config.output, {}, time.perf_counter
    start = clock()
    train = make_training_set(config, find_devices(config))
    data = {purpose: make_data(config, purpose) for purpose in PURPOSES[1:]}
    if faults := evaluate.too_few({"train": train.sizes()} | {p: d.sizes() for p, d in data.items()}):
        raise InputError(faults)
    if is_first():
        begin(config, resume)
    timings["data_s"] = clock() - start
    if is_first():
        kept, apart = train.sizes().values()
        say(f"{kept:,} samples with a peak to train on, {apart:,} without set apart")

    surrogates, histories = {}, {}
    for name in config.all_features:
        start = clock()
        network, histories[name] = train_network(config, FEATURES[name], train, resume)
        timings[f"train_{name}_s"] = clock() - start
        surrogates[name] = bound_error(network, data["held_out"], data["held_out_edges"])

    start = clock()
    test = {"box": data["test"], "edges": data["test_edges"]}
    metrics = evaluate.judge(
        config, {k: with_dtype(s, float) for k, s in surrogates.items()}, train.sizes(), test
    )
    metrics["losses"] = histories
    metrics["versions"] = versions()
    best = metrics["errors"][config.features]
    more = {"config": config.model_dump(mode="json"), "versions": metrics["versions"], "errors": best}
    if not is_first():
        return metrics
    save_surrogate(folder / "model.eqx", surrogates[config.features], config.network, more)
    metrics["table1"] = evaluate.table1(config, load_surrogate(folder / "model.eqx"))
    timings["evaluate_s"] = clock() - start

    write_results(config, metrics, timings, origin)
    write_report(folder / "report.html", config, metrics, timings, origin)
    say(evaluate.summary(metrics))
    say(f"report: {folder / 'report.html'}")
    return metrics


def train_network(
    config: Config, features: AbstractFeatures, data: TrainingSet, resume: bool
) -> tuple[Surrogate, list[float]]:
    """A surrogate fitted to the data, its error still unknown, and the mean loss of each chunk of steps."""
    dtype = np.dtype(config.precision)
    shards = data.shards(features)
    to_x, to_y = shards.scales()
    shards = shards.scaled(to_x, to_y, dtype)

    path = config.output / FOLDER / f"{features.name}.eqx"
    network, losses = fit_network(
        features.name, shards, config.network, config.optimiser, config.seed, path, config.identity(), resume
    )
    box = Box(
        tuple(getattr(config.ranges, name).low for name in UNITS),
        tuple(getattr(config.ranges, name).high for name in UNITS),
    )
    edges = jnp.linspace(0, 1, evaluate.BOUND_BINS + 1)[1:]
    surrogate = Surrogate(
        network=network,
        x=to_x,
        y=to_y,
        held_out=HeldOutError(edges, jnp.zeros_like(edges)),
        features=features,
        box=box,
    )
    return with_dtype(surrogate, dtype), losses


def bound_error(surrogate: Surrogate, *held_out: Labelled) -> Surrogate:
    """The surrogate with the largest errors on held-out samples, shares of its force, by distance from the fold."""
    largest = np.zeros(evaluate.BOUND_BINS)
    for data in held_out:
        answers = evaluate.ask(with_dtype(surrogate, float), data)
        bins = np.searchsorted(np.asarray(surrogate.held_out.edges), answers.u).clip(0, largest.size - 1)
        np.maximum.at(largest, bins, np.abs(evaluate.of_answer(answers.error)))
    # A sample is never given a smaller bound than those farther from the fold than itself.
    largest = np.maximum.accumulate(largest[::-1])[::-1]
    dtype = surrogate.x.scale.dtype
    rounded_up = jnp.asarray(np.nextafter(largest.astype(dtype), np.inf, dtype=dtype))
    return eqx.tree_at(lambda s: s.held_out.largest, surrogate, rounded_up)
