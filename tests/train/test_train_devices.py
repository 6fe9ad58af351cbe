"""One device, eight devices and two processes: the same samples, and the same network within rounding."""

import json
import os
import socket
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import equinox as eqx
import jax
import numpy as np
import pytest

from acf_jax.surrogate import load_surrogate
from acf_jax.training.config import read_config
from acf_jax.training.data import draw_samples
from train import fit

REPOSITORY = Path(__file__).parents[2]
TRAIN = ("-m", "train.fit")
CHANGES = (
    "compare=[]",
    "precision=float64",
    "optimiser.steps=30",
    "optimiser.steps_per_checkpoint=15",
    "samples.train=1024",  # all sets of one size share their compiled programs
    "samples.held_out=1024",
    "samples.test=1024",
    "table1=null",
)


def arguments(config: Path, folder: Path, *changes: str) -> list[str]:
    found = ["--config", str(config)]
    for change in (*CHANGES, f"output={folder}", *changes):
        found += ["--set", change]
    return found


def start(devices: int, *command: str, cwd: Path = REPOSITORY) -> subprocess.Popen[str]:
    """Python in a process of its own that has so many devices."""
    environment = {
        **os.environ,
        "XLA_FLAGS": f"{os.environ.get('XLA_FLAGS', '')} --xla_force_host_platform_device_count={devices}",
        "PYTHONPATH": os.pathsep.join([str(REPOSITORY / "src"), str(REPOSITORY)]),
    }
    return subprocess.Popen(
        [sys.executable, *command],
        cwd=cwd, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip


def arrays(path: Path) -> list[jax.Array]:
    """Weights, scales and bounds of a surrogate."""
    return jax.tree.leaves(eqx.filter(load_surrogate(path), eqx.is_array))


def free_port() -> int:
    with socket.socket() as there:
        there.bind(("127.0.0.1", 0))
        return int(there.getsockname()[1])


@pytest.mark.long
def test_many_devices_and_processes_train_what_one_trains(small: Path, tmp_path: Path) -> None:
    """Eight devices in one process; and two processes of two devices, which meet over loopback."""
    alone, eight, two = (tmp_path / name for name in ("alone", "eight", "two"))
    meet = [f"processes.coordinator=127.0.0.1:{free_port()}", "processes.count=2"]
    started = [start(8, *TRAIN, *arguments(small, eight))]
    started += [start(2, *TRAIN, *arguments(small, two, *meet, f"processes.id={k}")) for k in (0, 1)]
    assert fit.main(arguments(small, alone, "devices=1")) == 0
    printed = [process.communicate()[0] for process in started]
    assert [process.returncode for process in started] == [0, 0, 0], "\n".join(printed)
    assert "report:" in printed[1] and "fold" not in printed[2], "only the first process speaks"

    expected = json.loads((alone / "metrics.json").read_text())
    weights = arrays(alone / "model.eqx")
    for folder in (eight, two):
        found = json.loads((folder / "metrics.json").read_text())
        assert found["samples"] == expected["samples"]
        np.testing.assert_allclose(found["losses"]["fold"], expected["losses"]["fold"], rtol=1e-9)
        for ours, theirs in zip(weights, arrays(folder / "model.eqx"), strict=True):
            np.testing.assert_allclose(theirs, ours, rtol=1e-8, atol=1e-12)


SHARED_OUT = """
import jax, numpy as np
jax.config.update("jax_enable_x64", True)
from jax.sharding import Mesh
from pathlib import Path
from acf_jax.surrogate.load import Shape
from acf_jax.training.config import Optimiser
from acf_jax.training.devices import AXIS, Shards
from acf_jax.training.loop import fit_network

x = np.random.default_rng(0).uniform(-1, 1, (1003, 3))  # no multiple of the devices
y = np.stack([x[:, 0] * x[:, 1], np.where(x[:, 2] > 0, x[:, 2], np.nan)], axis=1)
settings = Optimiser(learning_rate=1e-2, warm_up_steps=5, steps=40, batch=128, steps_per_checkpoint=20)
weights = []
for n in (1, 8):
    shards = Shards.of(Mesh(np.array(jax.devices()[:n]), (AXIS,)), x, y)
    assert shards.x.sharding.num_devices == n and shards.counts.sum() == len(x)
    network, _ = fit_network("n", shards, Shape(width=8, depth=2), settings, 0, Path(f"{n}.eqx"), {}, False)
    weights.append([np.asarray(leaf) for leaf in jax.tree.leaves(network) if hasattr(leaf, "shape")])
for one, eight in zip(*weights, strict=True):
    np.testing.assert_allclose(eight, one, rtol=1e-9, atol=1e-13)
"""


@pytest.mark.long
def test_samples_that_each_process_holds_are_shared_out(tmp_path: Path) -> None:
    """As those of a corrected model: several outputs, some of them missing."""
    process = start(8, "-c", SHARED_OUT, cwd=tmp_path)
    printed, _ = process.communicate()
    assert process.returncode == 0, printed


@pytest.mark.parametrize("method", ["sobol", "latin_hypercube"])
@pytest.mark.parametrize("ends", [(0, 1, 700, 1000), (0, 512, 1000)])
def test_a_design_is_the_same_in_parts(small: Path, method: str, ends: tuple[int, ...]) -> None:
    ranges = read_config(small).ranges
    whole = draw_samples(ranges, 1000, method, 5, True)
    parts = [draw_samples(ranges, 1000, method, 5, True, *span) for span in pairwise(ends)]
    joined = jax.tree.map(lambda *columns: np.concatenate(columns), *parts)
    jax.tree.map(np.testing.assert_array_equal, joined, whole)


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        (["devices=64"], "devices: 64 are asked for, but process 0 has"),
        (["processes.coordinator=host"], "processes.coordinator: must match pattern"),
        (
            ["processes.coordinator=host:1", "processes.count=2", "processes.id=2"],
            "processes: id (2) must be below count (2); the first process has id 0",
        ),
    ],
)
def test_faults_are_named(
    small: Path, tmp_path: Path, changes: list[str], fault: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert fit.main(arguments(small, tmp_path / "run", *changes)) == 2
    assert fault in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
