"""The highest contact velocity within a force limit: the design of a line, for one limit or several."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from acf_jax.contact.ended import ended
from acf_jax.contact.model import ContactModel
from acf_jax.contact.read import learnt_range
from acf_jax.contact.stop import ending_conflict
from acf_jax.designs.asked import Asked
from acf_jax.designs.chance import draws_fault
from acf_jax.designs.remedy import Infeasible
from acf_jax.designs.solve import Design, design
from acf_jax.designs.task import make_task
from acf_jax.errors import InputError

Each = Callable[[Sequence[float]], Iterable[float]]


class Speeds(NamedTuple):
    """The answers, one a limit, and what a reader has to know of all of them."""

    found: tuple[Design | Infeasible, ...]
    notes: tuple[str, ...]


def find_speeds(
    model: ContactModel, asked: Asked, called: Callable[[str], str] = str, each: Each = iter
) -> Speeds:
    """The highest contact velocity for each limit.

    **Arguments:** `asked`: without faults of its own. `called`: as for `asked_faults`. `each`: walks the limits.

    **Raises:** `InputError` where a surrogate was not trained for the question, where there are too few draws, and for
    an ending that cannot be of this contact; `TooLittleData` where the diagnosis behind the model could not answer.
    """
    model.check_carried()
    f_p, up_to = asked.f_p, asked.up_to
    slowest, fastest = learnt_range(model, "v_e") or (0.0, up_to)
    least, most = learnt_range(model, "f_p") or (f_p, f_p)
    faults = []
    if not least <= f_p <= most:
        faults.append(f"{called('f_p')} must lie in the surrogate's {least:g} to {most:g} N, but is {f_p:g}")
    if fault := draws_fault(model, asked.probability, asked.draws):
        faults.append(f"{called('draws')}: {fault}")
    if slowest >= up_to:
        faults.append(f"{called('up_to')} must be above the surrogate's {slowest:g} m/s, but is {up_to:g}")
    if faults:
        raise InputError(faults)
    if fault := ending_conflict(model, asked.ending, 0.0):
        raise InputError(fault)
    if asked.ending.is_known:
        model = ended(model, asked.ending)
    is_cut, up_to = slowest > 0 or fastest < up_to, min(up_to, fastest)
    found = tuple(
        design(
            make_task(model, {"v_e": (slowest, up_to)}, {"f_p": f_p}, "fastest", limit, asked.probability),
            draws=asked.draws,
        )
        for limit in each(asked.limits)
    )
    notes = dict.fromkeys(note for x in found if isinstance(x, Design) for note in x.notes)
    if is_cut and not all(isinstance(x, Design) and x.at_limit for x in found):
        notes[f"no velocity outside the surrogate's range of {slowest:g} to {fastest:g} m/s is looked at"] = (
            None
        )
    return Speeds(found, tuple(notes))
