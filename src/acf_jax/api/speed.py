"""The highest contact velocity within a force limit."""

import math
from dataclasses import dataclass

import plotly.graph_objects as go

from acf_jax.api._values import not_numbers, plain, warn
from acf_jax.api.source import ModelLike, source_of
from acf_jax.contact.ending import make_ending
from acf_jax.designs.asked import Asked, asked_faults
from acf_jax.designs.solve import Design
from acf_jax.designs.speed import Speeds, find_speeds
from acf_jax.errors import InputError
from acf_jax.report.design_plot import design_figure
from acf_jax.report.markup import bullets, element, join
from acf_jax.report.speed_text import text


@dataclass(frozen=True, repr=False, eq=False)
class Speed:
    """The answer to one limit."""

    speeds: Speeds  # as the library says it
    is_ended: bool  # it was stated how the contact ends

    @property
    def v(self) -> float | None:
        """The highest contact velocity, m/s, rounded down to four decimals; None where no velocity keeps the limit."""
        found = self.speeds.found[0]
        return math.floor(float(found.z[-2]) * 1e4) / 1e4 if isinstance(found, Design) else None

    @property
    def force(self) -> float:
        """Expected peak force there, N; where no velocity keeps the limit, that of the least loaded."""
        return self.speeds.found[0].force

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader has to know of the answer."""
        return self.speeds.notes

    def plot(self) -> go.Figure:
        """Force over velocity, expected and not exceeded, with the limit and the answer."""
        return design_figure(self.speeds.found[0])

    def __repr__(self) -> str:
        return text(self.speeds, self.is_ended)

    def _repr_html_(self) -> str:
        head, row, *_ = text(self.speeds, self.is_ended).splitlines()
        return join([element("pre", f"{head}\n{row}"), bullets(self.notes) if self.notes else ""])


def speed(
    model: ModelLike,
    f_p: float,
    limit: float,
    *,
    stop_after: float | None = None,
    travel: float | None = None,
    reaction: float | None = None,
    deceleration: float | None = None,
    probability: float = 0.95,
    draws: int = 8192,
    up_to: float = 2.0,
) -> Speed:
    """The highest contact velocity whose peak contact force stays within a limit, whatever is uncertain.

    max v  subject to  P(F(v) <= limit) >= probability

    The force of the first peak counts, and the answer says when the robot must have stopped so that the limit holds
    with the same probability for what follows, too. Where it is stated how the contact ends, the force until then
    counts.

    **Arguments:** `model`: a diagnosis, a `Rig`, or a path. `f_p`: pretension, N. `limit`: of the peak contact force,
    N. `stop_after`: s after first contact, when the robot has stopped; `travel`: m, within which it has; `reaction`,
    s, and `deceleration`, m/s^2: from when and with which it brakes. `probability`: that the limit holds. `draws`: of
    everything uncertain. `up_to`: highest velocity looked at, m/s.

    **Returns:** `Speed`, whose `v` is None where no velocity keeps the limit.

    **Raises:** `InputError` for numbers that cannot be, outside a surrogate's range, and where the diagnosis had too
    little data to answer. **Warns** as the command does.

    >>> import acf_jax as acf
    >>> rig = acf.Rig(m=4.0, d=0.0, k_f=0.0, k_c=175561.0)
    >>> acf.speed(rig, f_p=100.0, limit=150.0).v
    0.1334
    """
    source = source_of(model)
    needed = {"f_p": f_p, "limit": limit, "probability": probability, "draws": draws, "up_to": up_to}
    told = {"stop_after": stop_after, "travel": travel, "reaction": reaction, "deceleration": deceleration}
    needed, told = ({name: plain(x) for name, x in given.items()} for given in (needed, told))
    if faults := not_numbers(needed, told):
        raise InputError(faults)
    ending, faults = make_ending(told)
    asked = Asked(needed["f_p"], (needed["limit"],), ending, needed["probability"], draws, needed["up_to"])
    if faults := asked_faults(asked) + faults:
        raise InputError(faults)
    found = find_speeds(source.model, asked)
    warn(found.notes)
    return Speed(found, ending.is_known)
