"""A diagnosis to read, to ask and to keep."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import plotly.graph_objects as go

from acf_jax import diagnosis as library
from acf_jax.api._values import begin, folder_of, not_numbers, plain
from acf_jax.api.dataset import DataSet, read_dataset
from acf_jax.api.model import Answering, Model
from acf_jax.api.recording import Recording
from acf_jax.api.rig import prior_of
from acf_jax.api.source import Source, of_gap
from acf_jax.dataset import GapDataset, LowPass
from acf_jax.dataset.low_pass import APPLIED_ORDER
from acf_jax.dataset.trials import RigPrior
from acf_jax.diagnosis.document import document
from acf_jax.diagnosis.results import gap_model
from acf_jax.errors import InputError, shown
from acf_jax.provenance import Origin
from acf_jax.report import composition, evidence, peaks, save_diagnosis, told, traces, where
from acf_jax.report.markup import Html, element, join
from acf_jax.report.notebook import to_plotly
from acf_jax.report.outlook import Outlook, outlook
from acf_jax.report.parameters import parameter_table
from acf_jax.report.plot import Drawn

Progress = Callable[[str], None]


@dataclass(frozen=True, repr=False)
class Diagnosis(library.Diagnosis, Answering):
    """What a diagnosis found, with its corrected model to ask.

    `peak`, `speed`, `design`, `check` and `train` are those of a `Model`.
    """

    @classmethod
    def of(cls, found: library.Diagnosis) -> Self:
        """The library's diagnosis."""
        return cls(**{field.name: getattr(found, field.name) for field in fields(library.Diagnosis)})

    @cached_property
    def model(self) -> Model:
        """The model that the diagnosis leaves: the corrected one, unless it is known to be no better."""
        return Model(of_gap(gap_model(self), f"the diagnosis of {self.dataset.folder}"))

    @property
    def source(self) -> Source:
        """The law behind the answers."""
        return self.model.source

    @cached_property
    def _outlook(self) -> Outlook:
        return outlook(self)

    def document(self) -> dict[str, Any]:
        """The diagnosis as plain numbers and texts: diagnosis.json."""
        return document(self)

    def save(self, folder: str | Path) -> Path:
        """Write the files of the command `diagnose` into a folder, all or none; the path of the report."""
        made_of = {str(self.dataset.folder): self.dataset.digest}
        save_diagnosis(folder_of(folder), self, Origin("acf_jax.diagnose(...).save(...)", made_of))
        return folder_of(folder) / "report.html"

    def plot(self, what: str | None = None) -> go.Figure:
        """A figure of the report.

        **Arguments:** `what`: `force`, measured and predicted, with a choice of trial; `peaks` over contact velocity;
        `explanations` with their probabilities; `made_of`, what the gap is made of; `where` it lies. By default the
        first of them that the data have.

        **Raises:** `InputError` for another word, and for a figure that these data do not have.
        """
        drawings: dict[str, Callable[[], Html | None]] = {
            "force": lambda: traces.overlay(self, self._outlook),
            "peaks": lambda: peaks.over_velocity(self, self._outlook),
            "explanations": lambda: evidence.probabilities(self.document()),
            "made_of": lambda: composition.bars(self),
            "where": lambda: where.gap_map(self),
        }
        if what is not None and what not in drawings:
            raise InputError(f"plot: {shown(what)} is no figure; known are {', '.join(drawings)}")
        found = (drawing() for name, drawing in drawings.items() if what in (None, name))
        drawn = next((figure for figure in found if isinstance(figure, Drawn)), None)
        if drawn is None:
            raise InputError(f"plot: these data have no figure {shown(what)}; record force traces")
        return to_plotly(drawn)

    def __repr__(self) -> str:
        return told(self)

    def _repr_html_(self) -> str:
        lines = [element("p", line) for line in told(self).splitlines()]
        return join([*lines, evidence.in_words(self), parameter_table(self)])


def diagnose(
    data: Recording | GapDataset | str | Path,
    rig: RigPrior | str | Path | None = None,
    *,
    without: Collection[str] = (),
    seed: int = 0,
    low_pass: float | None = None,
    progress: Progress = lambda stage: None,
) -> Diagnosis:
    """Where the gap between the paper's model and measured impacts lies, what causes it, and how far it shrinks.

    It takes about half a minute, several minutes for rigs with many small effects.

    **Arguments:** `data`: a `Recording`, a `DataSet`, or the folder of a data set. `rig`: what is known of the rig, an
    `acf_jax.Prior` or a rig's file; a recording needs it here or in `read_recording`, a data set brings its own, which
    this replaces. `without`: effects that cannot be the cause, and components that the rig does not have ("robot",
    ...). `seed`: of the bootstrap. `low_pass`: cutoff, Hz, of a filter for data and model alike, to leave out what is
    faster, such as a ring. `progress`: called with the name of each stage, such as `print`.

    **Returns:** `Diagnosis`.

    **Raises:** `InputError` where the rig is missing, where no data set can come of a recording, where fewer than three
    trials can be used, and where the filter cannot be applied.

    >>> import acf_jax as acf
    >>> d = acf.diagnose("examples/rig")  # doctest: +SKIP
    >>> d.speed(f_p=60, limit=140)  # doctest: +SKIP
    """
    begin()
    seed = plain(seed)
    if not isinstance(seed, int) or seed < 0:
        raise InputError(f"seed: must be a whole number, 0 or above, but is {shown(seed)}; correct it")
    low_pass = plain(low_pass)
    if faults := not_numbers({}, {"low_pass": low_pass}):
        raise InputError(faults)
    band = None if low_pass is None else LowPass(low_pass, APPLIED_ORDER)
    dataset = _data_set(data, rig)
    try:
        return Diagnosis.of(library.diagnose(dataset, seed, progress, without, band))
    except ValueError as error:
        raise InputError(str(error).splitlines()) from None


def _data_set(data: Any, rig: Any) -> GapDataset:
    if isinstance(data, Recording):
        return data.dataset(rig)
    if not isinstance(data, GapDataset):
        data = read_dataset(data)
    if rig is None:
        return data
    own = {field.name: getattr(data, field.name) for field in fields(GapDataset)}
    return DataSet(**own | {"rig": prior_of(rig)})
