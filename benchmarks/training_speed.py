"""Training steps per second: the loop of train.fit against the same network in PyTorch.

    python -m benchmarks.training_speed [--config configs/wide_box.yaml]

Same multilayer perceptron, batch, optimiser, schedule, precision, data size and number of threads, in one
run, interleaved. PyTorch is tuned: the fastest of eager and compiled, and of one thread and all, counts.
"""

import argparse
import os
from collections.abc import Callable, Sequence
from pathlib import Path

# OpenMP threads that spin after a PyTorch step would take the cores from JAX.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")

import equinox as eqx
import jax
import numpy as np
import optax
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from acf_jax.surrogate.features import FEATURES
from acf_jax.surrogate.load import new_network
from acf_jax.training.config import Config, read_config
from acf_jax.training.devices import AXIS, Shards
from acf_jax.training.loop import make_steps
from benchmarks.machine import cores, describe
from benchmarks.timing import interleave, median_ratio, summarise

SAMPLES = 2**18


def main(argv: Sequence[str] | None = None) -> None:
    """Print steps per second of each peer, and the ratio to the fastest PyTorch."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.training_speed")
    parser.add_argument("--config", type=Path, default=Path("configs/wide_box.yaml"))
    parser.add_argument("--steps", type=int, default=1000, help="training steps of one timing")
    parser.add_argument("--repeats", type=int, default=7)
    arguments = parser.parse_args(argv)
    jax.config.update("jax_enable_x64", True)  # as train.fit does
    config = read_config(arguments.config)
    assert isinstance(config, Config), "the comparison is about the analytic model's surrogate"
    random = np.random.default_rng(0)
    inputs = len(FEATURES[config.features].inputs)
    x = random.uniform(-1, 1, (SAMPLES, inputs)).astype(config.precision)
    y = np.sin(x.sum(axis=1))

    calls = {"train.fit (JAX)": _jax(config, x, y, arguments.steps)} | _torch(config, x, y, arguments.steps)
    seconds = interleave(calls, arguments.repeats)

    width, depth = config.network.width, config.network.depth
    print(describe())
    print(
        f"MLP {inputs}-{'-'.join([str(width)] * depth)}-1, {config.network.activation}, {config.precision}, "
        f"batch {config.optimiser.batch}, Adam with cosine schedule, {SAMPLES:,} samples, {cores()} threads"
    )
    for name, times in seconds.items():
        timing = summarise(times)
        low, median, high = (arguments.steps / t for t in (timing.high, timing.median, timing.low))
        print(f"{name:<36} {median:7,.0f} steps/s  ({low:,.0f} to {high:,.0f})")
    ours, *theirs = seconds
    best = min(theirs, key=lambda name: summarise(seconds[name]).median)
    print(f"ratio to the fastest PyTorch ({best}): {median_ratio(seconds[best], seconds[ours]):.2f}")


def _jax(config: Config, x: np.ndarray, y: np.ndarray, steps: int) -> Callable[[], object]:
    settings = config.optimiser
    optimiser = optax.adam(optax.cosine_decay_schedule(settings.learning_rate, settings.steps))
    network = new_network(x.shape[1], config.network, x.dtype, jax.random.key(0))
    parameters, static = eqx.partition(network, eqx.is_inexact_array)
    mesh = Mesh(np.array(jax.devices()[:1]), (AXIS,))
    here = jax.device_put((x[None], y[None]), NamedSharding(mesh, PartitionSpec(AXIS)))
    shards = Shards(mesh, here[0], here[1], np.array([y.size]))
    run_steps = make_steps(static, optimiser, shards, settings.batch, jax.random.key(1))
    memory = optimiser.init(parameters)
    return lambda: jax.block_until_ready(run_steps(parameters, memory, 0, steps))


def _torch(config: Config, x: np.ndarray, y: np.ndarray, steps: int) -> dict[str, Callable[[], object]]:
    import torch

    settings, inputs, samples = config.optimiser, torch.from_numpy(x), torch.from_numpy(y)
    activation = {
        "tanh": torch.nn.Tanh,
        "silu": torch.nn.SiLU,
        "gelu": torch.nn.GELU,
        "softplus": torch.nn.Softplus,
    }[config.network.activation]

    def peer(threads: int, compiled: bool) -> Callable[[], object]:
        torch.manual_seed(0)
        layers: list[torch.nn.Module] = []
        for i in range(config.network.depth):
            layers += [torch.nn.Linear(x.shape[1] if i == 0 else config.network.width, config.network.width)]
            layers += [activation()]
        network = torch.nn.Sequential(*layers, torch.nn.Linear(config.network.width, 1)).to(inputs.dtype)
        optimiser = torch.optim.Adam(network.parameters(), settings.learning_rate, fused=True)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, settings.steps)

        def loss(rows: torch.Tensor) -> torch.Tensor:
            return torch.mean((network(inputs[rows])[:, 0] - samples[rows]) ** 2)

        value = torch.compile(loss) if compiled else loss

        def call() -> None:
            torch.set_num_threads(threads)
            for rows in torch.randint(0, len(x), (steps, settings.batch)):
                optimiser.zero_grad(set_to_none=True)
                value(rows).backward()
                optimiser.step()
                schedule.step()

        return call

    peers = {}
    for threads in sorted({1, cores()}):
        for compiled in (False, True):
            name = f"PyTorch, {'compiled' if compiled else 'eager'}, {threads} thread{'s' * (threads > 1)}"
            call = peer(threads, compiled)
            try:
                call()
            except Exception as error:  # no C++ compiler here, or one that torch.compile cannot use
                print(f"{name}: left out ({type(error).__name__})")
                continue
            peers[name] = call
    return peers


if __name__ == "__main__":
    main()
