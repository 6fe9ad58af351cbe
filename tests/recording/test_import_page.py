"""The page of the cuts in a real browser: offline, on a phone, in the dark."""

import pytest
from sessions import FEW, as_series, made

from acf_jax.recording import Mapping, find_impacts
from acf_jax.recording.page import import_page
from acf_jax.recording.session import Session
from tests.report.test_report_browser import DESKTOP, PHONE, browser, fits, opened

__all__ = ["browser"]  # a fixture


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    force, velocity, pretension = as_series(made(7, FEW, rate=4000.0))
    path = tmp_path_factory.mktemp("page") / "import.html"
    session = Session(
        path, force, velocity, False, pretension, {"force": "a", "speed": "b", "pretension": "c"}, ()
    )
    path.write_text(import_page(find_impacts(session, Mapping().contacts, None), "cuts.yaml", "my_rig"))
    return path.as_uri()


def test_every_cut_can_be_looked_at(browser, address):
    faults = []
    page = opened(browser, address, faults, viewport=DESKTOP)
    data = "id => document.getElementById(id).data"
    marks = next(t for t in page.evaluate(data, "whole") if t["name"] == "kept")
    assert len(marks["x"]) == len(FEW)
    choice = page.locator("select")
    assert choice.locator("option").count() == len(FEW)
    for i in range(len(FEW)):
        choice.select_option(index=i)
        shown = "top => Math.abs(Math.max(...document.getElementById('cut').data[0].y) / top - 1) < 1e-4"
        page.wait_for_function(shown, arg=marks["y"][i])
        x = page.evaluate(data, "cut")[0]["x"]
        assert x[0] < 0 < x[-1]
    assert page.locator("tbody tr").count() == len(FEW) and faults == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_on_a_phone(browser, address, scheme):
    faults = []
    phone = {"viewport": PHONE, "is_mobile": True, "has_touch": True}
    page = opened(browser, address, faults, color_scheme=scheme, **phone)
    assert fits(page) and faults == []
