"""A case: a data set with a hidden cause, and its answer."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from acf_jax.errors import InputError
from validation.worlds.distance import distance, size_at_distance
from validation.worlds.interface import AbstractCause, AbstractWorld, Array, Impact, find_world
from validation.worlds.setup import Setup, draw_setup


@dataclass(frozen=True)
class Trial:
    """One recorded impact."""

    name: str
    commanded: Impact  # what its label says
    impact: Impact  # what happened
    time: Array  # s, shape (n,)
    force: Array  # N, shape (n,), sensed
    peak: float  # N, largest sample until contact is lost
    fault: str = ""


@dataclass(frozen=True)
class Case:
    """What a user would have, and what only the world knows."""

    seed: int
    world: str
    setup: Setup
    causes: dict[str, AbstractCause]
    sizes: dict[str, float]
    distance: float  # whitened, of the sound trials as they happened: see `validation.worlds.distance`
    outside_library: bool
    trials: tuple[Trial, ...]
    held_out: tuple[Trial, ...]  # noise-free
    shares: dict[str, float] = field(
        default_factory=dict
    )  # of the force that each cause changes, if sized so
    background: tuple[str, ...] = ()  # small causes, which are no answer


def make_case(
    seed: int,
    effects: Sequence[str] = (),
    size: float | None = None,
    target: float | None = None,
    world: str = "scipy",
    coloured: bool | None = None,
) -> Case:
    """Draw a rig, let the effects act on it and record a campaign; equal arguments make equal cases.

    **Arguments:** `seed`: of everything drawn. `effects`: names of causes of the world; none at all for the paper's
    model. `size`: of every effect, above 0: near 0 for its neutral limit, 1 for clear. `target`: instead of `size`:
    the whitened distance that each effect shall have by itself as commanded. `world`: name of the world.
    `coloured`: whether the noise is coloured; drawn (a fifth of the cases) where absent.

    **Raises:** `InputError` where the world or an effect of it does not exist, an effect is named twice, or a size
    or target is not above 0.
    """
    engine = find_world(world)
    check_effects(engine, effects)
    for key, value in (("size", size), ("target", target)):
        if value is not None and not 0 < value < np.inf:
            raise InputError(
                f"{key} must be above 0, but is {value:g}; leave effects out for the paper's model"
            )
    rng = np.random.default_rng(seed)
    drawn = bool(rng.random() < 0.2)
    setup = draw_setup(rng, drawn if coloured is None else coloured)
    seeds = [int(s) for s in rng.integers(2**31, size=len(effects))]
    sizes = {
        name: (1.0 if size is None else size)
        if target is None
        else size_at_distance(engine, setup, name, own, target)
        for name, own in zip(effects, seeds, strict=True)
    }
    causes = {
        name: engine.draw(name, own, setup.rig, sizes[name]) for name, own in zip(effects, seeds, strict=True)
    }
    return record_case(seed, rng, engine, setup, causes, sizes)


def check_effects(world: AbstractWorld, effects: Sequence[str]) -> None:
    """`InputError` where an effect is no cause of the world, or named twice."""
    known = world.causes()
    if strangers := sorted(set(effects) - set(known)):
        raise InputError(
            f"world '{world.name}' has no cause {', '.join(strangers)}; it has {', '.join(known)}"
        )
    if twice := sorted({name for name in effects if list(effects).count(name) > 1}):
        raise InputError(f"effects: {', '.join(twice)} is named more than once; name each effect once")


def record_case(
    seed: int,
    rng: np.random.Generator,
    world: AbstractWorld,
    setup: Setup,
    causes: dict[str, AbstractCause],
    sizes: dict[str, float],
) -> Case:
    """Record the campaign of a setup with its causes; `rng` goes on from where it drew both with `seed`."""
    acting = list(causes.values())
    trials = record_trials(rng, world, setup, acting)
    sound = tuple(trial.impact for trial in trials if not trial.fault)
    seen = replace(setup, conditions=sound, repeats=1)
    return Case(
        seed=seed,
        world=world.name,
        setup=setup,
        causes=causes,
        sizes=sizes,
        distance=distance(world, seen, acting) if acting else 0.0,
        outside_library=bool(set(causes) & set(world.causes("beyond"))),
        trials=trials,
        held_out=_record_held_out(world, setup, acting),
    )


def record_trials(
    rng: np.random.Generator, world: AbstractWorld, setup: Setup, causes: Sequence[AbstractCause]
) -> tuple[Trial, ...]:
    """Each condition of the setup as often as it repeats, with scatter, jitter and noise; one may be faulty."""
    commanded = [impact for impact in setup.conditions for _ in range(setup.repeats)]
    faulty = int(rng.integers(len(commanded)))
    trials = []
    for i, label in enumerate(commanded):
        scatter = 1.0 + setup.spread * rng.standard_normal(2)
        late = setup.late(rng)
        impact = Impact(label.v_e * scatter[0], label.f_p * scatter[1])
        response = world.respond(setup.rig, causes, impact, setup.time + late, setup.after_loss)
        force = response.sensed + setup.noise.draw(rng, response.sensed.size)
        if setup.ring:
            force += setup.ring.draw(rng, response.time, float(response.sensed.max()))
        time = setup.time[: force.size]
        in_contact = response.time <= response.lost
        fault = setup.fault if i == faulty else ""
        if fault == "dropout":
            first, length = rng.uniform(0.2, 0.5), rng.uniform(0.1, 0.3)
            force[(time >= first * time[-1]) & (time < (first + length) * time[-1])] = 0.0
        if fault == "loose_cable":
            force *= rng.uniform(0.3, 0.7)
        if fault == "wrong_label":
            label = max(setup.conditions, key=lambda other: abs(other.v_e - impact.v_e))
        force = np.round(force / setup.quantum) * setup.quantum
        trials.append(Trial(f"t{i:03d}", label, impact, time, force, float(force[in_contact].max()), fault))
    return tuple(trials)


def _record_held_out(
    world: AbstractWorld, setup: Setup, causes: Sequence[AbstractCause]
) -> tuple[Trial, ...]:
    trials = []
    time = setup.time[setup.time >= 0.0]
    for i, impact in enumerate(setup.held_out):
        response = world.respond(setup.rig, causes, impact, time)
        trials.append(
            Trial(f"h{i:03d}", impact, impact, response.time, response.sensed, float(response.sensed.max()))
        )
    return tuple(trials)
