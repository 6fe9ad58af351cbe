"""One training run on several devices and hosts, by JAX's own sharding: `docs/scale.md`.

Every process runs the same program. The samples are split evenly over the devices, the network is on each of them,
and what a step needs from elsewhere is exchanged by the collectives that JAX's compiler puts in.
"""

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple, Self, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.experimental import multihost_utils
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from acf_jax.errors import InputError
from acf_jax.model import Impact, Rig
from acf_jax.surrogate.features import AbstractFeatures
from acf_jax.surrogate.surrogate import Affine
from acf_jax.training.config import AnyConfig, Config
from acf_jax.training.data import Labelled, draw, label_samples

AXIS = "samples"
Result = TypeVar("Result")


def join_processes(config: AnyConfig) -> None:
    """Meet the other processes of the run, where the configuration names some; before JAX computes anything."""
    if (processes := config.processes) is None:
        return
    try:
        jax.distributed.initialize(processes.coordinator, processes.count, processes.id)
    except (RuntimeError, ValueError) as error:
        raise InputError(
            f"processes: cannot meet at {processes.coordinator} ({str(error).splitlines()[0]}); start "
            f"{processes.count} processes with ids 0 to {processes.count - 1}, the first on the host of that address"
        ) from None


def is_first() -> bool:
    """Whether this process writes and prints; the others only compute."""
    return jax.process_index() == 0


def find_devices(config: AnyConfig) -> Mesh:
    """The devices of the run, those of process 0 first; `InputError` where the configuration asks too much."""
    faults, found = [], []
    for process in range(jax.process_count()):
        local = jax.local_devices(process_index=process)
        wanted = config.devices or len(local)
        found += local[:wanted]
        if wanted > len(local):
            faults.append(
                f"devices: {wanted} are asked for, but process {process} has {len(local)}; leave `devices` out to use "
                f"all, or on a processor set XLA_FLAGS=--xla_force_host_platform_device_count={wanted}"
            )
    if not faults and (batch := config.optimiser.batch) % len(found):
        faults.append(
            f"optimiser.batch: must be a multiple of the {len(found)} devices, but is {batch}; "
            f"use {max(1, round(batch / len(found))) * len(found)}, or set `devices`"
        )
    if faults:
        raise InputError(faults)
    return Mesh(np.array(found), (AXIS,))


def first_alone(work: Callable[[], Result]) -> Result:
    """`work` on the first process, then on all others, which find what it left."""
    if is_first():
        done = work()
    multihost_utils.sync_global_devices("the first process is ready")
    return done if is_first() else work()


def agree(path: Path, step: int) -> None:
    """`InputError` where the processes do not go on from the same step."""
    steps = multihost_utils.process_allgather(np.array([step]), tiled=True)
    if len(set(steps.tolist())) > 1:
        raise InputError(
            f"{path}: the processes found it at steps {steps.tolist()}; `output` must be a folder that all share"
        )


def _split(mesh: Mesh) -> NamedSharding:
    """A row a device."""
    return NamedSharding(mesh, PartitionSpec(AXIS))


def _ends(total: int, mesh: Mesh) -> list[int]:
    """Where each device's even part of so many samples begins, and where the last one ends."""
    return [total * i // mesh.size for i in range(mesh.size + 1)]


class Shards(NamedTuple):
    """Inputs and targets of training, a row a device; `counts` samples of each row count, the rest fills up."""

    mesh: Mesh
    x: jax.Array  # (devices, samples, inputs)
    y: jax.Array  # (devices, samples), or (devices, samples, outputs)
    counts: np.ndarray  # (devices,)

    @classmethod
    def of(cls, mesh: Mesh, x: np.ndarray, y: np.ndarray) -> Self:
        """Samples (n, inputs) and targets (n, outputs) that every process holds, shared out evenly."""
        ends = np.array(_ends(len(x), mesh))
        rows = np.minimum(ends[:-1, None] + np.arange(np.diff(ends).max()), len(x) - 1)
        split = _split(mesh)

        def share(column: np.ndarray) -> jax.Array:
            by_row = column[rows]
            return jax.make_array_from_callback(by_row.shape, split, lambda here: by_row[here])

        return cls(mesh, share(x), share(y), np.diff(ends))

    @property
    def split(self) -> NamedSharding:
        """How samples lie on the devices."""
        return _split(self.mesh)

    @property
    def everywhere(self) -> NamedSharding:
        """How the network lies on the devices: whole on each."""
        return NamedSharding(self.mesh, PartitionSpec())

    def scales(self) -> tuple[Affine, Affine]:
        """What brings the inputs to -1..1, and the targets to mean 0 and standard deviation 1."""

        @partial(jax.jit, out_shardings=self.everywhere)
        def figures(x: jax.Array, y: jax.Array) -> tuple[jax.Array, ...]:
            counts = jnp.arange(y.shape[1])[None] < self.counts[:, None]
            low = x.min((0, 1), where=counts[..., None], initial=jnp.inf)
            high = x.max((0, 1), where=counts[..., None], initial=-jnp.inf)
            return low, high, y.mean(where=counts), y.std(where=counts)

        low, high, mean, std = (jnp.asarray(np.asarray(value)) for value in figures(self.x, self.y))
        x = Affine((high + low) / 2, jnp.maximum((high - low) / 2, 1e-12))
        return x, Affine(mean, jnp.maximum(std, 1e-12))

    def scaled(self, to_x: Affine, to_y: Affine, dtype: np.dtype) -> Self:
        """The same brought to these scales, in this precision."""
        x = jax.jit(lambda x: jax.vmap(jax.vmap(to_x))(x).astype(dtype))(self.x)
        y = jax.jit(lambda y: jax.vmap(jax.vmap(to_y))(y).astype(dtype))(self.y)
        return self._replace(x=x, y=y)


class TrainingSet(NamedTuple):
    """The samples of training, a row a device, those with a peak first: `counts` of each row."""

    mesh: Mesh
    samples: Labelled  # (devices, samples)
    counts: np.ndarray  # (devices,)
    drawn: int

    def sizes(self) -> dict[str, int]:
        """How many samples have a peak, and how many were set apart."""
        with_peak = int(self.counts.sum())
        return {"with_peak": with_peak, "without_peak": self.drawn - with_peak}

    def shards(self, features: AbstractFeatures) -> Shards:
        """What a network sees and predicts."""
        x = jax.jit(jax.vmap(jax.vmap(features.coordinates)))(self.samples.rig, self.samples.impact)
        y = jax.jit(jax.vmap(jax.vmap(features.target)))(*self.samples)
        return Shards(self.mesh, x, y, self.counts)


def make_training_set(config: Config, mesh: Mesh) -> TrainingSet:
    """Draw the samples of training, and label each on the device that will train on it."""
    total, split = config.samples.train, _split(mesh)
    ends = _ends(total, mesh)
    longest = max(b - a for a, b in pairwise(ends))

    def part(i: int) -> tuple[Rig, Impact, np.ndarray]:
        drawn = draw(config, "train", ends[i], ends[i + 1])
        short = longest - (ends[i + 1] - ends[i])
        filled = jax.tree.map(lambda column: np.pad(column, (0, short), mode="edge"), drawn)
        return *filled, np.arange(longest) < longest - short

    mine = [i for i, device in enumerate(mesh.devices.flat) if device.process_index == jax.process_index()]
    rows = jax.tree.map(lambda *columns: np.stack(columns), *map(part, mine))
    rig, impact, is_drawn = jax.tree.map(partial(jax.make_array_from_process_local_data, split), rows)

    def label(*row: Any) -> tuple[Labelled, jax.Array]:
        """Runs on each device, on its row."""
        rig, impact, is_drawn = jax.tree.map(lambda column: column[0], row)
        peak = label_samples(rig, impact)
        has_peak = peak.has_peak & is_drawn
        first = jnp.argsort(~has_peak, stable=True)
        samples = jax.tree.map(lambda column: column[first][None], Labelled(rig, impact, peak))
        return samples, has_peak.sum()[None]

    on_each = jax.shard_map(label, mesh=mesh, in_specs=split.spec, out_specs=split.spec, check_vma=False)
    samples, counts = jax.jit(on_each)(rig, impact, is_drawn)
    counts = jax.device_put(counts, NamedSharding(mesh, PartitionSpec()))
    return TrainingSet(mesh, samples, np.asarray(counts), total)
