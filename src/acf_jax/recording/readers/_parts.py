"""Which part of a topic's messages a signal is: one joint, one transform, the messages of one frame."""

import re
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from acf_jax.errors import shown
from acf_jax.recording.readers._guard import some

# Messages of many transforms, one of which a field names by its child frame; the rest of the field is within that.
CHILD = re.compile(r"transforms\[([^\[\]]+)\](?:\.(.+))?")
JOINT = re.compile(r"\w+\[(?!\d+\])([^\[\]]+)\]")  # by its name: several publishers may share the topic
FRAME = re.compile(r"frame_id\[([^\[\]]*)\](?:\.(.+))?")  # before a field: only messages of that frame


@dataclass
class Wanted:
    """A signal within the messages of a topic, and who has sent it so far."""

    key: str
    kind: str  # of the parts that messages hold: child frames, joints, or nothing of the like
    name: str  # of the part meant; empty: any
    frame: str | None  # of the messages meant; None: any
    place: str  # of the value in a part
    get: Callable[[Any], float]
    seen: set[str] = field(default_factory=set)  # names of parts in the messages so far
    senders: Counter[tuple[int, str]] = field(default_factory=Counter)  # connections and frames of its parts
    turns: int = 0  # how often the sender was another than just before
    last: tuple[int, str] | None = None

    def parts(self, message: Any, connection: int) -> list[Any]:
        """The parts of a message, or the message itself, that hold the signal."""
        found = [part for part in self._named(message) if self.frame is None or frame_of(part) == self.frame]
        for part in found:
            sender = (connection, frame_of(part))
            self.turns += sender != self.last and self.last is not None
            self.senders[sender] += 1
            self.last = sender
        return found

    def _named(self, message: Any) -> list[Any]:
        if self.kind == "child frame":
            named = [(str(t.child_frame_id).lstrip("/"), t) for t in message.transforms]
            self.seen.update(name for name, _ in named)
            return [transform for name, transform in named if name == self.name.lstrip("/")]
        if self.kind == "joint":
            names = [str(name) for name in message.name]
            self.seen.update(names)
            return [message] if not self.name or self.name in names else []
        return [message]

    def fault(self, topic: str) -> str | None:
        """Why what was read is no signal: the part is not there, or several are mixed; None when it is one."""
        known = some(sorted(self.seen))
        count = sum(self.senders.values())
        if self.frame is not None and not count:
            return f"has no messages of frame {shown(self.frame)}; name another"
        if self.name and not count:
            return f"has no {self.kind} {shown(self.name)}; name one of {known}"
        if self.kind == "joint" and not self.name and len(self.seen) > 1:
            return f"holds several joints; name one as {self.place.partition('[')[0]}[NAME]: {known}"
        # a tool that is changed changes the frame too, but not to and fro
        if len(self.senders) < 2 or self.turns <= max(1.0, 0.5 * min(self.senders.values())):
            return None
        frames = sorted({frame for _, frame in self.senders})
        if len(frames) < 2 or self.kind == "child frame":
            return f"holds messages of {len(self.senders)} publishers in turn; record each under a topic of its own"
        one = f"{topic}:frame_id[{frames[0]}].{self.place}"
        return f"holds messages of the frames {some(frames)} in turn; name one, as in {one}"


def frame_of(part: Any) -> str:
    """The frame in the header of a message; empty without a header."""
    header = getattr(part, "header", None)
    return "" if header is None else str(header.frame_id)
