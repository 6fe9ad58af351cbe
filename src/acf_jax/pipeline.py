"""From a recording to allowed speeds: import, diagnosis, speeds and a check in one go, as far as the data lead."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from acf_jax import diagnosis as library
from acf_jax.contact.ending import Ending
from acf_jax.contact.model import ContactModel
from acf_jax.contact.read import of_diagnosis
from acf_jax.dataset import GapDataset
from acf_jax.designs.asked import Asked
from acf_jax.designs.speed import Speeds, find_speeds
from acf_jax.diagnosis.results import gap_model
from acf_jax.errors import InputError, TooLittleData
from acf_jax.files import write_text
from acf_jax.folders import whole_folder
from acf_jax.inference.observations import Observations
from acf_jax.provenance import FILE, Origin
from acf_jax.recording import Impacts, Mapping, Refused, Session, find_impacts
from acf_jax.recording.page import import_page
from acf_jax.recording.rig import RigFile
from acf_jax.recording.words import found
from acf_jax.recording.write import CUTS, write_impacts
from acf_jax.report import save_diagnosis
from acf_jax.report.run_page import Outcome, run_page
from acf_jax.safety.check import Answer, Checker
from acf_jax.safety.limits import BodyArea, Limits
from acf_jax.safety.situation import Situation, situation_faults

DATA, DIAGNOSIS, PAGE = "data", "diagnosis", "index.html"  # in the run's folder
LEVELS = 4  # pretensions that are asked for at most

Stages = Callable[[], AbstractContextManager[Callable[[str], None]]]
Walk = Callable[[Sequence[float], str], Iterator[float]]


class Question(NamedTuple):
    """What is asked of a recording."""

    limit: float  # N, of the peak contact force
    limits: Limits  # of body areas
    areas: tuple[BodyArea, ...]  # that may be clamped; none: no check is asked for
    ending: Ending  # of the contact that is checked


def run(
    folder: Path,
    name: Path,
    question: Question,
    session: Session,
    mapping: Mapping,
    rig: RigFile,
    origin: Origin,
    stages: Stages = lambda: nullcontext(lambda stage: None),
    walk: Walk = lambda items, what: iter(items),
) -> Outcome:
    """One step after the other, as far as they lead; writes their files and the page that leads with the verdict.

    **Arguments:** `folder`: written into. `name`: what it will be called. `origin`: of the recording. `stages`: opens
    a display of the stages of the diagnosis. `walk`: walks pretensions, and may show how far it is.
    """
    outcome = _follow(folder, name, question, session, mapping, rig, origin, stages, walk)
    write_text(folder / PAGE, run_page(outcome, str(origin)))
    return outcome


def _follow(
    folder: Path,
    name: Path,
    question: Question,
    session: Session,
    mapping: Mapping,
    rig: RigFile,
    origin: Origin,
    stages: Stages,
    walk: Walk,
) -> Outcome:
    impacts, data = import_into(folder / DATA, name / DATA, session, mapping, rig, origin)
    outcome = Outcome(session.path.name, question.limit, found(impacts), impacts.faults)
    if data is None:
        return outcome
    with stages() as progress:
        try:
            diagnosis = library.diagnose(data, progress=progress)
        except InputError as error:  # too few trials that can be used
            return outcome._replace(stopped=error.faults)
        progress("writing the report")
        made_of = {str(name / DATA): data.digest}
        save_diagnosis(folder / DIAGNOSIS, diagnosis, replace(origin, made_of=made_of))
    outcome = outcome._replace(diagnosis=diagnosis)
    model = of_diagnosis(gap_model(diagnosis), source=str(name / DIAGNOSIS / "model.json"))
    try:
        model.check_carried()
    except TooLittleData as refusal:
        return outcome._replace(stopped=refusal.faults)
    tried = diagnosis.observations
    outcome = outcome._replace(speeds=speeds_at_levels(model, question.limit, tried, walk))
    try:
        return outcome._replace(check=check_fastest(model, question, tried)) if question.areas else outcome
    except InputError as refusal:
        return outcome._replace(stopped=refusal.faults)


def import_into(
    folder: Path, name: Path, session: Session, mapping: Mapping, rig: RigFile, origin: Origin
) -> tuple[Impacts, GapDataset | None]:
    """The impacts, and the data set that came of them, called `name`; a refusal leaves the page alone."""
    try:
        impacts = find_impacts(session, mapping.contacts, rig.prior)
        with whole_folder(folder) as scratch:
            data = write_impacts(scratch, impacts, rig)
            write_text(scratch / CUTS, import_page(impacts, None, str(name), str(origin)))
            origin.write(scratch)
    except Refused as refusal:
        write_text(folder / CUTS, import_page(refusal.impacts, None, str(name), str(origin)))
        return refusal.impacts, None
    assert data is not None  # a rig was given
    return impacts, replace(data, folder=name)


def speeds_at_levels(
    model: ContactModel, limit: float, tried: Observations, walk: Walk
) -> tuple[tuple[float, Speeds], ...]:
    """The highest speeds within `limit`, N, at pretensions that were tried: all, or four from lowest to highest."""
    levels = np.unique(tried.f_p)
    if levels.size > LEVELS:
        levels = levels[np.linspace(0, levels.size - 1, LEVELS).round().astype(int)]
    return tuple((f_p, find_speeds(model, Asked(f_p, (limit,)))) for f_p in walk(levels.tolist(), "speeds"))


def check_fastest(
    model: ContactModel, question: Question, tried: Observations
) -> tuple[Answer, Checker, Limits]:
    """The clamped contact at the fastest speed that was tried, with the highest pretension that was tried with it.

    **Raises:** `InputError` when a check takes no such contact.
    """
    v_e, f_p = max(zip(tried.v_e.tolist(), tried.f_p.tolist(), strict=True))
    situation = Situation("", question.areas, "quasi_static", v_e, f_p, ending=question.ending)
    if faults := situation_faults(situation):
        raise InputError(
            [f"no check of the contact at the fastest speed that was tried: {f}" for f in faults]
        )
    checker = Checker(model, None)
    return checker(situation), checker, question.limits


def written(data: Sequence[str]) -> list[str]:
    """The files that a run may have left in its folder; `data`: those of an import."""
    of_diagnosis = ("diagnosis.json", "model.json", "report.html", FILE)
    return [PAGE, *(f"{DATA}/{file}" for file in data), *(f"{DIAGNOSIS}/{file}" for file in of_diagnosis)]
