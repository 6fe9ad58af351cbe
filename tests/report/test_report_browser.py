"""The page in a real browser: offline, clicked through, on a phone, in the dark."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from needs import need_chromium, need_module

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.document import document
from acf_jax.report import write_report

DESKTOP, PHONE = {"width": 1280, "height": 900}, {"width": 375, "height": 700}


@pytest.fixture(scope="module")
def browser() -> Iterator:  # type: ignore[type-arg]
    path = need_chromium()
    sync_api = need_module("playwright.sync_api", "pip install playwright")
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture
def report(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The address of the report of the diagnosis that the fixture of the given name holds."""
    diagnosis: Diagnosis = request.getfixturevalue(request.param)
    path = tmp_path / "report.html"
    write_report(path, diagnosis, document(diagnosis))
    return path.as_uri()


def opened(browser, report: str, faults: list[str], **options):  # type: ignore[no-untyped-def]
    """The drawn page; what goes wrong on it, and every request that leaves it, is added to `faults`."""
    page = browser.new_context(offline=True, reduced_motion="reduce", **options).new_page()
    page.on("console", lambda m: faults.append(m.text) if m.type in ("error", "warning") else None)
    page.on("pageerror", lambda e: faults.append(str(e)))
    page.on(
        "request",
        lambda r: faults.append(r.url) if not r.url.startswith(("file:", "data:", "blob:")) else None,
    )
    page.goto(report)
    page.wait_for_selector("html[data-drawn]")
    return page


def fits(page) -> bool:  # type: ignore[no-untyped-def]
    return page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


@pytest.mark.parametrize("report", ["unknown", "peaks_only"], indirect=True)
@pytest.mark.long
def test_clicked_through_offline(browser, report: str) -> None:  # type: ignore[no-untyped-def]
    faults: list[str] = []
    page = opened(browser, report, faults, viewport=DESKTOP)
    plots = page.locator(".plot")
    assert plots.count() >= 5
    assert page.locator(".plot .main-svg").count() >= plots.count()
    for choice in page.locator("select").all():
        name = choice.get_attribute("data-plot")
        drawn = f"JSON.stringify(document.getElementById('{name}').data)"
        before = page.evaluate(drawn)
        choice.focus()
        for key in ("End", "Home"):
            page.keyboard.press(key)
        choice.select_option(index=choice.locator("option").count() - 1)
        page.wait_for_function(f"before => {drawn} !== before", arg=before)
    for part in page.locator("details").all():
        part.locator("summary").focus()
        page.keyboard.press("Enter")
        assert part.evaluate("e => e.open")
        assert part.locator("table, ul").first.is_visible()
    for link in page.locator("nav a").all():
        link.click()
        assert page.locator(f"{link.get_attribute('href')} h2").is_visible()
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement !== document.body")
    assert page.title().startswith("Sim-to-real gap")
    assert faults == []


@pytest.mark.parametrize("report", ["unknown"], indirect=True)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_on_a_phone(browser, report: str, scheme: str) -> None:  # type: ignore[no-untyped-def]
    faults: list[str] = []
    phone = {"viewport": PHONE, "is_mobile": True, "has_touch": True}
    page = opened(browser, report, faults, color_scheme=scheme, **phone)
    assert fits(page)
    for part in page.locator("details > summary").all():
        part.tap()
    assert fits(page)
    assert faults == []


@pytest.mark.parametrize("report", ["diagnosed"], indirect=True)
def test_colours_follow_the_room(browser, report: str) -> None:  # type: ignore[no-untyped-def]
    """Page and figures both change when the system turns dark, with text that stands out from the page."""
    faults: list[str] = []
    page = opened(browser, report, faults, viewport=DESKTOP, color_scheme="light")
    brightness = """() => {
        const sum = (c) => c.match(/[0-9.]+/g).slice(0, 3).map(Number).reduce((a, b) => a + b) / 765;
        const text = document.querySelector('#evidence .ytick text');
        return [sum(getComputedStyle(document.body).backgroundColor), sum(getComputedStyle(text).fill)];
    }"""
    ground, text = page.evaluate(brightness)
    assert ground > 0.9 and text < 0.3
    page.emulate_media(color_scheme="dark")
    page.wait_for_function(f"() => ({brightness})()[1] > 0.7")
    assert page.evaluate(brightness)[0] < 0.2
    assert faults == []
