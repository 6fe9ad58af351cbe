"""Faults of a configuration: all at once, each with its dotted path and a remedy."""

from pathlib import Path

import pytest
import yaml

from acf_jax.errors import InputError
from acf_jax.training.config import read_config, to_yaml
from train import fit

REPOSITORY = Path(__file__).parents[2]


def test_lists_every_fault_at_once(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    changes = [
        "ranges.m.low=20",
        "ranges.k_c.unit=N/mm",
        "ranges.v_e.low=0",
        "ranges.zeta.scale=cubic",
        "ranges.mass=1",
        "optimiser.steps=many",
        "optimiser.warm_up_steps=-1",
        "network.width=0",
        "features=magic",
        "seed=.nan",
        "samples=[]",
        "no equals sign",
        "seed.deeper=1",
    ]
    arguments = ["--config", str(small)]
    for change in changes:
        arguments += ["--set", change]
    assert fit.main(arguments) == 2
    shown = capsys.readouterr().err
    expected = (
        "ranges.m: low (20) must be below high (10); swap or widen them",
        "ranges.k_c: unit must be N/m, but is N/mm; convert the range to N/m",
        "ranges.v_e: a log scale cannot start at 0; raise low or use scale: linear",
        "ranges.zeta.scale:",
        "ranges.mass: is not a known key; remove it",
        "optimiser.steps:",
        "optimiser.warm_up_steps:",
        "network.width:",
        "features:",
        "seed:",
        "samples:",
        "--set no equals sign: must read key=value",
        "--set seed.deeper=1: 'seed' has no keys below it",
    )
    for text in expected:
        assert text in shown, text
    assert "Traceback" not in shown


def test_missing_keys_are_named(tmp_path: Path) -> None:
    path = tmp_path / "empty.yaml"
    path.write_text("output: run\n", encoding="utf-8")
    with pytest.raises(InputError) as error:
        read_config(path)
    missing = {fault.split(": ")[1] for fault in error.value.faults}
    assert missing == {"ranges", "samples", "network", "optimiser"}
    assert all("is missing; add it" in fault for fault in error.value.faults)


def test_rig_file_that_is_not_there(small: Path) -> None:
    with pytest.raises(InputError, match=r"table1: .*nowhere.yaml: no such file"):
        read_config(small, ("table1=nowhere.yaml",))


def test_rig_file_that_says_how_well_it_is_known(small: Path) -> None:
    rig = REPOSITORY / "configs" / "check_rig.yaml"
    table1 = read_config(small, (f"table1={rig}",)).table1
    assert table1 is not None and table1.rig.m == 1.9


@pytest.mark.parametrize("text", ["[1, 2]", "a: [", "a: 1\na: 2", ""])
def test_files_that_hold_no_configuration(tmp_path: Path, text: str) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(text, encoding="utf-8")
    assert fit.main(["--config", str(path)]) == 2


def test_numbers_that_yaml_reads_as_text(small: Path) -> None:
    config = read_config(small, ("optimiser.learning_rate=1e-3",))
    assert config.optimiser.learning_rate == 1e-3
    assert config.ranges.k_c.low == 1e4


@pytest.mark.parametrize("name", ["table1.yaml", "wide_box.yaml"])
def test_shipped_configurations_survive_a_round_trip(name: str, tmp_path: Path) -> None:
    config = read_config(REPOSITORY / "configs" / name)
    resolved = tmp_path / "config.yaml"
    resolved.write_text(to_yaml(config), encoding="utf-8")
    assert read_config(resolved) == config
    assert yaml.safe_load(to_yaml(config))["optimiser"]["final_fraction"] == config.optimiser.final_fraction


def test_a_device_that_jax_does_not_have_is_one_message(
    small: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def none() -> None:
        raise RuntimeError("Unknown backend\nand more")

    monkeypatch.setenv("JAX_PLATFORM_NAME", "gpu")
    monkeypatch.setattr("jax.devices", none)
    assert fit.main(["--config", str(small)]) == 2
    assert capsys.readouterr() == (
        "",
        "error: JAX_PLATFORM_NAME='gpu': JAX has no such device here (Unknown backend); unset the variable, set it to"
        " cpu, or install JAX for that device\n",
    )
    monkeypatch.delenv("JAX_PLATFORM_NAME")
    assert fit.main(["--config", str(small)]) == 2
    assert "error: JAX finds no device (Unknown backend); set JAX_PLATFORMS=cpu" in capsys.readouterr().err


def test_a_model_is_found_beside_the_configuration(tmp_path, monkeypatch):
    """As a rig's file is; the configuration that a run keeps elsewhere names the same model."""
    (tmp_path / "a").mkdir()
    content = yaml.safe_load((REPOSITORY / "configs/closed_loop.yaml").read_text())
    content |= {"labels": {"model": "../model.json"}}
    (tmp_path / "a/config.yaml").write_text(yaml.safe_dump(content))
    config = read_config(tmp_path / "a/config.yaml")
    assert config.labels.model == tmp_path / "model.json"
    (tmp_path / "kept.yaml").write_text(to_yaml(config))
    assert read_config(tmp_path / "kept.yaml").labels.model == tmp_path / "model.json"
    monkeypatch.chdir(tmp_path)
    asked = read_config(tmp_path / "a/config.yaml", ("labels.model=other.json",))
    assert asked.labels.model == Path("other.json")
