"""What of a recording is which signal: as the user named it, else the only candidate."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from acf_jax.errors import InputError, shown
from acf_jax.recording.mapping import Mapping, Source
from acf_jax.recording.readers import Recording
from acf_jax.recording.series import Channel

_SHOWN = 10  # topics or columns of a message


@dataclass(frozen=True)
class Chosen:
    """The signals; a number is the same in every contact."""

    force: Source
    speed: Source | float
    is_position: bool
    pretension: Source | float
    notes: tuple[str, ...]  # what was taken without being named

    @property
    def sources(self) -> dict[str, Source]:
        """What has to be read, by role."""
        roles = {"force": self.force, "speed": self.speed, "pretension": self.pretension}
        return {role: source for role, source in roles.items() if isinstance(source, Source)}


def choose(path: Path, recording: Recording, mapping: Mapping) -> Chosen:
    """The signals of a mapping, each that it leaves out taken where there is one candidate.

    **Raises:** `InputError` that lists what the recording offers, where one has to be named.
    """
    faults: list[str] = []
    alone: list[str] = []

    def pick(role: str, given: Source | float | None, remedy: str) -> Source | float | None:
        if given is not None:
            return given
        found = recording.candidates(role)
        if len(found) == 1:
            alone.append(f"{role} {recording.described(found[0])}")
            return found[0]
        names = ", ".join(shown(source.name) for source in found[:_SHOWN])
        what = f"{names} may all be the {role}" if found else f"nothing is clearly the {role}"
        faults.append(f"{path}: {what}; {remedy}")
        return None

    force = pick("force", mapping.force, "name it by --force")
    speed = mapping.position or pick(
        "velocity", mapping.velocity, "name it by --velocity, or a position by --position"
    )
    pretension = pick("pretension", mapping.pretension, "name it by --pretension, or give it there in N")
    if faults:
        faults += recording.obstacles()
        raise InputError([*faults, f"{path}: offers {_in_a_line(recording.channels())}; `--list` shows all"])
    assert isinstance(force, Source) and speed is not None and pretension is not None
    notes = [f"taken, each the only candidate: {', '.join(alone)}"] if alone else []
    place = isinstance(speed, Source) and (mapping.position is not None or recording.is_position(speed))
    if isinstance(speed, Source) and place and mapping.position is None:
        notes.append(f"{recording.described(speed)} is a position: its derivative is the velocity")
    return Chosen(force, speed, place, pretension, tuple(notes))


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
