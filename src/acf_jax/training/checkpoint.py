"""The state of a training run between two chunks of steps."""

import shutil
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from acf_jax.errors import InputError
from acf_jax.surrogate.saved import read_header, read_leaves, write_tree
from acf_jax.training.config import AnyConfig
from acf_jax.training.results import write_config

FOLDER = "checkpoints"  # of a run's folder


class State(NamedTuple):
    """All that the next step depends on; the batch of step n is drawn from the seed and n alone."""

    parameters: Any
    optimiser: Any
    step: int
    losses: list[float]  # mean of each chunk


def save_state(path: Path, state: State, identity: dict[str, Any]) -> None:
    """Write the state, with what it depends on; the file on disk is whole at any moment."""
    header = {"config": identity, "step": state.step, "losses": state.losses}
    write_tree(path, header, (state.parameters, state.optimiser))


def begin(config: AnyConfig, resume: bool) -> None:
    """Make the run's folder this configuration's: of an earlier run no checkpoint is left, unless it is resumed."""
    if not resume:
        shutil.rmtree(config.output / FOLDER, ignore_errors=True)
    if not resume or not (config.output / FOLDER).exists():
        write_config(config)


def read_state(path: Path, identity: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
    """Header and body of a checkpoint.

    **Raises:** `InputError` when the file belongs to another configuration, or is damaged.
    """
    header, body = read_header(path)
    if header.get("config") != identity:
        raise InputError(
            f"{path}: was written with another configuration; resume with that one, "
            f"{path.parents[1] / 'config.yaml'}, or start afresh without --resume"
        )
    return header, body


def load_state(path: Path, like: State, identity: dict[str, Any]) -> State:
    """The state at `path`, or `like`, the initial one, where there is none; `InputError` as in `read_state`."""
    if not path.exists():
        return like
    header, body = read_state(path, identity)
    trees = read_leaves(path, body, (like.parameters, like.optimiser))
    return State(*trees, step=header["step"], losses=header["losses"])


def is_finite(state: State) -> bool:
    """Whether every number of the state is finite."""
    leaves = jax.tree.leaves((state.parameters, state.optimiser, state.losses))
    return all(bool(np.isfinite(leaf).all()) for leaf in leaves)
