"""Train a surrogate of the peak force: `python -m train.fit --config configs/table1.yaml`.

Read it from top to bottom: configuration, data, training, error on fresh samples, files, report. The
same configuration and seed give the same metrics.json, interrupted and resumed or not.
"""

import argparse
import sys
import time
from collections.abc import Sequence
from contextlib import nullcontext, redirect_stdout
from pathlib import Path
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np

import acf_jax
from acf_jax.cli._ending import end_well, resumable
from acf_jax.cli._json import echo_json
from acf_jax.errors import InputError
from acf_jax.start import start_jax
from acf_jax.surrogate import Surrogate, load_surrogate, save_surrogate
from acf_jax.surrogate.box import UNITS, Box
from acf_jax.surrogate.features import FEATURES, AbstractFeatures
from acf_jax.surrogate.load import with_dtype
from acf_jax.surrogate.surrogate import HeldOutError
from train import corrected, evaluate
from train.checkpoint import FOLDER, begin
from train.config import Config, read_config
from train.data import PURPOSES, Labelled, make_data
from train.devices import TrainingSet, find_devices, is_first, join_processes, make_training_set
from train.loop import Diverged, fit_network
from train.report import write_report
from train.results import write_results
from train.versions import versions


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

    def work() -> int:
        config = read_config(arguments.config, tuple(arguments.set))
        join_processes(config)
        start_jax()  # labels are float64, whatever the network's precision
        words = redirect_stdout(sys.stderr) if arguments.json else nullcontext()
        try:
            with resumable("--resume goes on from the last checkpoint"), words:
                if isinstance(config, Config):
                    metrics = run(config, arguments.resume)
                else:
                    metrics = corrected.run(config, arguments.resume)
        except Diverged as error:
            print(f"error: {error}", file=sys.stderr)
            return 1
        if arguments.json and is_first():
            echo_json(metrics)
        return 0

    return end_well(work)


def run(config: Config, resume: bool = False) -> dict[str, Any]:
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
        print(f"{kept:,} samples with a peak to train on, {apart:,} without set apart")

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

    write_results(config, metrics, timings)
    write_report(folder / "report.html", config, metrics, timings)
    print(evaluate.summary(metrics))
    print(f"report: {folder / 'report.html'}")
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


if __name__ == "__main__":
    sys.exit(main())
