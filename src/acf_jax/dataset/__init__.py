"""Gap data sets: reading them, and judging their quality before anything is fitted."""

from acf_jax.dataset.look import TrialQuality as TrialQuality
from acf_jax.dataset.look import assess as assess
from acf_jax.dataset.noise import Approach as Approach
from acf_jax.dataset.noise import Noise as Noise
from acf_jax.dataset.phase import ImpactPhase as ImpactPhase
from acf_jax.dataset.quality import Quality as Quality
from acf_jax.dataset.quality import assess_dataset as assess_dataset
from acf_jax.dataset.read import data_sets as data_sets
from acf_jax.dataset.read import read_conditions as read_conditions
from acf_jax.dataset.read import read_dataset as read_dataset
from acf_jax.dataset.trials import GapDataset as GapDataset
from acf_jax.dataset.trials import LowPass as LowPass
from acf_jax.dataset.trials import Measurement as Measurement
from acf_jax.dataset.trials import Prior as Prior
from acf_jax.dataset.trials import RigPrior as RigPrior
from acf_jax.dataset.trials import RobotVelocity as RobotVelocity
from acf_jax.dataset.trials import Trace as Trace
from acf_jax.dataset.trials import Trial as Trial
