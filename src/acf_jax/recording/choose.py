"""What of a recording is which signal: as the user named it, else the only candidate."""

from collections.abc import Sequence
from dataclasses import dataclass

from acf_jax.errors import InputError, shown
from acf_jax.recording.mapping import Mapping, Source
from acf_jax.recording.opened import Opened, is_same
from acf_jax.recording.series import Channel
from acf_jax.si import UNITS
from acf_jax.si import factor as unit_factor

_SHOWN = 10  # topics or columns of a message


@dataclass(frozen=True)
class Chosen:
    """The signals; a number is the same in every contact."""

    force: Source
    speed: Source | float
    is_position: bool
    pretension: Source | float
    places: dict[str, int]  # of the recording that holds it, by role; 0: the first
    notes: tuple[str, ...]  # what was taken without being named

    @property
    def sources(self) -> dict[str, Source]:
        """What has to be read, by role."""
        roles = {"force": self.force, "speed": self.speed, "pretension": self.pretension}
        return {role: source for role, source in roles.items() if isinstance(source, Source)}


class _Choice:
    """Signals are picked one by one; what is missing and what was taken unasked is collected."""

    def __init__(self, opened: Sequence[Opened]):
        self.opened = opened
        self.faults: list[str] = []
        self.alone: list[str] = []
        self.notes: list[str] = []
        self.places: dict[str, int] = {}

    def pick(
        self, role: str, key: str, given: Source | float | None, places: Sequence[int], remedy: str
    ) -> Source | float | None:
        """The signal that is given, or the only candidate of the first recording at `places` that has any."""
        if isinstance(given, Source):
            having = [
                i for i in places if given.name in {c.name for c in self.opened[i].recording.channels()}
            ]
            self.places[role] = having[0] if having else places[0]
            if len(having) > 1:
                self.notes.append(
                    f"{given.name} is in both recordings: {self._described(role, given)} is taken"
                )
            return given
        if given is not None:
            return given
        for place in places:
            if found := self.opened[place].recording.candidates(key):
                break
        if len(found) == 1:
            self.places[role] = place
            self.alone.append(f"{key} {self._described(role, found[0])}")
            return found[0]
        path = self.opened[place].path
        names = ", ".join(shown(source.name) for source in found[:_SHOWN])
        what = f"{names} may all be the {key}" if found else f"nothing is clearly the {key}"
        self.faults.append(f"{path}: {what}; {remedy}")
        return None

    def in_si(self, role: str, kind: str, source: Source) -> Source:
        """The signal with the factor of its stated unit, where nothing or only the sign stands before its name."""
        holder = self.opened[self.places[role]]
        unit = holder.recording.unit(source)
        if "scale" in source.model_fields_set and source.scale != -1.0:
            return source
        si, where = next(iter(UNITS[kind])), f"{holder.path} {holder.recording.described(source)}"
        try:
            factor = unit_factor(unit, kind)
        except ValueError as fault:
            self.faults.append(f"{where}: {fault}; put what one is in {si} before its name, as 0.1*NAME")
            return source
        if factor is None or factor == 1.0:
            return source
        self.notes.append(f"{where}: is read in {unit}; 1* before its name takes it in {si}")
        return source.model_copy(update={"scale": factor * source.scale})

    def _described(self, role: str, source: Source) -> str:
        return self.opened[self.places[role]].described(source)


def choose(opened: Sequence[Opened], mapping: Mapping) -> Chosen:
    """The signals of a mapping, each that it leaves out taken where there is one candidate.

    **Arguments:** `opened`: the recording of the force, then others; motion and pretension are looked for there first.

    **Raises:** `InputError` that lists what the recordings offer, where one has to be named.
    """
    choice = _Choice(opened)
    first, rest = 0, [*range(1, len(opened)), 0]

    def where(source: Source | float | None) -> Sequence[int]:
        """The recordings that may hold a signal."""
        named = source.recording if isinstance(source, Source) else None
        if named is None:
            return rest
        return [i for i, o in enumerate(opened) if is_same(o.path, opened[first].path.parent / named)]

    holding = [o.path for o in opened[1:] if o.recording.candidates("force")]
    swapped = f", or name {holding[0]} first, where it may be" if holding else ""
    force = choice.pick("force", "force", mapping.force, [first], f"name it by --force{swapped}")
    given = mapping.position or mapping.velocity
    other = "" if len(opened) > 1 else "; where it is in a recording of its own, name that by --with"
    speed = choice.pick(
        "speed", "velocity", given, where(given), f"name it by --velocity, or a position by --position{other}"
    )
    given = mapping.pretension
    pretension = choice.pick(
        "pretension", "pretension", given, where(given), "name it by --pretension, or give it there in N"
    )
    if choice.faults:
        offers = [
            f"{o.path}: offers {_in_a_line(o.recording.channels())}; `--list` shows all" for o in opened
        ]
        obstacles = [obstacle for o in opened for obstacle in o.recording.obstacles()]
        raise InputError([*choice.faults, *obstacles, *offers])
    assert isinstance(force, Source) and speed is not None and pretension is not None
    notes = [f"taken, each the only candidate: {', '.join(choice.alone)}"] if choice.alone else []
    place = False
    force = choice.in_si("force", "force", force)
    if isinstance(speed, Source):
        holder = opened[choice.places["speed"]]
        place = mapping.position is not None or holder.recording.is_position(speed)
        if place and mapping.position is None:
            notes.append(f"{holder.described(speed)} is a position: its derivative is the velocity")
        speed = choice.in_si("speed", "position" if place else "velocity", speed)
    if isinstance(pretension, Source):
        pretension = choice.in_si("pretension", "pretension", pretension)
    if choice.faults:
        raise InputError(choice.faults)
    return Chosen(force, speed, place, pretension, choice.places, (*notes, *choice.notes))


def listing(channels: Sequence[Channel]) -> str:
    """Topics or columns with their types, one a line."""
    width = max((len(c.name) for c in channels), default=0)
    lines = [
        f"  {c.name:<{width}}  {c.type}" + (f", {c.count:,}" if c.count is not None else "") for c in channels
    ]
    return "\n".join(lines) or "  nothing"


def _in_a_line(channels: Sequence[Channel]) -> str:
    some = [f"{shown(c.name)} ({c.type[:40]})" for c in channels[:_SHOWN]]
    rest = len(channels) - len(some)
    return ", ".join(some) + (f" and {rest} more" if rest else "") or "nothing"
