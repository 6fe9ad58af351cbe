"""The rig as a MuJoCo model that causes add to before it is compiled.

The flange is a mass on a slide joint x, the robot a carriage so heavy that nothing slows it. A
tendon between them has the length (sum of robot joints) - (joint of the contact's face), a spring that pushes
while the tendon is longer than -s_0 and a deadband below: Eq. (2), contact being lost at F_C = 0.
"""

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import mujoco
import numpy as np
from scipy.optimize import brentq

from validation.worlds.interface import AbstractCause, Array, Impact, Rig

CARRIAGE_MASS = 1e7  # kg; an impact of 3 N s then costs it 3e-7 m/s
SLACK = -10.0  # m; the lower end of a deadband that is never left


class Scene:
    """Model under construction, its controls, and how its records are read."""

    def __init__(self, rig: Rig, impact: Impact):
        self.rig, self.impact = rig, impact
        self.spec = mujoco.MjSpec()
        self.spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
        self.spec.option.gravity = [0.0, 0.0, 0.0]
        self.flange, self.x = self.add_body(self.spec.worldbody, "x", rig.m)
        self.x.stiffness[0], self.x.damping[0] = rig.k_f, rig.d
        self.robot, _ = self.add_body(self.spec.worldbody, "carriage", CARRIAGE_MASS)
        self.robot.gravcomp = 1.0
        self.robot_joints = ["carriage"]
        self.face, self.face_joint = self.flange, "x"
        self.stiffness = [rig.k_c, 0.0, 0.0]  # of s, s |s| and s^3
        self.damping = [0.0, 0.0, 0.0]  # of s', s' |s'| and s'^3
        self.start_share = 1.0  # of the pretension at which contact starts
        self.fastest = 0.0  # rad/s, of a mode that the time step has to resolve
        self.contact_limit = 0.0  # compression at which the pad bottoms out, m; zero for none
        self.limit_stiffness = 0.0  # of that limit, per mass, 1/s^2
        self.contact_yield = 0.0  # compression past which the pad flows, m; zero for none
        self.controls: list[Callable[[Array], Array]] = []  # one an actuator, of time
        self.branches: list[tuple[str, str, float]] = []  # tendon, inner joint, stiffness in parallel
        self.at_compile: list[Callable[[], None]] = []  # what needs the start force or the last joints

    def add_body(self, parent: Any, joint: str, mass: float) -> tuple[Any, Any]:
        """A body of `mass` on a slide joint along x; the body and its joint."""
        body = parent.add_body(name=f"{joint}_body", mass=mass, inertia=[1.0, 1.0, 1.0])
        body.explicitinertial = True
        slide = body.add_joint(name=joint, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1.0, 0.0, 0.0])
        return body, slide

    def add_tendon(self, name: str, joints: dict[str, float], **properties: Any) -> Any:
        """A tendon whose length is the weighted sum of joint positions."""
        tendon = self.spec.add_tendon(name=name, **properties)
        for joint, weight in joints.items():
            tendon.wrap_joint(joint, weight)
        self._add_sensor(f"{name}_pos", name, mujoco.mjtSensor.mjSENS_TENDONPOS, mujoco.mjtObj.mjOBJ_TENDON)
        self._add_sensor(f"{name}_vel", name, mujoco.mjtSensor.mjSENS_TENDONVEL, mujoco.mjtObj.mjOBJ_TENDON)
        return tendon

    def watch(self, joint: str) -> None:
        """Record position and velocity of a joint as `<joint>_pos` and `<joint>_vel`."""
        self._add_sensor(f"{joint}_pos", joint, mujoco.mjtSensor.mjSENS_JOINTPOS, mujoco.mjtObj.mjOBJ_JOINT)
        self._add_sensor(f"{joint}_vel", joint, mujoco.mjtSensor.mjSENS_JOINTVEL, mujoco.mjtObj.mjOBJ_JOINT)

    def _add_sensor(self, name: str, target: str, kind: Any, of: Any) -> None:
        self.spec.add_sensor(name=name, type=kind, objtype=of, objname=target)

    def add_motor(
        self, joint: str, gear: float, control: Callable[[Array], Array], **properties: Any
    ) -> None:
        """A force on a joint that follows `control` of time, through the dynamics that `properties` name."""
        self.spec.add_actuator(
            name=f"{joint}_motor_{len(self.controls)}", trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint,
            gear=[gear, 0, 0, 0, 0, 0], **properties,
        )  # fmt: skip
        self.controls.append(control)

    @property
    def start_force(self) -> float:
        """F_C(0) of the contact at rest, N."""
        return self.start_share * self.impact.f_p

    @property
    def s_0(self) -> float:
        """Compression at first contact, m: the spring's polynomial and the branches carry F_C(0)."""
        linear = self.stiffness[0] + sum(stiffness for *_, stiffness in self.branches)
        if self.start_force == 0.0:
            return 0.0
        k_2, k_3 = self.stiffness[1:]
        return float(
            brentq(
                lambda s: linear * s + k_2 * s**2 + k_3 * s**3 - self.start_force,
                0.0, 2.0 * self.start_force / linear, xtol=1e-15,
            )
        )  # fmt: skip

    def compile(self, step: float) -> mujoco.MjModel:
        """The model with a time step, once all causes have added what they are."""
        self.spec.option.timestep = step
        joints = {**dict.fromkeys(self.robot_joints, 1.0), self.face_joint: -1.0}
        limit = {}
        if self.contact_limit:
            limit = {
                "limited": mujoco.mjtLimited.mjLIMITED_TRUE,
                "range": [SLACK, self.contact_limit - self.s_0],
                "solref_limit": [-self.limit_stiffness, -0.1 * self.limit_stiffness**0.5],
            }
            kind, of = mujoco.mjtSensor.mjSENS_TENDONLIMITFRC, mujoco.mjtObj.mjOBJ_TENDON
            self._add_sensor("contact_limit", "contact", kind, of)
        self.add_tendon(
            "contact", joints, stiffness=self.stiffness, damping=self.damping,
            springlength=[SLACK, -self.s_0], springyield=self.contact_yield, **limit,
        )  # fmt: skip
        for name, inner, stiffness in self.branches:
            self.add_tendon(
                name, {**joints, inner: -1.0}, stiffness=[stiffness, 0.0, 0.0], springlength=[-self.s_0] * 2
            )
        for finish in self.at_compile:
            finish()
        return self.spec.compile()

    def contact_force(self, record: dict[str, Array]) -> Array:
        """F_C along a record, N."""
        s = record["contact_pos"] + self.s_0
        if self.contact_yield:
            s = s - np.maximum.accumulate(np.maximum(s - self.contact_yield, 0.0))
        s = np.maximum(s, 0.0)
        rate = record["contact_vel"]
        k, c = self.stiffness, self.damping
        force = k[0] * s + k[1] * s**2 + k[2] * s**3
        force = force + c[0] * rate + c[1] * rate * np.abs(rate) + c[2] * rate**3
        for name, _, stiffness in self.branches:
            force = force + stiffness * (record[f"{name}_pos"] + self.s_0)
        if "contact_limit" in record:
            force = force + record["contact_limit"]
        return np.asarray(np.maximum(force, 0.0))


class AbstractSceneCause(AbstractCause):
    """A cause that adds to the scene, to its controls or to what its sensor reads."""

    stage: ClassVar[int] = 0  # bodies of a later stage are nearer the contact

    @abstractmethod
    def build(self, scene: Scene) -> None:
        """Add the cause to the scene."""

    def read(self, time: Array, reading: Array, record: dict[str, Array]) -> Array:
        """The sensor's reading on the engine's time grid, given the `reading` without this cause, N."""
        return reading
