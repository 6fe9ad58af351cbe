"""Diagnosing the gap between the paper's model and measured impacts."""

from acf_jax.diagnosis.diagnose import Diagnosis as Diagnosis
from acf_jax.diagnosis.diagnose import diagnose as diagnose
from acf_jax.diagnosis.plan import plan as plan
from acf_jax.gap_model import GapModel as GapModel
from acf_jax.gap_model import read_model as read_model
from acf_jax.predict import Prediction as Prediction
from acf_jax.predict import predict as predict
