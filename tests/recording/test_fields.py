"""The path of a number within a message: taken where it is one, else answered by what there is."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from sessions import FEW, made, write_bag

from acf_jax.errors import InputError
from acf_jax.recording import Mapping, read_session
from acf_jax.recording.readers._fields import getter


@dataclass
class Vector:
    x: float = 1.0
    y: float = 2.0
    z: float = 3.0


@dataclass
class Stamp:
    sec: int = 5


@dataclass
class Header:
    stamp: Stamp = field(default_factory=Stamp)
    frame_id: str = "17"


@dataclass
class Wrench:
    force: Vector = field(default_factory=Vector)
    torque: Vector = field(default_factory=Vector)


@dataclass
class Stamped:
    header: Header = field(default_factory=Header)
    wrench: Wrench = field(default_factory=Wrench)


@dataclass
class Arm:
    header: Header = field(default_factory=Header)
    tool_wrench: np.ndarray = field(default_factory=lambda: np.arange(6.0))


@dataclass
class Joints:
    name: list[str] = field(default_factory=lambda: ["turn", "lift"])
    position: np.ndarray = field(default_factory=lambda: np.array([0.1, 0.2]))
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(0))


@dataclass
class Several:
    wrenches: list[Wrench] = field(default_factory=lambda: [Wrench(), Wrench()])
    note: str = "a"


NUMBERS = {
    "wrench.force.z": (Stamped(), 3.0),
    "tool_wrench[2]": (Arm(), 2.0),
    "position[lift]": (Joints(), 0.2),
    "wrenches[1].torque.y": (Several(), 2.0),
}


@pytest.mark.parametrize("path", NUMBERS)
def test_a_number_is_taken(path):
    message, value = NUMBERS[path]
    assert getter(path, "topic")(message) == value


SIX = "tool_wrench has 6 elements: write tool_wrench[2]"
FORCES = "'wrench.force.x', 'wrench.force.y', 'wrench.force.z', 'wrench.torque.x'"
WRONG = {
    (
        Stamped,
        "force.z",
    ): "has no field 'force.z'; did you mean 'wrench.force.z'? (it holds 'header', 'wrench')",
    (Stamped, "wrnch.force.z"): "did you mean 'wrench.force.z'?",
    (Stamped, "wrench.forc.z"): "did you mean 'wrench.force.z'? (wrench holds 'force', 'torque')",
    (Stamped, "Wrench.Force.X"): "did you mean 'wrench.force.x'?",
    (Stamped, "linear"): f"has no field 'linear'; its numbers are {FORCES}",
    (
        Stamped,
        "wrench",
    ): "'wrench' is not a number; did you mean 'wrench.force.z'? (wrench holds 'force', 'torque')",
    (Stamped, "wrench.force.z.q"): "has no field 'wrench.force.z.q'; did you mean 'wrench.force.z'?",
    (Stamped, "wrench[2].force.z"): "field 'wrench' is no array; write it without [2]",
    (Stamped, "wrench.force[z]"): "field 'wrench.force' is no array",
    (Stamped, "header.frame_id"): f"field 'header.frame_id' is not a number; its numbers are {FORCES}",
    (Stamped, "header.frame_id[0]"): "field 'header.frame_id' is no array",
    (Arm, "data"): f"has no field 'data'; its numbers are 'tool_wrench[2]'; {SIX}",
    (Arm, "tool_wrench"): f"field 'tool_wrench' is not a number; {SIX}",
    (Arm, "tool_wrench[6]"): f"field 'tool_wrench' has no element [6]; {SIX}",
    (Arm, "tool_wrench[z]"): f"field 'tool_wrench' has no element [z]; {SIX}",
    (Arm, "tool_wrench[-1]"): f"field 'tool_wrench' has no element [-1]; {SIX}",
    (Arm, "tool_wrench.size"): f"has no field 'tool_wrench.size'; {SIX}",
    (Joints, "position"): "name a joint that moves along the contact as position[NAME]: 'turn', 'lift'",
    (
        Joints,
        "position[left]",
    ): "has no element [left]; name a joint that moves along the contact as position[NAME]",
    (Joints, "velocity[lift]"): "has no element [lift]; velocity is empty: name another field or topic",
    (Joints, "name[0]"): "field 'name[0]' is not a number; its numbers are 'position[1]'",
    (Several, "wrenches"): "wrenches has 2 elements: write wrenches[1].force.x",
    (Several, "wrenches.force.z"): "has no field 'wrenches.force.z'; wrenches has 2 elements",
    (Several, "note"): "field 'note' is not a number; its numbers are 'wrenches[1].force.x'",
}


@pytest.mark.parametrize("kind, path", WRONG)
def test_what_is_no_number_is_answered_by_what_there_is(kind, path):
    with pytest.raises(InputError) as caught:
        getter(path, "bag topic /a")(kind())
    assert str(caught.value).startswith("bag topic /a: ") and WRONG[kind, path] in str(caught.value)


@pytest.mark.parametrize("path", ["", "wrench..z", "_x", "wrench.__class__", "a[]", "a[1][2]", "a b"])
def test_what_is_no_path_is_refused(path):
    with pytest.raises(InputError, match="is not the path of a field"):
        getter(path, "topic")


def test_wrong_fields_of_all_signals_come_together(tmp_path):
    bag = write_bag(tmp_path / "log", made(1, FEW[:1], rate=500.0), "mcap")
    names = {
        "force": "/ft/wrench:force.z",
        "velocity": "/robot/state:linear.z",
        "pretension": "/flange/pretension:v",
    }
    with pytest.raises(InputError) as caught:
        read_session(bag, Mapping.model_validate(names))
    first, second, third = caught.value.faults
    assert "/ft/wrench: has no field 'force.z'; did you mean 'wrench.force.z'?" in first
    assert "/robot/state: has no field 'linear.z'; did you mean 'twist.linear.z'?" in second
    assert "/flange/pretension: has no field 'v'; its numbers are 'data'" in third
