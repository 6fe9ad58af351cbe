"""The state of a training run between two chunks of steps."""

from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from acf_jax.errors import InputError
from acf_jax.surrogate.saved import read_header, read_leaves, write_tree


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


def load_state(path: Path, like: State, identity: dict[str, Any]) -> State:
    """The state at `path`, or `like`, the initial one, where there is none.

    **Raises:** `InputError` when the file belongs to another configuration, or is damaged.
    """
    if not path.exists():
        return like
    header, body = read_header(path)
    if header.get("config") != identity:
        raise InputError(
            f"{path}: was written with another configuration; resume with that one (config.yaml beside it), "
            "or start afresh without --resume"
        )
    trees = read_leaves(path, body, (like.parameters, like.optimiser))
    return State(*trees, step=header["step"], losses=header["losses"])


def is_finite(state: State) -> bool:
    """Whether every number of the state is finite."""
    leaves = jax.tree.leaves((state.parameters, state.optimiser, state.losses))
    return all(bool(np.isfinite(leaf).all()) for leaf in leaves)
