"""One small configuration, and one finished run of it that the tests share."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from train import fit

SMALL: dict[str, Any] = {
    "output": "run",
    "seed": 3,
    "features": "fold",
    "compare": ["dimensionless"],
    "ranges": {
        "m": {"low": 0.5, "high": 10, "unit": "kg", "scale": "log"},
        "k_c": {"low": "1e4", "high": "1e6", "unit": "N/m", "scale": "log"},  # as PyYAML reads 1e4
        "k_f": {"low": 0, "high": 1e4, "unit": "N/m"},
        "zeta": {"low": 0, "high": 1.5, "unit": "1"},
        "v_e": {"low": 0.01, "high": 1, "unit": "m/s", "scale": "log"},
        "f_p": {"low": 0, "high": 500, "unit": "N"},
    },
    "samples": {"train": 4096, "held_out": 4096, "test": 4096},
    "network": {"width": 8, "depth": 2},
    "optimiser": {
        "learning_rate": 1e-2,
        "warm_up_steps": 20,
        "steps": 400,
        "batch": 128,
        "steps_per_checkpoint": 20,
    },
    "table1": {"rig": {"m": 4.0, "d": 0, "k_f": 0, "k_c": 175561.0}},
}


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small configuration as a file."""
    path = tmp_path_factory.mktemp("config") / "small.yaml"
    path.write_text(yaml.safe_dump(SMALL), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def finished(small: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a finished run of the small configuration."""
    folder = tmp_path_factory.mktemp("finished") / "run"
    assert fit.main(["--config", str(small), "--set", f"output={folder}"]) == 0
    return folder
