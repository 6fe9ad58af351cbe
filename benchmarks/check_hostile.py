"""A search for a contact whose force exceeds what `check` allows before its stated end, by an integrator of its own.

python -m benchmarks.check_hostile

For every contact the lowest limit that a check would allow, the force "not exceeded", is held against the largest
force of the equations integrated by another program, in which the flange goes on when its robot stops: contacts that
hold and pull until then, and contacts that are lost and hit again. Where the end is open, a robot stops at any time, at
once or braking, whose contact does not pull. Random contacts, the corners of their box, and an ascent of the ratio from
the worst of both.
"""

import argparse
from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from acf_jax.contact.read import of_rig
from acf_jax.safety.infer import bound, whole
from benchmarks.machine import describe
from benchmarks.peers.numba_contact import largest_forces

# m, zeta of the clamped flange, k_F, k_C, body stiffness, body mass, v_E, F_P, end, deceleration
LOW = np.array([0.3, 1e-3, 1.0, 1e4, 1e4, 0.2, 0.01, 0.0, 2e-3, 1.0])
HIGH = np.array([10.0, 1.5, 1e4, 1e6, 1.5e5, 75.0, 1.5, 300.0, 0.5, 50.0])
LOGARITHMIC = np.array([1, 1, 1, 1, 1, 1, 1, 0, 1, 1], bool)
BRAKES = 8  # the column of the peer's decelerations
MEDIAN = 7.0  # m/s^2, of the decelerations
SLACK = 1e-5  # of a force: the error of the program that it is held against
BLOCK = 512
AFTER, MOST_AFTER = 2.0, 400.0  # periods of contact and of flange after the stop; radians of the contact
ASCENTS, ASCENT_STEPS, STEP = 8, 12, 0.05  # of the box's width
MODEL, CONFIDENCE = (
    of_rig({"m": 1.0, "d": 0.0, "k_f": 0.0, "k_c": 1e5}, {}),
    0.975,
)  # each contact brings its own rig


class Kind(NamedTuple):
    """One kind of contact and of ending."""

    name: str
    is_free: bool
    brakes: bool
    is_open: bool  # its end is not stated


KINDS = (
    Kind("clamped, stop stated", False, False, False),
    Kind("free, stop stated", True, False, False),
    Kind("clamped, braking", False, True, False),
    Kind("free, braking", True, True, False),
    Kind("clamped, k_F = 0, open end", False, False, True),
    Kind("free, open end", True, False, True),
)


def spread_out(unit: np.ndarray) -> np.ndarray:
    """Contacts (n, 10) of points in the unit cube."""
    unit = np.clip(unit, 0.0, 1.0)
    logs = (
        np.log(np.where(LOGARITHMIC, LOW, 1.0)) * (1 - unit) + np.log(np.where(LOGARITHMIC, HIGH, 1.0)) * unit
    )
    return np.where(LOGARITHMIC, np.exp(logs), LOW + unit * (HIGH - LOW))


class Problem(NamedTuple):
    """Contacts as both programs take them."""

    z: np.ndarray  # (n, 6)
    body: np.ndarray  # (n, 2) compliance, mobility
    ending: np.ndarray  # (n, 4)
    peer: np.ndarray  # (n, 10)


def problem(kind: Kind, unit: np.ndarray) -> Problem:
    """The contacts of one kind at points of the unit cube."""
    m, zeta, k_f, k_c, k_h, m_h, v, f_p, end, a = spread_out(unit).T
    k_f = np.zeros_like(k_f) if kind.is_open and not kind.is_free else k_f
    k = 1 / (1 / k_c + 1 / k_h)
    d = 2 * zeta * np.sqrt(m * (k_f + k))
    mobility = 1 / m_h if kind.is_free else np.zeros_like(m)
    infinite = np.full_like(m, np.inf)
    a = np.maximum(a, v / 0.15)  # an integration of seconds tells nothing new
    if kind.is_open:
        a = np.where(a < MEDIAN, a, np.inf)
    elif not kind.brakes:
        a = infinite
    begin = end / 3 if kind.brakes else end
    stated = (infinite, infinite, begin, a) if kind.brakes else (end, infinite, infinite, infinite)
    ending = np.column_stack([infinite] * 4 if kind.is_open else stated)
    omega = np.sqrt((k_f + k) * (1 / m + mobility))
    slow = np.sqrt(np.maximum(k_f, 1e-9) / m)
    after = np.minimum(AFTER * 2 * np.pi * (1 / omega + 1 / slow), MOST_AFTER / omega)
    peer = np.column_stack([m, d, k_f, k, mobility, v, f_p, begin, a, begin + v / a + after])
    return Problem(
        np.column_stack([m, d, k_f, k_c, v, f_p]), np.column_stack([1 / k_h, mobility]), ending, peer
    )


PROGRAMS = {
    is_open: jax.jit(jax.vmap(f(MODEL, CONFIDENCE))) for is_open, f in ((False, whole), (True, bound))
}


def ratios(kind: Kind, unit: np.ndarray) -> np.ndarray:
    """(n,) the true force over the lowest limit that a check would allow; 0 where it allows none."""
    contacts = problem(kind, unit)
    program = PROGRAMS[kind.is_open]
    x = np.hstack([contacts.z, contacts.body, contacts.ending])
    allowed = []
    for start in range(0, len(x), BLOCK):
        part = x[start : start + BLOCK]
        answers = np.asarray(program(jnp.asarray(part[np.arange(BLOCK) % len(part)])))[: len(part)]
        allowed.append(np.where(answers[:, 4] > 0, answers[:, 2], np.inf))
    held = contacts.peer.copy()
    if kind.is_open:  # a body that is stuck to a braking robot is no contact that a check answers for
        held[:, BRAKES] = 0.0
    true = np.maximum(largest_forces(contacts.peer, False)[:, 1], largest_forces(held, True)[:, 1])
    return true / np.concatenate(allowed)


def ascent(kind: Kind, unit: np.ndarray) -> np.ndarray:
    """(n,) the ratios at the end of an ascent along their gradients, by central differences."""
    best, step = ratios(kind, unit), STEP
    for _ in range(ASCENT_STEPS):
        moved = unit[:, None] + 1e-4 * np.concatenate([np.eye(unit.shape[1]), -np.eye(unit.shape[1])])
        up, down = np.split(ratios(kind, moved.reshape(-1, unit.shape[1])).reshape(len(unit), -1), 2, axis=1)
        slope = up - down
        slope /= np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-30)
        tried = np.clip(unit + step * slope, 0.0, 1.0)
        found = ratios(kind, tried)
        is_better = found > best
        unit, best = np.where(is_better[:, None], tried, unit), np.maximum(found, best)
        step = step if is_better.any() else step / 2
    return best


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.check_hostile", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--contacts", type=int, default=100_000, help="random ones, of all kinds together")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    random = np.random.default_rng(options.seed)
    print(f"A force counts as exceeded from {SLACK:.0e} of it on; {describe()}\n")
    print("| contact | tried | allowed at all | largest force over the lowest limit allowed | exceeded |")
    print("|---|--:|--:|--:|--:|")
    corners = np.array(list(product((0.0, 1.0), repeat=LOW.size)))
    exceeded = 0
    for kind in KINDS:
        unit = np.concatenate([random.random((options.contacts // len(KINDS), LOW.size)), corners])
        found = ratios(kind, unit)
        worst = unit[np.argsort(-found)[:ASCENTS]]
        climbed = ascent(kind, worst)
        every = np.concatenate([found, climbed])
        exceeded += int((every > 1 + SLACK).sum())
        tried = len(found) + ASCENTS * ASCENT_STEPS * (2 * LOW.size + 1)
        print(
            f"| {kind.name} | {tried:,} | {(found > 0).mean():.0%} | {every.max():.6f} |"
            f" {(every > 1 + SLACK).sum()} |",
            flush=True,
        )
    if exceeded:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
