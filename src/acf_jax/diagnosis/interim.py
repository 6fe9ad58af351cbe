"""What a diagnosis knows before it is done, for who watches it. None of it is the answer."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from threading import Lock
from typing import Any

import numpy as np

from acf_jax.dataset import Quality
from acf_jax.diagnosis.heldout import figures, hold_out
from acf_jax.evidence.marginal import Marginal, marginal
from acf_jax.inference.fit import Fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import Explanation

Watch = Callable[[Mapping[str, Any]], None]


class Interim:
    """Tells a watcher each part as soon as it is known; a part that is told again replaces the one before.

    `trust`: whether the data can be trusted, and what limits them. `gap`: of the paper's model with nominal and with
    refitted parameters, to the trials themselves. `log_evidence`: explanations weighed so far, the best first, over the
    paper's model with refitted parameters; there is no probability before all are weighed.
    """

    def __init__(self, watch: Watch | None):
        self._watch, self._lock = watch, Lock()  # fits end in several threads
        self._log_z: dict[Explanation, float] = {}

    def trust(self, quality: Quality, excluded: Mapping[str, str]) -> None:
        """What the data are."""
        if self._watch:
            found = quality.trust(excluded)
            self._watch({"trust": {"headline": found.headline, "limits": found.lines}})

    def gap(self, observations: Observations, peaks: np.ndarray, nominal: Fit, recalibrated: Fit) -> None:
        """Where the paper's model stands; `peaks`: (trials,) N, as measured."""
        if self._watch:
            fits = {"nominal": nominal, "recalibrated": recalibrated}
            held = {n: hold_out(observations, f, peaks, recalibrated, refit=False) for n, f in fits.items()}
            self._watch({"gap": {name: asdict(figures(observations, h)) for name, h in held.items()}})

    def fitted(self, fits: Iterable[Fit]) -> None:
        """Fits whose evidence is not known yet."""
        if self._watch:
            self.weighed([marginal(f) for f in fits if np.isfinite(f.objective)])

    def weighed(self, marginals: Iterable[Marginal]) -> None:
        """Evidence, of which the best beside any discrepancy counts."""
        if self._watch is None:
            return
        with self._lock:
            for found in marginals:
                known = self._log_z.get(found.explanation, -np.inf)
                self._log_z[found.explanation] = max(known, found.log_z)
            if () in self._log_z:
                ranked = sorted(self._log_z.items(), key=lambda item: -item[1])
                over = [{"effects": name, "value": round(z - self._log_z[()], 2)} for name, z in ranked]
                self._watch({"log_evidence": over})

    def anew(self) -> None:
        """Forget the evidence: the noise, or the trials, are others now."""
        self._log_z.clear()
