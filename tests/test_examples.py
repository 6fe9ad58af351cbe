"""The documentation's example scripts run as they stand."""

import runpy
import sys
from pathlib import Path

import pytest

from tests.few import few_explanations
from tests.needs import need_module

DOCS = Path(__file__).resolve().parents[1] / "docs"
EXAMPLES = DOCS / "examples"
KEPT = ("gravity", "sensor_lag", "sensor_scale")


@pytest.mark.long
def test_diagnose_from_arrays(monkeypatch, tmp_path, capsys):
    need_module("matplotlib")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    figure = tmp_path / "trial.svg"
    monkeypatch.setattr(sys, "argv", ["diagnose_from_arrays.py", "--figure", str(figure)])
    with few_explanations(KEPT, ("unknown_sensor",)):
        values = runpy.run_path(str(EXAMPLES / "diagnose_from_arrays.py"))
    printed = capsys.readouterr().out
    assert "verdict:" in printed and "sensor_scale.gain_error" in printed
    assert len(values["predictions"]) == 2 and "</svg>" in figure.read_text("utf-8")
    assert values["diagnosis"].scored[0].explanation == ("sensor_scale",)


def test_closed_loop_prints_what_the_page_shows(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["closed_loop.py"])
    runpy.run_path(str(EXAMPLES / "closed_loop.py"))
    printed = capsys.readouterr().out
    assert "truth" in printed and printed in (DOCS / "closed_loop.md").read_text("utf-8")
