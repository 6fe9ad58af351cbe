"""What was found in a recording, in words."""

from acf_jax.recording.cut import Cut
from acf_jax.recording.impacts import Impacts

DROPPED = "dropped by hand"


def found(impacts: Impacts) -> list[str]:
    """The contacts, those that are not kept, and what a user should know, a line each.

    Where no data set came of it every contact has its line.
    """
    kept, seconds = impacts.kept, impacts.session.duration
    head = f"{len(impacts.cuts)} contacts in {seconds:.1f} s"
    if impacts.faults:
        return [f"{head}, no data set", *(_line(impacts, cut) for cut in impacts.cuts), *impacts.notes]
    conditions = {cut.condition for cut in kept}
    odd = [f"{cut.trial} is not kept: {_why(cut)}" for cut in impacts.cuts if not cut.keep]
    moved = sum(cut.motion is not None for cut in kept)
    motion = [f"the robot's measured velocity goes into the motion of {moved} trials"] if moved else []
    trust = impacts.trust
    about = [f"{head}, {len(kept)} kept, at {len(conditions)} conditions", trust.headline]
    return list(dict.fromkeys([*about, *trust.lines, *odd, *motion, *impacts.notes]))


def _line(impacts: Impacts, cut: Cut) -> str:
    """One contact of a recording of which no data set came."""
    at = 1e-9 * (cut.contact.begin - int(impacts.session.force.time[0]))
    state = "can be used" if cut.keep else f"not kept: {_why(cut)}"
    return f"{cut.trial} at {at:.4f} s, {cut.words}: {state}"


def _why(cut: Cut) -> str:
    return "; ".join(cut.remarks) or DROPPED
