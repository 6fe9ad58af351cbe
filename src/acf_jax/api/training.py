"""Surrogates: trained on a diagnosis, loaded, and written as C."""

from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from acf_jax.api._values import folder_of, for_form, path_of
from acf_jax.api.source import HasSource, Source
from acf_jax.contact.read import of_diagnosis
from acf_jax.errors import InputError, shown
from acf_jax.export.formula import Formula, of_corrected, of_paper, read_formula
from acf_jax.export.write import write_c
from acf_jax.files import write_text
from acf_jax.gap_model import write_model
from acf_jax.provenance import Origin, digest_of
from acf_jax.surrogate import Surrogate, load_corrected
from acf_jax.training.default import default_config
from acf_jax.training.progress import Say
from acf_jax.training.run import run

MODEL, LEARNT = "diagnosed.json", "model.eqx"  # files of a run


def trained_on(
    source: Source,
    out: str | Path | None,
    ranges: Mapping[str, tuple[float, float]] | None,
    samples: int,
    steps: int,
    seed: int,
    resume: bool,
    say: Say,
) -> Source:
    """A surrogate of a diagnosis' model in place of its simulation; arguments as of `acf_jax.train`."""
    gap = source.gap
    if gap is None:
        raise InputError(
            "train: the paper's model has an exact peak already; train on a diagnosis, or export that peak"
        )
    with TemporaryDirectory() if out is None else nullcontext(str(folder_of(out))) as folder:
        path = Path(folder) / MODEL
        spans = {name: _range(name, span) for name, span in (ranges or {}).items()}
        config = default_config(
            gap, path, Path(folder), spans, for_form(samples), for_form(steps), for_form(seed)
        )
        write_text(path, write_model(gap))
        run(config, resume, say, Origin("acf_jax.train(...)", {MODEL: digest_of(path)}))
        stored = (Path(folder) / LEARNT).read_bytes()
        trained, _ = load_corrected(Path(folder) / LEARNT)
    return Source(of_diagnosis(gap, source=source.exact.source), gap, trained, stored)


def export_c(path: str | Path, surrogate: HasSource | Surrogate | str | Path | None = None) -> Path:
    """Write the peak force as a C99 header that needs math.h and nothing else (docs/export.md).

    **Arguments:** `path`: of the header, ends in `.h`; for a surrogate its name is that of the function. `surrogate`:
    what `train` or `load_surrogate` gave, or the path of a model.eqx; without one the exact peak of the paper's model.

    **Returns:** the path.

    **Raises:** `InputError` for a path that cannot be, and for a model without a surrogate.

    >>> import acf_jax as acf
    >>> acf.export_c("acf_peak.h").name  # doctest: +SKIP
    'acf_peak.h'
    """
    target = path_of(path)
    if surrogate is None:
        write_c(target)
        return target
    write_c(target, *_formula(surrogate))
    return target


def _formula(surrogate: Any) -> tuple[Formula, str]:
    """The formula of a surrogate, and what a header says of its origin."""
    if isinstance(surrogate, str | Path):
        return read_formula(path_of(surrogate)), str(surrogate)
    if isinstance(surrogate, Surrogate):
        return of_paper(surrogate), "of the paper's model"
    source = getattr(surrogate, "source", None)
    if not isinstance(source, Source) or source.trained is None:
        raise InputError(f"surrogate: {shown(surrogate)} holds none; train one first, as in model.train()")
    return of_corrected(source.trained), f"of {source.exact.source}"


def _range(name: str, span: Any) -> tuple[Any, Any]:
    if not isinstance(span, tuple | list) or len(span) != 2:
        raise InputError(f"ranges.{name}: must be (low, high), but is {shown(span)}; correct it")
    return for_form(span[0]), for_form(span[1])
