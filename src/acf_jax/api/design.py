"""The pretension, and what else is free, that is best within a force limit."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import plotly.graph_objects as go

from acf_jax.api._values import for_form, warn
from acf_jax.api.source import ModelLike, source_of
from acf_jax.designs import solve
from acf_jax.designs.answer import answer, model_faults
from acf_jax.designs.config import Goal, make_question
from acf_jax.designs.remedy import Infeasible
from acf_jax.errors import InputError
from acf_jax.report.design_plot import design_figure
from acf_jax.report.design_text import (
    document,
    explanation,
    none_document,
    remedies_said,
    stop_said,
    text,
    values_said,
)
from acf_jax.report.markup import bullets, element, join, table

Quantity = float | tuple[float, float]  # a number is given, a range (low, high) is free


@dataclass(frozen=True, repr=False, eq=False)
class Design:
    """The best point, or where nothing is feasible the least loaded one and what would make it feasible."""

    found: solve.Design | Infeasible  # as the library says it

    @property
    def is_feasible(self) -> bool:
        """Whether a point of the ranges keeps the limit with the probability."""
        return isinstance(self.found, solve.Design)

    @property
    def values(self) -> dict[str, float]:
        """What was free, by name, in SI units."""
        task = self.found.task
        return {task.model.names[i]: float(self.found.z[i]) for i in task.free}

    @property
    def force(self) -> float:
        """Expected peak force there, N."""
        return self.found.force

    @property
    def upper(self) -> float:
        """Force that is not exceeded with the probability, N."""
        return self.found.upper

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader has to know of the answer."""
        return self.found.notes if isinstance(self.found, solve.Design) else ()

    def document(self) -> dict[str, Any]:
        """The answer as plain numbers and texts, as the command's `--json`."""
        return document(self.found) if isinstance(self.found, solve.Design) else none_document(self.found)

    def plot(self) -> go.Figure:
        """The force that is not exceeded over what is free, with the limit and the point."""
        return design_figure(self.found)

    def __repr__(self) -> str:
        return text(self.found) if isinstance(self.found, solve.Design) else explanation(self.found)

    def _repr_html_(self) -> str:
        task = self.found.task
        rows = [
            *values_said(self.found),
            ("peak contact force, expected", f"{self.force:.1f} N"),
            (f"not exceeded with a probability of {task.probability:g}", f"{self.upper:.1f} N"),
            ("limit", f"{task.limit:g} N"),
        ]
        if isinstance(self.found, Infeasible):
            rows += [("any one of these would do", line) for line in remedies_said(self.found)]
            said = []
        else:
            said = [stop_said(self.found), *self.notes]
        head = repr(self).splitlines()[0].rstrip(":")
        return join([table(head, ("", "Value"), rows), bullets(said) if said else element("p")])


def design(
    model: ModelLike,
    limit: float,
    *,
    v_e: Quantity,
    f_p: Quantity,
    goal: Goal = "fastest",
    free: Mapping[str, tuple[float, float]] | None = None,
    ending: Mapping[str, float] | None = None,
    probability: float = 0.95,
    starts: int = 32,
    draws: int = 8192,
    seed: int = 0,
) -> Design:
    """The best contact velocity, pretension and further parameters within a limit of the peak contact force.

    max goal  subject to  P(F <= limit) >= probability, within the ranges

    **Arguments:** `model`: a diagnosis, a `Rig`, or a path. `limit`: N. `v_e`, m/s, and `f_p`, N: a number, or a range
    (low, high) that is free. `goal`: `fastest`, `highest_process_force` or `widest_margin`. `free`: further parameters
    of the model with their ranges, such as `{"k_c": (8e4, 2e5)}`. `ending`: how the contact ends, as `stop_after` (s),
    `travel` (m), `reaction` (s) and `deceleration` (m/s^2). `probability`: that the limit holds. `starts`: of the
    search. `draws`: of everything uncertain. `seed`: of both.

    **Returns:** `Design`; `is_feasible` says whether there is one.

    **Raises:** `InputError` that lists what is wrong with the question, or what a diagnosis with too little data is
    short of. **Warns** as the command does.

    >>> import acf_jax as acf
    >>> rig = acf.Rig(m=4.0, d=0.0, k_f=0.0, k_c=175561.0)
    >>> best = acf.design(rig, limit=250.0, v_e=(0.05, 0.5), f_p=(80.0, 120.0))
    >>> {name: round(value, 3) for name, value in best.values.items()}
    {'v_e': 0.283, 'f_p': 80.0}
    """
    source = source_of(model)
    spans = {name: _quantity(span) for name, span in free.items()} if isinstance(free, Mapping) else free
    asked = {
        "goal": goal,
        "limit": limit,
        "v_e": _quantity(v_e),
        "f_p": _quantity(f_p),
        "free": {} if free is None else spans,
        "ending": {} if ending is None else ending,
        "probability": probability,
        "starts": starts,
        "draws": draws,
        "seed": seed,
    }
    content = {name: for_form(value) for name, value in asked.items()} | {"model": source.exact.source}
    question = make_question(content, "design")
    faults = question.faults + model_faults("design", question, source.model)
    if faults or question.config is None:
        raise InputError(faults)
    found = Design(answer(question.config, source.model))
    warn(found.notes)
    return found


def _quantity(value: Any) -> Any:
    """A range as a form has it."""
    is_range = isinstance(value, tuple | list) and len(value) == 2
    return {"low": value[0], "high": value[1]} if is_range else value
