"""Small synthetic copies of the public repositories: the worlds' impacts in each repository's rates and file format."""

import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.io import savemat

from benchmarks.measured.recorded import STANDARD_GRAVITY, Array
from benchmarks.measured.rigs import cognifly, cone, jku, pads, pcb_beam, pcb_disc
from validation.worlds.interface import Impact, Rig, find_world
from validation.worlds.scipy_world.causes.library.fixture_mass import FixtureMass
from validation.worlds.scipy_world.causes.library.pad_bottoming import PadBottoming

WORLD = find_world("scipy")


def impact(rig: Rig, causes: list, v_e: float, f_p: float, time: Array) -> Array:
    """The sensed force at each time, N; zero once contact is lost."""
    force = WORLD.respond(rig, causes, Impact(v_e, f_p), time, after_loss=1.0).sensed
    return np.pad(force, (0, time.size - force.size))


def clock(rate: float, before: float, after: float) -> Array:
    return np.arange(-round(before * rate), round(after * rate) + 1) / rate


def _soft(rig: Rig, v_e: float, wall: float = 6.0) -> list:
    """A pad that is flat after six tenths of the way that it would go."""
    way = 0.6 * v_e * np.sqrt(rig.m / rig.k_c)
    return [PadBottoming(compression=way, stiffness=wall * rig.k_c, width=0.05 * way)]


def write_jku(copy: Path) -> None:
    rig, causes = Rig(4.7, 100.0, 8e3, 1.5e5), [FixtureMass(mass=1.0, stiffness=1.2e7, damping=200.0)]
    time, moved = clock(1250.0, 0.3, 0.3), clock(500.0, 0.3, 0.4)
    for label in (15, 35, 55):
        for ramp, zero in (("0.0", 0), ("0.1", 10)):
            for speed in ("0.10", "0.25"):
                name = (
                    f"m_6.86_ramp_profile_ACF_control_F_{label}N_t_ramp_{ramp}s-F_zero_{zero}N_v_{speed}_1_"
                )
                force = impact(rig, causes, float(speed), float(zero or label), time)
                dip = 1.0 - 0.2 * np.clip(moved / 0.02, 0.0, 1.0)
                folder = copy / jku.PLOTS
                write_plot(folder / f"TcpUR_FzATI/ACF/{name}forceATI-TcpUR_FzATI.pdf", time, force)
                write_plot(folder / f"velocityUR/ACF/{name}velocityUR.pdf", moved, float(speed) * dip)


def write_plot(path: Path, time: Array, values: Array) -> None:
    """A page of drawing commands as pgfplots makes them: grids, a frame, labels, a clip, the curve."""
    a, b = 200.0, 50.0 / np.abs(values).max()
    ticks_x, ticks_y = (-0.2, 0.0, 0.2), (0.0, 0.1 * np.abs(values).max().round(1))
    commands = [f"{a * x:.5f} -10 m\n{a * x:.5f} 90 l" for x in ticks_x] + ["S"]
    commands += [f"-80 {b * y:.5f} m\n80 {b * y:.5f} l" for y in ticks_y] + ["S"]
    commands += ["-80 -10 m", "-80 90 l", "80 90 l", "h", "S"]
    labels = [str(x).replace("-", "\\000").replace(".", ":") for x in ticks_x]
    labels += [f"{y * 1000:g}\\00110\\0003".replace(".", ":") for y in ticks_y]
    commands += [f"BT\n1 0 0 1 0 0 Tm [({label})]TJ\nET" for label in labels]
    commands += ["-80 -10 m", "80 -10 l", "h", "W", "n"]
    points = [f"{a * x:.5f} {b * y:.5f}" for x, y in zip(time, values, strict=True)]
    commands += [f"{points[0]} m", *(f"{p} l" for p in points[1:]), "S"]
    path.parent.mkdir(parents=True, exist_ok=True)
    page = zlib.compress("\n".join(commands).encode("latin1"))
    path.write_bytes(b"%PDF-1.5\n4 0 obj\nstream\n" + page + b"\nendstream\n")


def write_cognifly(copy: Path) -> None:
    rig = Rig(cognifly.MASS, 0.0, 0.0, 7040.0)
    time = clock(1000.0, 0.2, 0.1)
    for height in cognifly.HEIGHTS:
        folder = copy / f"SoftBottom_{100 * height:.0f}cm"
        folder.mkdir(parents=True)
        v_e = float(np.sqrt(2 * STANDARD_GRAVITY * height))
        g = impact(rig, _soft(rig, v_e), v_e, 0.0, time) / rig.m / STANDARD_GRAVITY
        for drop in range(cognifly.DROPS + 1):
            samples = np.full(time.size, 2020, cognifly.SAMPLE)
            samples["time"] = np.round(1e6 * (time - time[0])).astype(int)
            samples["z"] = np.round(
                cognifly.ZERO + cognifly.COUNTS_PER_G * (g + 0.1 * np.sin(7 * time + drop))
            )
            (folder / f"acc_a-{drop}.bin").write_bytes(samples.tobytes() + b"\0\0\0")


def write_pads(copy: Path) -> None:
    rig, time = Rig(0.5, 0.0, 0.0, 66.0), clock(100.0, 2.0, 1.0)
    force = impact(rig, _soft(rig, 0.87, 1.0), 0.87, 0.0, time)
    names = ("Time (s)", "Force (N)", "Position (m)", "Velocity (m/s)", "Acceleration (m/s²)")
    header = ",".join(f'"Run {run}: {name}"' for run in (5, 1, 2, 3, 4) for name in names)
    rows = []
    for i, (t, f) in enumerate(zip(time, force, strict=True)):
        velocity = "0.87,," if i % 4 == 0 and t < 0 else ",,"
        rows.append(",".join([f"{t + 3.0:.2f},{-f:.4f},,{velocity}"[:-1]] * 5))
    path = copy / pads.FILE
    path.parent.mkdir(parents=True)
    path.write_text("\n".join([header, *rows]) + "\n", "utf-8")


def write_pcb(copy: Path) -> None:
    """Both shock tests of one repository: the disc and the beam."""
    rig = Rig(pcb_disc.MASS, 0.0, 0.0, 2e7)
    ring = [FixtureMass(mass=0.2, stiffness=0.2 * (2 * np.pi * 4200) ** 2, damping=100.0)]
    time = clock(51200.0, 0.03, 0.02)
    base, board = (impact(rig, c, 3.0, 0.0, time) / rig.m for c in ([], ring))
    folder = copy / pcb_disc.FOLDER
    folder.mkdir(parents=True)
    for test in (*pcb_disc.CLEAN, *pcb_disc.FAULTY):
        offset = 1e5 if test in pcb_disc.FAULTY else 0.0
        rows = (
            f"{t:.6E},{a + offset:.3f},{b + offset:.3f},," for t, a, b in zip(time, base, board, strict=True)
        )
        text = "\n".join(["LabVIEW Measurement,"] * 23 + ["X_Value,a,b,Comment", *rows])
        (folder / f"Test_{test:03d}.lvm").write_text(text, "utf-8")
    rig = Rig(1.0, 0.0, 0.0, 1e8)
    ring = [FixtureMass(mass=0.2, stiffness=0.2 * (2 * np.pi * 800) ** 2, damping=50.0)]
    folder = copy / pcb_beam.FOLDER
    folder.mkdir(parents=True)
    for shock in range(pcb_beam.SHOCKS):
        for channel, causes, sign, before in (("base", [], 1, 0.0008), ("pcb", ring, -1, 0.01)):
            time = clock(50000.0, before, 0.02)
            g = sign * impact(rig, causes, 0.8, 0.0, time) / STANDARD_GRAVITY
            g = np.clip(g, -546.4, 546.4)
            np.savetxt(folder / f"acc_{channel}_a{shock}.txt", np.c_[time - time[0], g], header="time(s), g")


def write_cone(copy: Path) -> None:
    copy.mkdir(parents=True)
    time = clock(4032.0, 0.2, 0.1)
    for _, joint, angle, _ in cone.SETS:
        for height in cone.HEIGHTS:
            v_e = np.sqrt(2 * STANDARD_GRAVITY * float(height) / 100)
            rig = Rig(cone.BODY + cone.NOSE[joint], 0.0, 0.0, 4000.0)
            g = impact(rig, [], float(v_e), 0.0, time) / rig.m / STANDARD_GRAVITY
            table = np.c_[time, g, 0 * g, 0 * g]
            name = f"S{joint}{angle}{height}"
            savemat(copy / f"{name}.mat", {f"{name}{run}": table for run in range(1, cone.REPEATS + 2)})


def write_amh(copy: Path) -> None:
    (copy / "calibration").mkdir(parents=True)
    speed = np.arange(0, 2500, 5)
    for tip, power in (("blue", 1.3), ("white", 1.0)):
        peak = np.round(500 * (speed / 2500) ** power)
        arrays = [f"{n} = np.array([\n    # numbers\n    {','.join(map(str, a.tolist()))}\n# more\n])" for n, a in
                  (("excitations_data", peak), ("speeds_data", speed))]  # fmt: skip
        text = "\n".join(["import RPi.GPIO as GPIO", *arrays])
        (copy / f"calibration/AMH_{tip}tip.py").write_text(text, "utf-8")


TWINS: dict[str, Callable[[Path], None]] = {
    "ur10e_force_control_comparison": write_jku,
    "CrashLandingExperiments": write_cognifly,
    "spongebobs-corpse": write_pads,
    "Dataset-5-Extended-Impact-Testing": write_pcb,
    "TwoBodyConeImpactData": write_cone,
    "AMH-ISMA": write_amh,
}
