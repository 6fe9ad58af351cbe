"""What a surrogate of a corrected model says of contacts against a wall."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from acf_jax.contact.body import WALL
from acf_jax.contact.peak import Trained
from acf_jax.surrogate.corrected import CorrectedPrediction


def ask(law: Trained, z: np.ndarray) -> tuple[CorrectedPrediction, list[str]]:
    """Peak force, time and error bound of samples z (N, p), and why it does not answer, empty where it does."""
    surrogate = law.surrogate
    q = jax.vmap(lambda z: law.sample(z, WALL))(jnp.asarray(z))
    answers = eqx.filter_jit(type(surrogate).predict)(surrogate, q.T)
    found: CorrectedPrediction = jax.tree.map(np.asarray, answers)
    samples = zip(np.asarray(q), found.is_inside, strict=True)
    return found, ["" if inside else "; ".join(surrogate.domain.faults(sample)) for sample, inside in samples]
