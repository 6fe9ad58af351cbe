"""A data set of impacts to look at."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Self

import numpy as np
import plotly.graph_objects as go

from acf_jax import dataset as library
from acf_jax.api._values import path_of
from acf_jax.api.rig import prior_words
from acf_jax.dataset import GapDataset, Trial
from acf_jax.errors import InputError
from acf_jax.report.markup import element, join, table
from acf_jax.report.notebook import to_plotly
from acf_jax.report.plot import Variant, axis, plain, plot, series
from acf_jax.report.words import condition


@dataclass(frozen=True, repr=False)
class DataSet(GapDataset):
    """Impacts of one rig and what is known of it: a `GapDataset` that shows itself."""

    @classmethod
    def of(cls, data: GapDataset, folder: Path | None = None) -> Self:
        """The same data set; `folder`: where messages say that it comes from."""
        held = {field.name: getattr(data, field.name) for field in fields(GapDataset)}
        return cls(**held | ({} if folder is None else {"folder": folder}))

    def plot(self) -> go.Figure:
        """Every trace over the time since contact, with a choice of condition.

        **Raises:** `InputError` for a data set without traces.
        """
        groups = [[self.trials[i] for i in members] for members in self.conditions.values()]
        variants = [
            Variant(condition(*group[0].condition), [_trace(trial) for trial in group if trial.trace])
            for group in groups
            if any(trial.trace for trial in group)
        ]
        if not variants:
            raise InputError(f"{self.folder}: holds peaks only; there is no trace to draw")
        layout = {"xaxis": axis("time since contact / ms"), "yaxis": axis("sensed force / N")}
        return to_plotly(plot("traces", "Sensed force", "", variants, layout, 420, "Condition"))

    def __repr__(self) -> str:
        trials, groups = self.trials, self.conditions
        traced = sum(trial.trace is not None for trial in trials)
        v_e, f_p = zip(*groups, strict=True)
        return "\n".join(
            [
                f"DataSet {self.folder}: {len(trials)} trials at {len(groups)} conditions, {traced} with a trace",
                f"  contact velocity {_range(v_e, 'm/s')}, pretension {_range(f_p, 'N')}",
                f"  known before: {prior_words(self.rig)}",
            ]
        )

    def _repr_html_(self) -> str:
        rows = [
            (
                condition(*at),
                f"{len(members)}",
                ", ".join(self.trials[i].name for i in members),
                _range([_peak(self.trials[i]) for i in members], "N"),
            )
            for at, members in self.conditions.items()
        ]
        head = ("Condition", "Trials", "Names", "Largest reading")
        words = [element("p", line) for line in repr(self).splitlines()]
        return join([*words, table(self.description or "Conditions", head, rows)])


def read_dataset(folder: str | Path) -> DataSet:
    """Read a data set of impacts: dataset.yaml, trials.csv and the files listed there (docs/data_format.md).

    **Arguments:** `folder`: as `python -m acf_jax import` writes it, or made by hand.

    **Returns:** `DataSet`.

    **Raises:** `InputError` that lists every fault with file, row or key, and remedy.

    >>> import acf_jax as acf
    >>> acf.read_dataset("examples/rig")
    DataSet examples/rig: 16 trials at 8 conditions, 16 with a trace
      contact velocity 0.05 to 0.35 m/s, pretension 50 to 90 N
      known before: m=1.74762 ± 0.0348 kg, d=72.004 ± 16.7 N s/m, k_f=3962.58 ± 1440 N/m, k_c=112184 ± 12000 N/m
    """
    return DataSet.of(library.read_dataset(path_of(folder)))


def _trace(trial: Trial) -> dict[str, object]:
    assert trial.trace is not None
    time, force = series(1e3 * trial.trace.time, 6), series(trial.trace.force)
    return {"x": time, "y": force, "mode": "lines", "name": plain(trial.name)}


def _peak(trial: Trial) -> float:
    if trial.trace is None:
        return np.nan if trial.peak_force is None else trial.peak_force
    return float(trial.trace.force.max())


def _range(values: Sequence[float], unit: str) -> str:
    known = [v for v in values if np.isfinite(v)]
    if not known:
        return "none"
    low, high = f"{min(known):.4g}", f"{max(known):.4g}"
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"
