"""Figures that stand alone follow the colours that the reader prefers."""

import numpy as np
import plotly.io as pio
import pytest
from needs import need_chromium, need_module

from acf_jax.contact.read import of_rig
from acf_jax.designs.solve import design
from acf_jax.designs.task import make_task
from acf_jax.report.design_plot import write_design_plot
from acf_jax.report.notebook import to_plotly
from acf_jax.report.peak_plot import model_curves, rig_curves, write_force_plot
from acf_jax.report.plot import Variant, plot
from acf_jax.training.charts import Axis, Series, chart
from acf_jax.training.report import write_page
from tests.corrected import gap_model

RIG = {"m": 4.0, "d": 0.0, "k_f": 0.0, "k_c": 175561.0}


def write_training(path):
    lines = [Series("error", [0.0, 1.0], [1.0, 2.0], 0)]
    write_page(path, "run", "", [chart("Training", lines, Axis("step"), Axis("loss"))], None)


def write_design(ranges, limit):
    def write(path):
        fixed = {} if "f_p" in ranges else {"f_p": 100.0}
        task = make_task(of_rig(RIG, {}), ranges, fixed, "fastest", limit, 0.95)
        write_design_plot(path, design(task, starts=2, draws=512))

    return write


def write_peak(path):
    rows = [{"v_e": 0.1, "has_peak": True, "t_max": 3e-3, "f_max": 130.0}]
    write_force_plot(path, rig_curves(RIG, rows, 100.0), rows)


def test_a_force_is_drawn_until_contact_is_lost():
    rows = [{"v_e": v, "has_peak": True, "t_max": 3e-3} for v in (0.05, 0.3)] + [
        {"v_e": 0.2, "has_peak": False}
    ]
    rig = RIG | {"d": 60.0, "k_f": 2000.0}
    for curve in [*rig_curves(rig, rows, 100.0), *model_curves(gap_model(), (0.05, 0.3), 60.0)]:
        assert (curve.force >= 0.0).all() and (np.diff(curve.time) > 0.0).all()
        assert curve.force.max() > curve.force[0] >= 60.0


def test_lost_contact_lies_between_samples():
    slow = rig_curves(RIG, [{"v_e": 0.3, "has_peak": True, "t_max": 9e-3}], 100.0)[0]
    assert slow.force[-1] == 0.0
    omega = np.sqrt(RIG["k_c"] / RIG["m"])  # F = F_P cos + (k_C v/omega) sin of an undamped rig without k_F
    assert slow.time[-1] * omega == pytest.approx(
        np.pi - np.arctan2(100.0, RIG["k_c"] * 0.3 / omega), rel=1e-4
    )


PAGES = {
    "curve": write_design({"v_e": (0.05, 0.5)}, 250.0),
    "map": write_design({"v_e": (0.05, 0.5), "f_p": (80.0, 120.0)}, 250.0),
    "infeasible": write_design({"v_e": (0.2, 0.5), "f_p": (80.0, 120.0)}, 100.0),
    "peak": write_peak,
    "training": write_training,
}
INK = "getComputedStyle([...document.querySelectorAll('svg text')].find(t => t.textContent.length > 2)).fill"
GROUNDS = "[...document.querySelectorAll('.main-svg')].map(x => getComputedStyle(x).backgroundColor)"
GROUND = "getComputedStyle(document.body).backgroundColor"


def lightness(colour: str) -> float:
    red, green, blue = map(float, colour.strip("rgba()").split(",")[:3])
    return (0.3 * red + 0.59 * green + 0.11 * blue) / 255


LATER = ("curve", "infeasible", "peak", "training")  # longer checks: their pages are made as the map's is


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=pytest.mark.long) if kind in LATER else kind for kind in PAGES]
)
def test_text_and_ground_of_a_figure_follow_the_colour_scheme(kind, tmp_path):
    path = tmp_path / "figure.html"
    PAGES[kind](path)
    assert "http:" not in path.read_text().split("<script>")[0]
    with need_module("playwright.sync_api", "pip install playwright").sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=need_chromium(), args=["--no-sandbox"])
        for scheme in ("dark", "light"):
            page = browser.new_context(offline=True, color_scheme=scheme).new_page()
            faults: list[str] = []
            page.on("pageerror", lambda e, faults=faults: faults.append(str(e)))
            page.goto(path.as_uri())
            page.wait_for_selector("svg text")
            ink, ground = lightness(page.evaluate(INK)), lightness(page.evaluate(GROUND))
            assert not faults and abs(ink - ground) > 0.4
            assert ground < 0.2 if scheme == "dark" else ground > 0.9
            assert "rgb(255, 255, 255)" not in page.evaluate(GROUNDS)  # none of its own
        browser.close()


@pytest.mark.parametrize("template, ground, ink", [
    ("plotly_dark", "#101418", "#e6eaee"), ("plotly", "#ffffff", "#1b1f24"), (None, "#ffffff", "#1b1f24"),
])  # fmt: skip
def test_a_figure_of_a_notebook_is_dark_where_plotly_is(monkeypatch, template, ground, ink):
    monkeypatch.setattr(pio.templates, "default", template)
    lines = [{"type": "scatter", "x": [0, 1], "y": [0, 1], "line": {"color": "--measured"}}]
    figure = to_plotly(plot("force", "Force", "", [Variant("", lines)], {}, 300))
    assert figure.layout.paper_bgcolor == figure.layout.plot_bgcolor == ground
    assert figure.data[0].line.color == ink
