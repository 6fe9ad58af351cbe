"""From arrays to a diagnosis: what `python -m acf_jax diagnose` does, step by step in Python.

    python -m docs.examples.diagnose_from_arrays [--figure FILE.svg]

Each `# %%` begins a cell for editors that run scripts cell by cell (VS Code, Spyder, Jupytext).
"""

# %% Set-up: the diagnosis needs double precision.
import argparse
from pathlib import Path

import jax
import numpy as np

from acf_jax.dataset import GapDataset, Measurement, Prior, RigPrior, Trace, Trial
from acf_jax.diagnosis import diagnose
from acf_jax.diagnosis.document import document
from acf_jax.diagnosis.results import gap_model
from acf_jax.predict import predict
from validation.worlds import make_case

parser = argparse.ArgumentParser(description="Diagnose impacts that are held in arrays.")
parser.add_argument("--figure", type=Path, help="draw measured and predicted force to this file")
options = parser.parse_args()
jax.config.update("jax_enable_x64", True)

# %% The measurement. Yours comes from files; here a simulator that shares no code with the fitted one plays the rig,
# whose force sensor hides a gain error. All that the diagnosis sees are arrays: time, force, and what was commanded.
case = make_case(seed=21, effects=["sensor_scale"], target=40.0, coloured=False)
velocities = np.array([trial.commanded.v_e for trial in case.trials])  # m/s
pretensions = np.array([trial.commanded.f_p for trial in case.trials])  # N
times = [np.asarray(trial.time, float) for trial in case.trials]  # s, first contact at 0
forces = [np.asarray(trial.force, float) for trial in case.trials]  # N, as the sensor reads

# %% What is known of the rig beforehand: value and standard deviation of each of its four parameters.
m, d, k_f, k_c = (Prior(value, std) for value, std in case.setup.prior)

dataset = GapDataset(
    folder=Path("arrays"),  # where messages say the data come from
    description="impacts of a simulated rig",
    rig=RigPrior(m, d, k_f, k_c),
    measurement=Measurement(contact_velocity_rel_std=0.004, pretension_rel_std=0.004),
    trials=tuple(
        Trial(f"t{i:03d}", float(velocities[i]), float(pretensions[i]), trace=Trace(times[i], forces[i]))
        for i in range(len(times))
    ),
)

# %% The diagnosis: half a minute where its programs have to be compiled.
diagnosis = diagnose(dataset)
print("verdict:", diagnosis.verdict)
for scored in diagnosis.scored[:3]:
    print(f"  {scored.probability:.3f}  {' and '.join(scored.explanation) or 'nothing unmodelled'}")

# %% How far the gap shrinks on conditions that the fit did not see, N (RMS).
for name, gap in diagnosis.gap.items():
    print(f"{name:>12}: {gap.force_rms_n:.2f} N")
print(f"{'noise floor':>12}: {diagnosis.noise_floor_rms_n:.2f} N")

# %% The content of diagnosis.json, for example the parameters with their standard deviations.
for name, parameter in document(diagnosis)["parameters"].items():
    print(f"{name}: {parameter['value']:.4g} ± {parameter['std']:.2g} {parameter['unit']}")

# %% Predict what was never tried: what the sensor will read, and what will act at the contact.
model = gap_model(diagnosis)
new_v, new_f = np.array([0.15, 0.25]), np.array([75.0, 75.0])
predictions = predict(model, v_e=new_v, f_p=new_f)
for v, p in zip(new_v, predictions, strict=True):
    print(
        f"{v:.2f} m/s: {p.peak_force:.0f} ± {p.peak_force_std:.0f} N read, {p.contact_peak_force:.0f} N at the contact"
    )

# %% Look at one trial: measured, the paper's model refitted, and corrected; both did not see its condition.
if options.figure:
    import matplotlib.pyplot as plt

    fastest = int(np.argmax(diagnosis.observations.v_e))
    used = diagnosis.observations.used[fastest]
    time = 1e3 * diagnosis.observations.time[fastest, used]
    force = diagnosis.observations.force[fastest, used]
    figure, axes = plt.subplots(layout="constrained")
    axes.plot(time, force, ".", color="0.4", label="measured")
    for name in ("recalibrated", "corrected"):
        axes.plot(time, force - diagnosis.held[name].residual[fastest, used], label=name)
    axes.set(xlabel="time since contact, ms", ylabel="sensed force, N")
    axes.legend(frameon=False)
    figure.savefig(options.figure)
