"""One training run, of whichever model its configuration names."""

from typing import Any

from acf_jax.provenance import Origin
from acf_jax.training import corrected, paper
from acf_jax.training.config import AnyConfig, Config
from acf_jax.training.progress import Say


def run(
    config: AnyConfig, resume: bool = False, say: Say = print, origin: Origin | None = None
) -> dict[str, Any]:
    """Train, judge and write the run's folder, `config.output`.

    **Arguments:** `resume`: go on from the folder's last checkpoint. `say`: told what was done, in lines of text.
        `origin`: how the run came about, which its report and provenance.json say.

    **Returns:** what metrics.json holds.

    **Raises:** `InputError` for a configuration that cannot be trained, `Diverged` for a loss that is not finite.
    """
    if isinstance(config, Config):
        return paper.run(config, resume, say, origin)
    return corrected.run(config, resume, say, origin)
