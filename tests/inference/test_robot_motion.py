"""The robot's measured velocity in the model: its integral moves the contact, and it is known as well as measured."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from acf_jax.dataset import GapDataset, Measurement, RobotVelocity, Trace, Trial, assess_dataset
from acf_jax.diagnosis.candidates import fit_nominal, fit_single
from acf_jax.errors import InputError
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import fit
from acf_jax.inference.forward import Grid, forward
from acf_jax.inference.interpolation import at_times
from acf_jax.inference.linear import linearise
from acf_jax.inference.observations import N_NUISANCE, Observations, observe
from acf_jax.inference.parameters import begin
from acf_jax.inference.robot_motion import WALKS, robot_motion, velocity_std
from tests.imagined import RIG

GRID = Grid(2e-5, 800)
V_E, F_P = np.array([0.1, 0.1, 0.3, 0.3]), np.array([40.0, 100.0, 40.0, 100.0])
BRAKE, DELAY = 12.0, 1e-3  # m/s^2 and s
RATE, STD = 1000.0, 1e-3  # Hz and m/s, of the robot's velocity


def braked(t: np.ndarray, v: float) -> np.ndarray:
    """The velocity of a robot that brakes as the effect `robot_deceleration` does, until it stands still."""

    def gained(since: np.ndarray) -> np.ndarray:
        since = np.maximum(since, 0.0)
        return since + DELAY * np.expm1(-since / DELAY)

    return v - BRAKE * (gained(t - DELAY) - gained(t - DELAY - v / BRAKE))


def measured(
    v: float, rate: float = RATE, std: float = 0.0, late: float = 0.0, seed: int = 0
) -> RobotVelocity:
    time = np.arange(-40, 0.03 * rate) / rate
    return RobotVelocity(
        time, braked(time - late, v) + std * np.random.default_rng(seed).standard_normal(time.size)
    )


def trials(std: float = 0.0, late: float = 0.0, noise: float = 0.2) -> GapDataset:
    """Impacts of the paper's rig on a robot that brakes."""
    forces = forward(("robot_deceleration",), np.array([*RIG.values, BRAKE, 0.0, DELAY]), V_E, F_P, GRID)
    random = np.random.default_rng(5)
    found = []
    for i, (v, f_p) in enumerate(zip(V_E, F_P, strict=True)):
        time = np.arange(-60, 90) / 8e3
        force = at_times(forces.sensed[i], np.maximum(time, 0), GRID.h, forces.contact[i])
        trace = Trace(time, np.where(time >= 0, force, 0.0) + noise * random.standard_normal(time.size))
        found.append(Trial(f"t{i}", v, f_p, None, trace, motion=measured(v, std=std, late=late, seed=i)))
    return GapDataset(Path("made"), "", RIG, Measurement(contact_velocity_rel_std=0.001), tuple(found))


def observed(dataset: GapDataset) -> Observations:
    return observe(assess_dataset(dataset))


@pytest.mark.parametrize("rate, share", [(300.0, 0.12), (1000.0, 0.01), (20e3, 0.01)])
def test_forces_are_those_of_the_effect_that_moves_the_robot_so(rate: float, share: float) -> None:
    known = forward(("robot_deceleration",), np.array([*RIG.values, BRAKE, 0.0, DELAY]), V_E, F_P, GRID)
    motions = [measured(v, rate) for v in V_E]
    robot = robot_motion(motions, V_E, 0.0, np.zeros(4), 0.012)
    found = forward((), RIG.values, V_E, F_P, GRID, robot=robot)
    rigid = forward((), RIG.values, V_E, F_P, GRID)
    end = 500  # 10 ms
    missed = np.abs(found.sensed - known.sensed)[:, :end].max()
    assert missed < share * np.abs(rigid.sensed - known.sensed)[:, :end].max()


def test_derivatives_equal_finite_differences() -> None:
    o = observed(trials(STD))
    explanation = ("robot_compliance",)
    fitted = fit(o, explanation, begin(RIG.values, [0.1, 20.0, 0.1]), iterations=0)
    nuisance = np.full((4, o.n_nuisances), 0.3)
    u = fitted.u + np.r_[np.zeros(7), 0.0, 0.0, 0.5]
    there = (o, explanation, fitted.coordinates)
    linear = linearise(*there, u, nuisance, fitted.grid)
    step = 1e-5
    for k in (2, 3, len(u) - 1):  # stiffnesses and the motion's delay
        moved = linearise(*there, u + step * np.eye(len(u))[k], nuisance, fitted.grid)
        difference = (linear.residual - moved.residual) / step
        assert difference == pytest.approx(linear.by_parameter[:, k], abs=1e-3 * np.abs(difference).max())
    for k in range(N_NUISANCE + WALKS):
        moved = linearise(*there, u, nuisance + step * np.eye(o.n_nuisances)[k], fitted.grid)
        difference = (linear.residual - moved.residual) / step
        assert difference == pytest.approx(linear.by_nuisance[:, k], abs=1e-3 * np.abs(difference).max())


def test_the_robot_s_path_errs_as_it_is_said_to() -> None:
    """Against noise drawn anew: its mean square at the end of an impact, and that of the parts of the error."""
    end, still = 0.012, np.zeros(2000)
    random = np.random.default_rng(1)
    time = np.arange(-40, 30) / RATE
    motions = [RobotVelocity(time, 0.2 + STD * random.standard_normal(time.size)) for _ in still]
    assert velocity_std(motions) == pytest.approx(STD, rel=0.01)
    robot = robot_motion(motions, still + 0.2, STD, still, end)
    assert robot is not None
    path = robot.displacement
    drawn = (path[:, 0, -1] ** 2).mean()
    known = (path[:, 1 : 1 + WALKS, -1] ** 2).sum(1).mean()
    assert known == pytest.approx(0.9 * drawn, rel=0.1)


def test_a_braking_robot_that_was_measured_is_no_gap() -> None:
    dataset = trials(STD)
    with_it, without = observed(dataset), replace(observed(dataset), robot=None)
    paper, blind = fit_nominal(with_it), fit_nominal(without)
    assert 2 * paper.objective < 1.15 * with_it.n_used
    assert blind.objective > 5 * paper.objective
    assert paper.physical[[0, 3]] == pytest.approx(RIG.values[[0, 3]], rel=0.02)
    beyond = fit_single(Ground.of(with_it, paper), "robot_deceleration")
    assert beyond.objective > paper.objective - 5  # nothing is left for it
    found = fit_single(Ground.of(without, blind), "robot_deceleration")
    assert found.physical[4] + found.physical[5] * 0.2 == pytest.approx(BRAKE, rel=0.2)


def test_what_the_robot_does_beyond_its_measured_motion_is_a_candidate() -> None:
    """A link that yields behind the encoders: only the robot's compliance explains it, and its size is right."""
    inverse_mass, hz = 0.1, 20.0
    dataset = trials(STD)
    ripple = 1e-4 * np.cos(5e3 * dataset.trials[0].motion.time)
    steady = [
        replace(t, motion=RobotVelocity(t.motion.time, t.contact_velocity + ripple)) for t in dataset.trials
    ]
    forces = forward(("robot_compliance",), np.array([*RIG.values, inverse_mass, hz, 0.1]), V_E, F_P, GRID)
    random = np.random.default_rng(2)
    yielding = []
    for i, trial in enumerate(steady):
        time = trial.trace.time
        force = at_times(forces.sensed[i], np.maximum(time, 0), GRID.h, forces.contact[i])
        force = np.where(time >= 0, force, 0.0) + 0.2 * random.standard_normal(time.size)
        yielding.append(replace(trial, trace=Trace(time, force)))
    o = observed(replace(dataset, trials=tuple(yielding)))
    assert o.robot is not None
    paper = fit_nominal(o)
    found = fit_single(Ground.of(o, paper), "robot_compliance")
    assert found.objective < paper.objective - 20
    assert found.physical[4] == pytest.approx(inverse_mass, rel=0.15)


def test_the_delay_of_the_robot_s_clock_is_found() -> None:
    late = 0.6 / RATE
    fitted = fit_nominal(observed(trials(late=late, noise=0.05)))
    assert fitted.common[2] == pytest.approx(late * RATE, abs=0.15)


def test_later_than_the_motion_was_measured_nothing_is_compared() -> None:
    dataset = trials(STD)
    first = dataset.trials[0]
    assert first.motion is not None
    short = first.motion.time < 0.004
    cut = RobotVelocity(first.motion.time[short], first.motion.value[short])
    o = observed(replace(dataset, trials=(replace(first, motion=cut), *dataset.trials[1:])))
    assert o.time[0][o.used[0]].max() <= 0.003 < 0.005 < o.time[1][o.used[1]].max()


def test_a_trial_without_motion_keeps_its_speed() -> None:
    dataset = trials(STD)
    o = observed(replace(dataset, trials=(replace(dataset.trials[0], motion=None), *dataset.trials[1:])))
    assert o.robot is not None
    assert not o.robot.velocity[0].any() and o.robot.velocity[1].any()


def test_how_well_a_velocity_was_measured_has_to_be_known() -> None:
    dataset = trials(STD)
    bare = tuple(
        replace(
            t, motion=RobotVelocity(t.motion.time[t.motion.time >= 0], t.motion.value[t.motion.time >= 0])
        )
        for t in dataset.trials
        if t.motion
    )
    with pytest.raises(InputError, match="robot_velocity_std_m_per_s: is missing"):
        observed(replace(dataset, trials=bare))
    stated = replace(dataset.measurement, robot_velocity_std_m_per_s=STD)
    o = observed(replace(dataset, trials=bare, measurement=stated))
    assert o.robot is not None and o.robot.velocity[:, 1].any()
