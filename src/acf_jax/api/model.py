"""A model of the peak contact force, and what can be asked of it."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from acf_jax.api import contact, design, forces, speed
from acf_jax.api._values import begin, path_of, warn
from acf_jax.api.rig import short
from acf_jax.api.source import ModelLike, Source, source_of
from acf_jax.api.training import export_c, trained_on
from acf_jax.contact.peak import Simulated
from acf_jax.errors import InputError
from acf_jax.files import write_bytes
from acf_jax.report.markup import element, join, table
from acf_jax.report.words import headed, name_of
from acf_jax.surrogate import Surrogate
from acf_jax.surrogate import load_surrogate as load_of_paper
from acf_jax.surrogate.corrected_file import is_corrected
from acf_jax.training.default import SAMPLES, STEPS
from acf_jax.training.progress import Say


def train(
    model: ModelLike,
    out: str | Path | None = None,
    *,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    samples: int = SAMPLES,
    steps: int = STEPS,
    seed: int = 0,
    resume: bool = False,
    say: Say = lambda text: None,
) -> "Model":
    """A surrogate of a diagnosis' corrected model: a small network with a bound on its error, for controllers.

    It learns the peak contact force over contact velocity and pretension as the trials covered them, and over every
    fitted parameter by five standard deviations to either side. With the defaults it takes about a minute.

    **Arguments:** `model`: a diagnosis, or the path of one. `out`: folder for the run's files, its report among them;
    by default they are not kept. `ranges`: other ranges (low, high), by name in SI units, such as `{"k_c": (4e4,
    9e4)}`. `samples`: simulated impacts to learn from. `steps`: of the optimiser. `seed`: of samples, weights and
    batches. `resume`: go on from the last checkpoint in `out`. `say`: called with lines about the run, such as
    `print`.

    **Returns:** `Model`, which answers by the surrogate; `save` and `export_c` write it.

    **Raises:** `InputError` that names each range that cannot be; `acf_jax.training.loop.Diverged` for a loss that is
    not finite; `TooLittleData`, an `InputError`, where the diagnosis could not answer. **Warns** where it left doubts.

    >>> import acf_jax as acf
    >>> net = acf.train("examples/rig_model.json")  # doctest: +SKIP
    >>> net.export_c("peak.h")  # doctest: +SKIP
    """
    source = source_of(model)
    source.exact.check_carried()
    warn(filter(None, [source.exact.doubt]))
    return Model(trained_on(source, out, ranges, samples, steps, seed, resume, say))


class Answering:
    """The questions that every model answers; each is a function of this package with the model in front."""

    peak = forces.peak
    speed = speed.speed
    design = design.design
    check = contact.check
    train = train

    @property
    def source(self) -> Source:
        """The law behind the answers."""
        raise NotImplementedError


class Model(Answering):
    """A law of the peak contact force and what is known of it, as `read_model`, `train` and a diagnosis give it."""

    def __init__(self, source: Source):
        self._source = source

    @property
    def source(self) -> Source:
        """The law behind the answers."""
        return self._source

    def export_c(self, path: str | Path) -> Path:
        """Write the surrogate as a C99 header: `acf_jax.export_c` with the model behind the path."""
        return export_c(path, self)

    def save(self, path: str | Path) -> Path:
        """Write the surrogate as a model.eqx, which the commands and `load_surrogate` take.

        **Raises:** `InputError` for a model without a surrogate, and for a path that does not end in `.eqx`.
        """
        target = path_of(path)
        if not self.source.stored:
            raise InputError("save: the model holds no surrogate; train one first, as in model.train()")
        if target.suffix != ".eqx":
            raise InputError(f"{target}: must end in .eqx; rename it")
        write_bytes(target, self.source.stored)
        return target

    def __repr__(self) -> str:
        return "\n".join([*self._words(), *(f"  {name:28} {value}" for name, value in self._rows())])

    def _repr_html_(self) -> str:
        words = [element("p", line) for line in self._words()]
        return join(
            [*words, table("Parameters, with one standard deviation", ("Parameter", "Value"), self._rows())]
        )

    def _words(self) -> list[str]:
        model, law = self.source.exact, self.source.exact.main.peak
        what = "the paper's model"
        if isinstance(law, Simulated) and law.effects:
            what = f"the paper's model with {name_of(law.effects)}"
        tried = ""
        if model.tried is not None:
            (v_low, v_high), (f_low, f_high) = model.tried[:2]
            tried = f", tried from {v_low:g} to {v_high:g} m/s and from {f_low:g} to {f_high:g} N"
        lines = [f"Model of {model.source}: {what}{tried}"]
        if (trained := self.source.trained) is not None:
            lines.append(f"  by a surrogate, wrong by less than {100 * float(trained.bounds.force):.2g} %")
        return [*lines, *([f"  {headed(model.doubt)}"] if model.doubt else [])]

    def _rows(self) -> list[tuple[str, str]]:
        model = self.source.exact
        theta = np.asarray(model.main.theta)
        std = np.sqrt(np.diag(model.main.covariance) + (model.relative[:-2] * theta) ** 2)
        rows = []
        for name, unit, value, s in zip(model.names, model.units, theta, std, strict=False):
            spread = f" ± {short(float(s))}" if s else ""
            rows.append((name, f"{value:.6g}{spread}{'' if unit == '1' else f' {unit}'}"))
        return rows


def read_model(path: str | Path) -> Model:
    """The model in a file: of a rig, of a diagnosis, or of a surrogate that was trained on one.

    **Arguments:** `path`: a rig's YAML file, the folder of a diagnosis or its model.json, or a model.eqx.

    **Returns:** `Model`.

    **Raises:** `InputError` that lists what is wrong with the file.

    >>> import acf_jax as acf
    >>> acf.read_model("configs/table1_rig.yaml")
    Model of configs/table1_rig.yaml: the paper's model
      m                            4 kg
      d                            0 N s/m
      k_f                          0 N/m
      k_c                          175561 N/m
    """
    return Model(source_of(path_of(path)))


def load_surrogate(path: str | Path | None = None) -> Surrogate | Model:
    """A trained surrogate.

    **Arguments:** `path`: a model.eqx; without one the surrogate of the paper's model that is shipped.

    **Returns:** for a surrogate of a diagnosis a `Model`; for one of the paper's model a `Surrogate`, which takes `Rig`
    and `Impact` and gives force, gradient and error bound.

    **Raises:** `InputError` when the file is missing, damaged, or none of ours.

    >>> import acf_jax as acf
    >>> rig = acf.Rig(m=4.0, d=60.0, k_f=2000.0, k_c=175561.0)
    >>> answer = acf.load_surrogate()(rig, acf.Impact(v_e=0.2, f_p=100.0))
    >>> round(float(answer.f_max), 2), float(answer.error_bound) < 0.001
    (196.99, True)
    """
    begin()
    if path is not None and is_corrected(path_of(path)):
        return read_model(path)
    return load_of_paper(None if path is None else path_of(path))
