"""Networks for a surrogate of a corrected model: the error of each against its time.

    python -m benchmarks.corrected_frontier --csv docs/figures/corrected_frontier.csv

trains each on the labels of configs/closed_loop.yaml, bounds it as `train.fit` does, and times it in a batch, in turn
with the fastest simulation within 0.1 % of `benchmarks.corrected_speed`. `python -m docs.figures.corrected_frontier`
draws it.
"""

import argparse
import csv
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from acf_jax.contact.model_file import ModelFile
from acf_jax.contact.peak import Simulated
from acf_jax.start import start_jax
from acf_jax.surrogate import CorrectedSurrogate
from acf_jax.surrogate.load import with_dtype
from acf_jax.training.config import CorrectedConfig, read_config
from acf_jax.training.corrected import run
from benchmarks.corrected_speed import _blocked, _in_columns, _lean, _own
from benchmarks.machine import cores, describe
from benchmarks.peers.jax_peak import on_all_cores
from benchmarks.timing import interleave, median_ratio

ROOT = Path(__file__).resolve().parents[1]
STEPS = 40_000
# activation, width, depth, steps of training
NETWORKS = (
    ("tanh", 16, 2, 10_000),  # the former default
    *(
        (activation, width, depth, STEPS)
        for activation in ("tanh", "softsign")
        for width, depth in ((16, 1), (8, 2), (12, 2), (16, 2))
    ),
)
ANGLE = 0.3  # omega h of the fastest simulation within 0.1 %, as `benchmarks.corrected_speed` found it
BLOCK = 1024


def main(argv: Sequence[str] | None = None) -> None:
    """Train, time and tell each network."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.corrected_frontier", description=__doc__.splitlines()[0]
    )
    parser.add_argument(
        "--runs", type=Path, default=Path("artifacts/frontier"), help="what is trained is kept here"
    )
    parser.add_argument("--samples", type=int, default=32_768, help="impacts of a batch (default: 32768)")
    parser.add_argument("--repeats", type=int, default=25, help="rounds in turn (default: 25)")
    parser.add_argument("--csv", type=Path, help="write the rows to this file, too")
    arguments = parser.parse_args(argv)
    jax.config.update("jax_num_cpu_devices", cores())  # before start_jax asks for the devices
    start_jax()
    files = [_trained(arguments.runs, *network) for network in NETWORKS]
    rows = _measured(files, arguments.samples, arguments.repeats)
    print(f"{arguments.samples:,} impacts in a batch; {describe()}\n")
    print("| network | steps | largest error | bound | × simulation, float64 | float32 |")
    print("|---|--:|--:|--:|--:|--:|")
    for (activation, width, depth, steps), row in zip(NETWORKS, rows, strict=True):
        print(
            f"| {activation} {width} × {depth} | {steps:,} | {row['error']:.1e} | {row['bound']:.1e} |"
            f" {row['float64']:.1f} | {row['float32']:.1f} |"
        )
    if arguments.csv:
        with arguments.csv.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["activation", "width", "depth", "steps", *rows[0]])
            writer.writerows(
                [*network, *(f"{value:.3g}" for value in row.values())]
                for network, row in zip(NETWORKS, rows, strict=True)
            )


def _trained(runs: Path, activation: str, width: int, depth: int, steps: int) -> Path:
    """The model.eqx of a network, trained unless it is there."""
    folder = runs / f"{activation}_{width}_{depth}_{steps}"
    if not (folder / "model.eqx").exists():
        changes = {
            "output": folder,
            "labels.model": ROOT / "examples/rig_model.json",
            "network": f"{{width: {width}, depth: {depth}, activation: {activation}}}",
            "optimiser.steps": steps,
        }
        config = read_config(
            ROOT / "configs/closed_loop.yaml", tuple(f"{key}={value}" for key, value in changes.items())
        )
        assert isinstance(config, CorrectedConfig)
        run(config, resume=False, say=lambda text: None)
    return folder / "model.eqx"


def _measured(files: Sequence[Path], samples: int, repeats: int) -> list[dict[str, float]]:
    """Largest error, bound, and how many times faster than the simulation, of each file."""
    calls: dict[str, Callable[[], Any]] = {}
    found = []
    for i, file in enumerate(files):
        model, surrogate = ModelFile(file).load_exact()
        assert surrogate is not None
        law, domain = model.main.peak, surrogate.domain
        assert isinstance(law, Simulated)
        q = domain.at(np.random.default_rng(0).random((samples, len(domain.free))))
        if not i:
            calls["simulation"] = on_all_cores(_blocked(partial(_lean, law.effects, ANGLE), BLOCK), q)
            exact = np.concatenate(on_all_cores(_blocked(partial(_own, law), BLOCK), q)())
        force = np.asarray(surrogate(jnp.asarray(q.T))[0])
        found.append(
            {"error": float(np.abs(force / exact - 1).max()), "bound": float(surrogate.bounds.force)}
        )
        for dtype in (jnp.float64, jnp.float32):
            calls[f"{i} {np.dtype(dtype).name}"] = on_all_cores(
                _in_columns(partial(_force, with_dtype(surrogate, dtype)), BLOCK), q.astype(dtype)
            )
    seconds = interleave(calls, repeats)
    for i, row in enumerate(found):
        for name in ("float64", "float32"):
            row[name] = median_ratio(seconds["simulation"], seconds[f"{i} {name}"])
    return found


def _force(surrogate: CorrectedSurrogate, q: jax.Array) -> jax.Array:
    return surrogate(q)[0]


if __name__ == "__main__":
    main()
