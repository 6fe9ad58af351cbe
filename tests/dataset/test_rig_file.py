"""One rig file for every command: each way to write a parameter, read as values and as a prior."""

from pathlib import Path

import numpy as np
import pytest

import acf_jax as acf
from acf_jax.api.rig import prior_of
from acf_jax.contact.model_file import ModelFile
from acf_jax.dataset.description import read_description
from acf_jax.dataset.rig_file import read_whole_rig
from acf_jax.errors import InputError
from acf_jax.recording.rig import read_rig_file

ROOT = Path(__file__).resolve().parents[2]
LONG = """rig:
  moving_mass_kg: {value: 2.0, std: 0.04}
  damping_n_s_per_m: {value: 60, std: 18}
  actuator_stiffness_n_per_m: {value: 800, std: 400}
  contact_stiffness_n_per_m: {value: 3.4e5, std: 3.4e4}
"""
SHORT = """rig:
  m: {value: 2.0, std: 0.04, unit: kg}
  d: {value: 60, std: 18, unit: N s/m}
  k_f: {value: 800, std: 400}
  k_c: {value: 3.4e5, std: 3.4e4, unit: N/m}
"""
SHARES = "rig: {m: 2.0, d: 60, k_f: 800, k_c: 3.4e5}\nrelative_std: {m: 0.02, d: 0.3, k_f: 0.5, k_c: 0.1}\n"
MIXED = """rig:
  m: 2.0
  damping_n_s_per_m: {value: 60, unit: N s/m}
  k_f: {value: 800, std: 400}
  contact_stiffness_n_per_m: 3.4e5
relative_std: {m: 0.02, d: 0.3, k_c: 0.1, v_e: 0.004}
tried: {v_e: [0.05, 0.35], f_p: [50, 90]}
measurement: {pretension_rel_std: 0.01}
"""


@pytest.fixture
def written(tmp_path):
    def write(text: str) -> Path:
        (tmp_path / "rig.yaml").write_text(text)
        return tmp_path / "rig.yaml"

    return write


@pytest.mark.parametrize("text", [LONG, SHORT, SHARES, MIXED], ids=["long", "short", "shares", "mixed"])
def test_every_way_to_write_it_says_the_same_to_every_command(written, text):
    path = written(text)
    prior = prior_of(path)
    np.testing.assert_allclose(prior.values, [2.0, 60, 800, 3.4e5])
    np.testing.assert_allclose(prior.stds, [0.04, 18, 400, 3.4e4])
    again = read_rig_file(
        written("\n".join(["rig:", *(f"  {k}: {v}" for k, v in read_rig_file(path).rig.items())]))
    )
    assert again.prior == prior  # what an import writes into a data set
    path = written(text)
    model = ModelFile(path).load()
    np.testing.assert_allclose(model.main.theta, [2.0, 60, 800, 3.4e5])
    np.testing.assert_allclose(model.relative[:4], [0.02, 0.3, 0.5, 0.1])
    written(f"schema: acf-gap-dataset/1\ndescription: a rig\n{text}")
    assert read_description(path)[1] == prior and ModelFile(path).rig == {
        "m": 2.0,
        "d": 60,
        "k_f": 800,
        "k_c": 3.4e5,
    }


def test_what_stands_beside_the_rig_goes_where_it_belongs(written):
    path = written(MIXED)
    assert read_rig_file(path).measurement == {"contact_velocity_rel_std": 0.004, "pretension_rel_std": 0.01}
    model = ModelFile(path).load()
    assert model.tried.v_e == (0.05, 0.35)
    np.testing.assert_allclose(model.relative[-2:], [0.004, 0.01])


def test_the_files_of_the_project_serve_every_command():
    for name in ("examples/session_rig.yaml", "examples/rig/dataset.yaml"):
        assert acf.read_model(ROOT / name).speed(60, limit=140, draws=512).v > 0.05
    assert prior_of(ROOT / "configs/check_rig.yaml").stds == pytest.approx([0.038, 12, 240, 3000])
    with pytest.raises(
        InputError, match=r"rig.m: has no standard deviation, .* write m: {value: 4, std: \.\.\.}"
    ):
        prior_of(ROOT / "configs/table1_rig.yaml")


def test_a_deviation_of_a_value_of_zero_counts(written):
    text = "rig: {{m: 2.0, d: {}, k_f: 0, k_c: 3.4e5}}\n"
    known, unknown = (ModelFile(written(text.format(d))).load() for d in ("0", "{value: 0, std: 40}"))
    assert known.main.covariance[1, 1] == 0 and unknown.main.covariance[1, 1] == 1600
    assert unknown.relative[1] == 0


@pytest.mark.parametrize("change, says", [
    (("m: {value: 2.0", "m: {value: 2000"), "rig.m.value: must be at most 100 kg, but is 2000; if it is in g"),
    (("unit: kg", "unit: g"), "rig.m: unit must be kg, but is 'g'; convert the value"),
    (("  d:", "  m_2:"), "rig.m_2: is not a known key"),
    (("  d:", "  moving_mass_kg:"), "rig.moving_mass_kg: says what m says; keep one of the two"),
    (("std: 400", "sd: 400"), "rig.k_f.sd: is not a known key; did you mean 'std'?"),
    (("std: 400", "std: 0"), "rig.k_f.std: must be a number above 0"),
    (("{value: 800, std: 400}", "800"), "rig.k_f: has no standard deviation, which a diagnosis needs; write k_f:"),
    (("{value: 800, std: 400}", "{value: 800}"), "rig.k_f.std: is missing"),
    (("{value: 800, std: 400}", "stiff"), "rig.k_f: must hold `key: value` pairs, but is 'stiff'"),
    (("{value: 800, std: 400}", "true"), "rig.k_f: must hold `key: value` pairs, but is True"),
    (("rig:", "relative_std: {m: 0.02}\nrig:"), "rig.m: std and relative_std.m both say how well it is known"),
    (("rig:", "relative_std: {m: 2, q: 1}\nrig:"), "relative_std.q: is not known; use m, d"),
    (("rig:", "relative_std: {v_e: 0.3}\nrig:"), "relative_std.v_e: must be at most 0.25, but is 0.3"),
    (("rig:", "relative_std: 3\nrig:"), "relative_std: must hold `name: share` pairs"),
    (("rig:", "tried: {v_e: [2, 1], f_p: 3}\nrig:"), "tried.v_e: must be two numbers, the lower first"),
    (("rig:", "x: 1\nrig:"), "x: is not a known key"),
])  # fmt: skip
def test_faults_of_a_prior_name_what_the_user_wrote(written, change, says):
    path = written(SHORT.replace(*change))
    with pytest.raises(InputError) as told:
        prior_of(path)
    assert any(fault.startswith(str(path)) and says in fault for fault in told.value.faults), (
        told.value.faults
    )


@pytest.mark.parametrize("change, says", [
    (("m: {value: 2.0", "m: {value: 2000"), "rig.m: must be at most 100 kg, but is 2000; if it is in g"),
    (("unit: kg", "unit: g"), "rig.m: unit must be kg, but is 'g'; convert the value"),
    (("  d:", "  moving_mass_kg:"), "rig.d: is missing"),
    (("std: 400", "sd: 400"), "rig.k_f: sd: is not known; use value, std and unit"),
    (("std: 400", "std: -1"), "rig.k_f: std must be a number above 0, but is -1"),
    (("{value: 800, std: 400}", "{std: 400}"), "rig.k_f: must be a number, finite and zero or positive, in N/m"),
    (("rig:", "trid: 3\nrig:"), "trid: is not known; did you mean 'tried'?"),
    (("rig:", "k_c: 3.4e5\nrig:"), "k_c: belongs below `rig:`"),
])  # fmt: skip
def test_faults_of_values_name_what_the_user_wrote(written, change, says):
    path = written(SHORT.replace(*change))
    _, faults = read_whole_rig(path)
    assert any(fault.startswith(str(path)) and says in fault for fault in faults), faults
    with pytest.raises(InputError):
        ModelFile(path)


@pytest.mark.parametrize(
    "key, meant", [("k_cc", "k_c"), ("contact_stifness_n_per_m", "contact_stiffness_n_per_m")]
)
def test_a_misspelt_parameter_is_one_fault(tmp_path, key, meant):
    path = tmp_path / "rig.yaml"
    lines = ["m: {value: 2, std: 0.1}", "d: {value: 60, std: 9}", "k_f: {value: 800, std: 90}"]
    path.write_text("\n  ".join(["rig:", *lines, f"{key}: {{value: 3.4e5, std: 4.0e4}}"]) + "\n")
    assert read_whole_rig(path)[1] == [f"{path} rig.{key}: is not known; did you mean {meant!r}?"]
    with pytest.raises(InputError) as error:
        read_rig_file(path)
    assert error.value.faults == [f"{path}: rig.{key}: is not known; did you mean {meant!r}?"]
