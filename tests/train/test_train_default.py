"""A surrogate of a diagnosis without a configuration: which ranges it learns over, and faults of given ones."""

from pathlib import Path

import numpy as np
import pytest

from acf_jax.cli.main import main
from acf_jax.contact.read import of_diagnosis
from acf_jax.errors import InputError
from acf_jax.gap_model import GapModel, read_model, write_model
from acf_jax.surrogate import load_corrected
from acf_jax.training.default import default_config
from acf_jax.training.domain import make_domain, to_blame, words
from tests.corrected import RIG_STD, gap_model


def uncertain(index: int, std: float) -> GapModel:
    """The model with one of the rig's parameters known less well."""
    gap = gap_model()
    covariance = np.array(gap.corrected.covariance)
    covariance[index, index] = std**2
    corrected = gap.corrected.model_copy(update={"covariance": tuple(map(tuple, covariance.tolist()))})
    return gap.model_copy(update={"corrected": corrected})


def configured(gap: GapModel, **more):
    return default_config(gap, Path("model.json"), Path("out"), **more)


def test_it_learns_what_was_tried_and_five_deviations_of_the_fit():
    gap = gap_model()
    config, model = configured(gap), of_diagnosis(gap)
    domain = make_domain(config, model, model.main.peak)
    assert config.labels.deviations == 5
    assert domain.span("v_e") == gap.v_range and domain.span("f_p") == gap.f_p_range
    assert domain.span("m") == pytest.approx((1.9 - 5 * RIG_STD[0], 1.9 + 5 * RIG_STD[0]))
    lines = words(domain, {"k_c"}, 5).splitlines()
    assert [line.split()[0] for line in lines[1:]] == list(domain.names)
    assert lines[-3].split() == ["v_e", "0.05", "to", "0.35", "m/s", "tried"]
    assert lines[1].endswith("fitted, 5 standard deviations either way") and lines[4].endswith("given")
    assert lines[-1].split() == ["mobility", "0", "1/kg", "a", "wall"]


@pytest.mark.long
def test_a_parameter_that_is_hardly_known_is_learnt_over_fewer_deviations():
    """An actuator as stiff as the contact pushes back for ever: its first peak is then not the largest force."""
    k_f = 3e4
    config = configured(uncertain(2, k_f))
    assert config.labels.deviations < 5
    assert configured(uncertain(2, 3e6)).labels.deviations == 1  # the least; the run then says what is wrong


def test_the_range_that_matters_is_named():
    gap = uncertain(2, 3e4)
    model = of_diagnosis(gap)
    domain = make_domain(configured(gap), model, model.main.peak)
    unit = np.random.default_rng(0).random((500, len(domain.free)))
    column = [domain.names[i] for i in domain.free].index("k_f")
    where, remedy = to_blame(domain, unit, unit[:, column] < 0.3)
    assert where.startswith("ranges.k_f: 0 to ") and where.endswith(" N/m") and remedy == "lower its high end"
    assert to_blame(domain, unit, unit[:, column] > 0.3)[1] == "raise its low end"
    assert to_blame(domain, unit, np.zeros(500, bool)) is None


def train(*arguments: object) -> int:
    with pytest.raises(SystemExit) as end:
        main(["train", *map(str, arguments)])
    return end.value.code


@pytest.fixture(autouse=True)
def _started(monkeypatch):
    monkeypatch.setattr("acf_jax.start.start_jax", lambda: None)  # tests set JAX themselves


@pytest.mark.long
def test_the_command_prints_its_ranges_and_leaves_a_surrogate(tmp_path, capsys):
    (tmp_path / "model.json").write_text(write_model(gap_model()))
    few = ("--samples", 2048, "--steps", 200, "--range", "k_c=4e4,9e4", "--range", "mobility=0,1")
    assert train(tmp_path, "--out", tmp_path / "out", *few) == 0
    said = capsys.readouterr().out
    assert said.startswith("it learns over\n  m  ") and "given" in said and "error bound" in said
    surrogate, model = load_corrected(tmp_path / "out/model.eqx")
    assert surrogate.domain.span("k_c") == (4e4, 9e4) and surrogate.domain.span("mobility") == (0, 1)
    assert surrogate.domain.span("v_e") == (0.05, 0.35)
    assert model == read_model(tmp_path / "model.json").model_dump(mode="json", by_alias=True)


@pytest.mark.parametrize("given, says", [
    (["--range", "k_c"], ["--range k_c: must read NAME=LOW,HIGH"]),
    (["--range", "k_c=1,2,3", "--range", "v_e=a,b"], ["--range k_c=1,2,3: must", "--range v_e=a,b: must"]),
    (["--range", "k_c=9e4,4e4"], ["train: ranges.k_c: low (90000) must be below high (40000)"]),
    (["--range", "k_c=nan,9e4"], ["train: ranges.k_c.low: must be a finite number"]),
    (["--range", "k_c=1e4,2e4", "--range", "v=0.1,0.2", "--range", "v_e=0,0.3"],
     ["ranges.v: is no quantity of the model; known are m, d,", "ranges.k_c: 10000 to 20000 N/m leaves out the fitted",
      "ranges.v_e: low must be above 0"]),
])  # fmt: skip
def test_every_fault_names_its_range(tmp_path, capsys, given, says):
    (tmp_path / "model.json").write_text(write_model(gap_model()))
    assert train(tmp_path, "--out", tmp_path / "out", *given) == 2
    said = capsys.readouterr().err
    assert all(part in said for part in says), said
    assert not (tmp_path / "out").exists()


def test_what_is_no_diagnosis_is_refused(tmp_path, capsys):
    root = Path(__file__).parents[2]
    for path in (root / "configs/check_rig.yaml", root / "examples/rig_surrogate.eqx"):
        assert train(path, "--out", tmp_path / "out") == 2
        assert f"{path}: is no diagnosis; name the folder" in capsys.readouterr().err
    with pytest.raises(InputError, match=r"train: ranges.k_c.high: must be a number"):
        configured(gap_model(), ranges={"k_c": (1.0, "x")})
