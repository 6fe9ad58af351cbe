"""A trained stand-in for the peak force: load it, ask for force, gradient and error bound."""

from acf_jax.surrogate.corrected import CorrectedSurrogate as CorrectedSurrogate
from acf_jax.surrogate.corrected_file import load_corrected as load_corrected
from acf_jax.surrogate.load import load_surrogate as load_surrogate
from acf_jax.surrogate.load import save_surrogate as save_surrogate
from acf_jax.surrogate.surrogate import Prediction as Prediction
from acf_jax.surrogate.surrogate import Surrogate as Surrogate
