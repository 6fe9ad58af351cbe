"""Labels by simulation, made in blocks that are kept, here or by many processes: an interrupted run goes on."""

import sys
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
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
from acf_jax.training.config import CorrectedConfig
from acf_jax.training.data import draw_points
from acf_jax.training.progress import progress
from acf_jax.workers import Where, run_all

BLOCK = 8192  # samples of one file
PURPOSES = ("train", "held_out", "held_out_edges", "test", "test_edges")
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


@cache  # a process compiles it once
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


class Piece(NamedTuple):
    """What a process has to know for a block."""

    law: Simulated
    which: Force
    q: np.ndarray


def label(piece: Piece) -> Block:
    """The block of a piece, in whatever process."""
    return make_simulator(piece.law, piece.which)(piece.q)


def make_labels(
    config: CorrectedConfig, domain: Domain, law: Simulated, identity: dict[str, Any]
) -> dict[str, Labels]:
    """The samples of every purpose; blocks of the same identity that an earlier session finished are read."""
    units = {p: draw_points(len(domain.free), config.samples, config.seed, p) for p in PURPOSES}
    points = {purpose: domain.at(unit) for purpose, unit in units.items()}
    parts = {
        purpose: {
            config.output / "labels" / f"{purpose}_{k:04d}.eqx": Piece(law, config.labels.force, part)
            for k, part in enumerate(np.split(q, range(BLOCK, len(q), BLOCK)))
        }
        for purpose, q in points.items()
    }
    pieces = {path: piece for own in parts.values() for path, piece in own.items()}
    found = {path: block for path, p in pieces.items() if (block := _read(path, len(p.q), identity))}
    missing = [(path, piece) for path, piece in pieces.items() if path not in found]
    for stale in set((config.output / "labels").glob("*.eqx")) - set(pieces):
        stale.unlink(missing_ok=True)
    with progress("labels", len(found), len(pieces)) as told:
        for path, block in _labelled(missing, config):
            write_tree(path, {"of": identity}, block)
            found[path] = block
            told(len(found))
    labels = {}
    for purpose, own in parts.items():
        columns = (np.concatenate(column) for column in zip(*(found[path] for path in own), strict=True))
        labels[purpose] = Labels(units[purpose], points[purpose], *columns)
    return labels


def _labelled(pieces: Sequence[tuple[Path, Piece]], config: CorrectedConfig) -> Iterator[tuple[Path, Block]]:
    """The blocks of pieces, in the order of finishing."""
    asked = config.labels
    if asked.scheduler is None and asked.workers == 1:
        yield from ((path, label(piece)) for path, piece in pieces)
        return
    say = partial(print, file=sys.stderr)
    again = "--resume goes on where it was"
    where = Where(asked.scheduler, asked.workers, say, "labels.scheduler", again)
    for path, outcome in run_all(label, pieces, where):
        if isinstance(outcome, Exception):
            raise InputError(f"{path}: failed ({type(outcome).__name__}: {outcome}); {again}")
        yield path, outcome


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
