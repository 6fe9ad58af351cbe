"""Labels by simulation, made in blocks that are kept: an interrupted run goes on with the next block."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from acf_jax.contact.body import Body
from acf_jax.contact.peak import Simulated
from acf_jax.errors import InputError
from acf_jax.simulator import LargestForce
from acf_jax.simulator.peak import Force
from acf_jax.surrogate.corrected import Domain
from acf_jax.surrogate.saved import read_header, read_leaves, write_tree
from train.config import CorrectedConfig
from train.data import draw_points
from train.progress import Progress

BLOCK = 8192  # samples of one file
PROGRAM = 1024  # samples that are simulated side by side; one that takes long holds up no more than these


class Block(NamedTuple):
    """What the simulation says of some samples, as NumPy arrays."""

    force: np.ndarray  # (n,) N
    time: np.ndarray  # (n,) s
    exists: np.ndarray  # (n,) bool


Simulator = Callable[[np.ndarray], Block]


class Labels(NamedTuple):
    """Samples with what the simulation says of them."""

    unit: np.ndarray  # (n, inputs) in the unit cube
    q: np.ndarray  # (n, q)
    force: np.ndarray  # (n,) N
    time: np.ndarray  # (n,) s
    exists: np.ndarray  # (n,) bool


def joined_labels(*parts: Labels) -> Labels:
    """Samples one after another."""
    return Labels(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def make_simulator(law: Simulated, which: Force) -> Simulator:
    """Samples q (n, q) to their largest forces."""

    @jax.jit
    def program(q: jax.Array) -> LargestForce:
        return jax.vmap(lambda q: law.largest(q[:-1], Body(0.0, q[-1]), which))(q)

    def part(q: np.ndarray) -> list[np.ndarray]:
        padded = q[np.arange(PROGRAM) % len(q)]
        return [np.asarray(column)[: len(q)] for column in program(jnp.asarray(padded))]

    def simulate(q: np.ndarray) -> Block:
        found = [part(q[i : i + PROGRAM]) for i in range(0, len(q), PROGRAM)]
        return Block(*(np.concatenate(column) for column in zip(*found, strict=True)))

    return simulate


def make_labels(
    config: CorrectedConfig, domain: Domain, simulate: Simulator, purpose: str, identity: dict[str, Any]
) -> Labels:
    """The samples of one purpose; blocks that an earlier session finished are read."""
    unit = draw_points(len(domain.free), config.samples, config.seed, purpose)
    q = domain.at(unit)
    starts = range(0, len(q), BLOCK)
    found = []
    with Progress(f"{purpose} labels", 0, len(starts)) as progress:
        for k, start in enumerate(starts):
            path = config.output / "labels" / f"{purpose}_{k:04d}.eqx"
            part = q[start : start + BLOCK]
            block = _read(path, len(part), identity)
            if block is None:
                block = simulate(part)
                write_tree(path, {"of": identity}, block)
            found.append(block)
            progress.update(k + 1)
    return Labels(unit, q, *(np.concatenate(column) for column in zip(*found, strict=True)))


def _read(path: Path, size: int, identity: dict[str, Any]) -> Block | None:
    """A finished block of the same run, if there is one."""
    if not path.exists():
        return None
    try:
        header, body = read_header(path)
        if header.get("of") != identity:
            return None
        like = Block(np.zeros(size), np.zeros(size), np.zeros(size, bool))
        return read_leaves(path, body, like)
    except InputError:  # cut off or damaged: made again
        return None
