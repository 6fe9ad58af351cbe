"""The configuration of a surrogate of a diagnosis for one who writes none, much as configs/closed_loop.yaml."""

from collections.abc import Mapping
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

from acf_jax.contact.model import ContactModel
from acf_jax.contact.peak import Simulated
from acf_jax.contact.read import of_diagnosis
from acf_jax.forms import check_form
from acf_jax.gap_model import GapModel
from acf_jax.surrogate.corrected import is_first_peak
from acf_jax.training.config import CorrectedConfig, Samples
from acf_jax.training.data import draw_points
from acf_jax.training.domain import MOBILITY, make_domain
from acf_jax.training.labels import PROGRAM, make_simulator

SAMPLES, STEPS = 32768, 40_000
BATCH, CHUNK, WARM_UP = (
    1024,
    1000,
    500,
)  # samples a step, steps between checkpoints, steps to the highest learning rate
DEVIATIONS = (5.0, 4.0, 3.0, 2.0, 1.0)  # half the range of a fitted parameter, the first that will do
LEARNT = 0.9  # of the impacts have their largest force at the first peak, which is what is learnt
SHARE = 0.25  # of the samples of training, that set the bound, and that tell the error


def default_config(
    gap: GapModel,
    model: Path,
    output: Path,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    samples: int = SAMPLES,
    steps: int = STEPS,
    seed: int = 0,
) -> CorrectedConfig:
    """The configuration of a run on the model that a diagnosis left.

    A fitted parameter is learnt over as many standard deviations as leave the first peak the largest force in most
    impacts; what lies outside is simulated, so that a narrower range costs time and nothing else.

    **Arguments:** `model`: where the run will find it, as a model.json. `output`: folder of the run. `ranges`: lowest
    and highest value, SI units, of what shall not keep the range that follows from the trials and the fit. `samples`:
    of training. `steps`: of the optimiser.

    **Raises:** `InputError` that lists every fault; `TooLittleData` where the diagnosis could not answer.
    """
    corrected = of_diagnosis(gap, source=str(model))
    corrected.check_carried()
    units = dict(zip((*corrected.names, MOBILITY[0]), (*corrected.units, MOBILITY[1]), strict=True))
    spans = {
        name: {"low": low, "high": high, "unit": units.get(name, "")}
        for name, (low, high) in (ranges or {}).items()
    }
    few = max(int(SHARE * samples), 1024) if isinstance(samples, int) else 1024
    content = {
        "output": str(output),
        "seed": seed,
        "labels": {"model": str(model)},
        "ranges": spans,
        "samples": {"train": samples, "held_out": few, "test": few},
        # by docs/figures/corrected_frontier.svg, with units to spare for models with more effects than its one
        "network": {"width": 12, "depth": 2, "activation": "softsign"},
        "optimiser": {
            "learning_rate": 5e-3,
            "warm_up_steps": min(WARM_UP, steps // 10) if isinstance(steps, int) else WARM_UP,
            "steps": steps,
            "batch": BATCH,
            "steps_per_checkpoint": CHUNK,
        },
    }
    return _working(check_form(CorrectedConfig, content, "train"), corrected)


def _working(config: CorrectedConfig, model: ContactModel) -> CorrectedConfig:
    """The configuration with the most standard deviations that leave something to learn, one at least."""
    law = model.main.peak
    assert isinstance(law, Simulated)
    for deviations in DEVIATIONS:
        labels = config.labels.model_copy(update={"deviations": deviations})
        tried = config.model_copy(update={"labels": labels})
        domain = make_domain(tried, model, law)
        q = domain.at(draw_points(len(domain.free), Samples(train=PROGRAM), config.seed, "train"))
        found = make_simulator(law, labels.force)(q)
        first = jax.vmap(is_first_peak)(*map(jnp.asarray, (q, found.time, found.exists)))
        if np.mean(first) >= LEARNT:
            break
    return tried
