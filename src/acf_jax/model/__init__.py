"""The paper's model: rig, impact, response and peak force."""

from acf_jax.model.rig import Impact as Impact
from acf_jax.model.rig import Rig as Rig
