"""A recording to look at, to drop trials of, and to diagnose."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import plotly.graph_objects as go

from acf_jax.api._values import CALLER, path_of, plain, warn
from acf_jax.api.dataset import DataSet
from acf_jax.api.rig import rig_file_of
from acf_jax.dataset.trials import RigPrior
from acf_jax.errors import InputError, shown, suggestion
from acf_jax.recording import Impacts, Mapping, Refused, Session, find_impacts, read_mapping, read_session
from acf_jax.recording.page import cuts_table, each_cut, taken, whole_recording
from acf_jax.recording.review import Entry, read_review
from acf_jax.recording.rig import RigFile
from acf_jax.recording.words import found
from acf_jax.recording.write import entry_of, write_impacts
from acf_jax.report.markup import bullets, element, join
from acf_jax.report.notebook import to_plotly

_OPTION = re.compile(r"--(force|velocity|position|pretension|time|rate|with|mapping)\b")
_ARGUMENTS = {"with": "robot"}


class Recording:
    """The impacts that were found in a recording, as `read_recording` gives them.

    Trials are called `t000`, `t001` and so on, by the time of contact. `drop` and `keep` change the recording itself.
    """

    def __init__(
        self,
        session: Session,
        mapping: Mapping,
        rig: RigFile | None,
        review: Sequence[Entry] | None = None,
    ):
        self._session, self._mapping, self._rig, self._given = session, mapping, rig, review
        self._first = self._find(rig, review)  # what the checks and a file of cuts decide
        self._by_hand: dict[str, bool] = {}
        self.impacts = self._first  # what was found, as the library says it

    @property
    def trials(self) -> tuple[str, ...]:
        """The names of the trials that are kept."""
        return tuple(cut.trial for cut in self.impacts.kept)

    @property
    def faults(self) -> tuple[str, ...]:
        """Why no data set can come of the recording; empty where one can."""
        return _in_python(self.impacts.faults)

    def drop(self, *trials: str) -> "Recording":
        """Leave trials out, whatever the checks say of them; changes the recording.

        **Arguments:** `trials`: names, such as `t011`.

        **Returns:** the recording, as it is now.

        **Raises:** `InputError` for a trial that it does not have.
        """
        return self._decide(trials, False)

    def keep(self, *trials: str) -> "Recording":
        """Keep trials that were dropped, or that the checks left out; arguments and faults as of `drop`."""
        return self._decide(trials, True)

    def plot(self, trial: str | None = None) -> go.Figure:
        """The whole recording with every cut marked; of one trial every sample.

        **Raises:** `InputError` for a trial that the recording does not have.
        """
        if trial is None:
            return to_plotly(whole_recording(self.impacts))
        self._check([trial])
        cuts = tuple(cut for cut in self.impacts.cuts if cut.trial == trial)
        return to_plotly(each_cut(replace(self.impacts, cuts=cuts)))

    def dataset(self, rig: RigPrior | str | Path | None = None) -> DataSet:
        """The trials that are kept as a data set, as `python -m acf_jax import` writes it.

        **Arguments:** `rig`: what is known of the rig: an `acf_jax.Prior`, or a rig's file. What `read_recording` was
        given by default.

        **Raises:** `InputError` without a rig, and where no data set can come of the recording.
        """
        known = self._rig if rig is None else rig_file_of(rig)
        if known is None:
            raise InputError(
                "rig: is missing; give what is known of it, as in rig=acf_jax.Prior(m=(1.8, 0.1), ...)"
            )
        impacts = self._find(known, self._review())
        if impacts.faults:
            raise InputError(_in_python(impacts.faults))
        with TemporaryDirectory() as folder:
            read = write_impacts(Path(folder), impacts, known)
        assert read is not None  # a rig was given
        return DataSet.of(read, self._session.path)

    def __repr__(self) -> str:
        lines = found(self.impacts)
        return "\n".join([f"Recording {self._session.path}: {lines[0]}", *lines[1:], *self.faults])

    def _repr_html_(self) -> str:
        head = element("p", f"Recording {self._session.path}: {found(self.impacts)[0]}")
        faults = [bullets(self.faults)] if self.faults else []
        return join([head, *faults, cuts_table(self.impacts), taken(self.impacts)])

    def _find(self, rig: RigFile | None, review: Sequence[Entry] | None) -> Impacts:
        try:
            return find_impacts(self._session, self._mapping.contacts, rig.prior if rig else None, review)
        except Refused as refused:
            return refused.impacts

    def _review(self) -> Sequence[Entry] | None:
        """What was decided by hand beside what the checks decided; None where nothing was."""
        first = self._first
        if not self._by_hand:
            return self._given
        own = {cut.trial: None if first.faults else cut.keep for cut in first.cuts} | self._by_hand
        return [entry_of(first, cut, own[cut.trial]) for cut in first.cuts]

    def _decide(self, trials: tuple[str, ...], keep: bool) -> "Recording":
        self._check(trials)
        self._by_hand |= dict.fromkeys(trials, keep)
        self.impacts = self._find(self._rig, self._review())
        warn(self.faults, CALLER + 1)
        return self

    def _check(self, trials: tuple[str, ...] | list[str]) -> None:
        known = [cut.trial for cut in self._first.cuts]
        faults = [
            f"{shown(name)} is no trial of the recording{suggestion(str(name), known) or f'; known are {_span(known)}'}"
            for name in trials
            if name not in known
        ]
        if faults:
            raise InputError(faults)


def read_recording(
    path: str | Path,
    *,
    force: str | None = None,
    velocity: str | float | None = None,
    position: str | None = None,
    pretension: str | float | None = None,
    time: str | None = None,
    rate: float | None = None,
    tare: bool | None = None,
    robot: str | Path | None = None,
    mapping: str | Path | None = None,
    rig: RigPrior | str | Path | None = None,
    review: str | Path | None = None,
) -> Recording:
    """Read a recording of many impacts: a ROS bag, or a table or arrays of any kind that docs/import.md lists.

    A signal is `[SCALE*]COLUMN` or `[SCALE*]/TOPIC[:FIELD]`: `-1*Fz` turns the sign, `0.001*v_mm_s` brings mm/s to m/s.
    What is not named is looked for, and taken where there is one candidate.

    **Arguments:** `path`: of the recording of the force. `force`: N, positive in contact. `velocity`: m/s, of the
    robot towards the part; a signal or a number. `position`: m, in place of the velocity. `pretension`: N; a signal or
    a number. `time`: column of the times. `rate`: Hz, of a table without times. `tare`: take off what the force reads
    while nothing is touched, which is done by default. `robot`: recording of the robot's signals, where that is one of
    its own. `mapping`: YAML file of these and further keys. `rig`: what is known of the rig, an `acf_jax.Prior` or a
    rig's file; may be given to `diagnose` instead. `review`: a cuts.yaml, with decisions about contacts.

    **Returns:** `Recording`. Where no data set can come of it a warning says why, and `plot` shows what was found.

    **Raises:** `InputError` where the file cannot be read or a signal has to be named.

    >>> import acf_jax as acf
    >>> acf.read_recording("press.csv", force="-1*Fz", velocity="0.001*v_mm_s", tare=True)  # doctest: +SKIP
    """
    known = None if rig is None else rig_file_of(rig)
    given = {
        "force": force,
        "velocity": plain(velocity),
        "position": position,
        "pretension": plain(pretension),
        "time": time,
        "sample_rate_hz": plain(rate),
        "tare": tare,
    }
    if tare is not None and not isinstance(tare, bool):
        raise InputError(f"tare: must be True or False, but is {shown(tare)}; write one of the two")
    found = read_mapping(None if mapping is None else path_of(mapping), given, dashes="")
    try:
        session = read_session(path_of(path), found, other=None if robot is None else path_of(robot))
    except InputError as error:
        raise InputError(_in_python(error.faults)) from None
    cuts = None if review is None else read_review(path_of(review), session.path.name, session.duration).cuts
    recording = Recording(session, found, known, cuts)
    warn(recording.faults)
    return recording


def _in_python(faults: Sequence[str]) -> tuple[str, ...]:
    """Messages with the arguments of `read_recording` in place of the command's options."""
    return tuple(
        _OPTION.sub(lambda option: f"{_ARGUMENTS.get(option[1], option[1])}=", fault) for fault in faults
    )


def _span(names: list[str]) -> str:
    return f"{names[0]} to {names[-1]}" if names else "none"
