"""The paper's model: rig, impact, response and peak force."""

from acf_jax.model.peak import Peak as Peak
from acf_jax.model.peak import find_peak as find_peak
from acf_jax.model.peak import find_peaks as find_peaks
from acf_jax.model.response import contact_force as contact_force
from acf_jax.model.response import contact_force_curvature as contact_force_curvature
from acf_jax.model.response import contact_force_rate as contact_force_rate
from acf_jax.model.response import position as position
from acf_jax.model.response import velocity as velocity
from acf_jax.model.rig import Impact as Impact
from acf_jax.model.rig import Rig as Rig
