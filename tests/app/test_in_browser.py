"""Every step clicked through in a real browser that reaches nothing but the app."""

import json
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from needs import need_module
from served import Served, served

from tests.report.test_report_browser import DESKTOP, PHONE, browser

__all__ = ["browser"]  # a fixture

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
LOOKS = [("desktop", "light"), ("phone", "dark"), ("desktop", "dark"), ("phone", "light")]
RIG = {
    "m": ("1.74762", "0.0347509"), "d": ("72.004", "16.7033"), "k_f": ("3.96258", "1.43605"),
    "k_c": ("112.184", "12.0283"),
}  # fmt: skip
PATIENCE = 300_000  # ms, of a step that computes: a limit, not a wait


class Looker:
    """A page that notes what goes wrong, and every address that is asked for; its network ends at this machine."""

    def __init__(self, browser: Any, app: Served, size: str = "desktop", scheme: str = "light"):
        phone = {"viewport": PHONE, "is_mobile": True, "has_touch": True}
        self.context = browser.new_context(
            reduced_motion="reduce",
            color_scheme=scheme,
            proxy={"server": "http://127.0.0.1:9", "bypass": "127.0.0.1"},  # nothing answers there
            **(phone if size == "phone" else {"viewport": DESKTOP}),
        )
        self.app, self.page = app, self.context.new_page()
        self.faults: list[str] = []
        self.asked: list[str] = []
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("console", lambda m: self.faults.append(m.text) if m.type == "error" else None)
        self.context.on("request", lambda request: self.asked.append(request.url))
        self.page.set_default_timeout(PATIENCE)
        self.page.goto(app.address)

    def fits(self) -> bool:
        """Nothing has to be scrolled sideways."""
        return bool(self.page.evaluate("document.documentElement.scrollWidth <= window.innerWidth"))

    def tab_to(self, selector: str) -> None:
        """Press Tab until the focus is there; it is always to be seen."""
        self.page.wait_for_load_state()
        focused = self.page.locator(":focus")  # it waits where the page is about to be another
        for _ in range(200):
            self.page.keyboard.press("Tab")
            if self.page.locator(f":is({selector}):focus").count():
                outline = focused.evaluate("e => getComputedStyle(e).outlineStyle")
                assert outline != "none"
                return
        raise AssertionError(f"Tab does not lead to {selector}")

    def done(self) -> None:
        """Nothing went wrong, and nothing outside was asked for."""
        self.context.close()
        assert self.faults == []
        away = [url for url in self.asked if not url.startswith((self.app.origin + "/", "data:", "blob:"))]
        assert away == [] and self.asked


def expect(of: Any) -> Any:
    wait = need_module("playwright.sync_api").expect
    wait.set_options(timeout=PATIENCE)
    return wait(of)


def cut_frame(page: Any) -> Any:
    frame = page.frame_locator("iframe.embedded")
    expect(frame.locator("html[data-drawn]")).to_be_attached()
    return frame


def reach(frame: Any, mark: Any) -> None:
    """Move the pointer to a mark until its frame notices: Chromium drops input to a frame that has just moved."""
    for tried in range(100):
        mark.hover(force=True, position={"x": 3 + tried % 2, "y": 4})
        if frame.locator("#whole:hover").count():
            return
        mark.page.wait_for_timeout(200)
    raise AssertionError("the frame never noticed the pointer")


def fill_rig(page: Any) -> None:
    for name, (value, std) in RIG.items():
        page.fill(f"#{name}-value", value)
        page.fill(f"#{name}-std", std)


@pytest.fixture(scope="module")
def ready(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """An app with a session that has a model to use; its diagnosis.json says only the verdict."""
    home = tmp_path_factory.mktemp("ready")
    shutil.copytree(EXAMPLES / "rig", home / "known/data")
    (home / "known/diagnosis").mkdir()
    shutil.copy(EXAMPLES / "rig_model.json", home / "known/diagnosis/model.json")
    (home / "known/diagnosis/diagnosis.json").write_text(json.dumps({"verdict": "identified"}))
    with served(home, EXAMPLES) as app:
        yield app


@pytest.mark.parametrize("size, scheme", LOOKS[:2])
@pytest.mark.long
def test_a_wrong_sign_from_file_to_rig(
    browser: Any, app: Served, wrong_sign: Path, size: str, scheme: str
) -> None:
    looker = Looker(browser, app, size, scheme)
    page = looker.page
    page.set_input_files("#files", wrong_sign)
    page.wait_for_url("**/open")
    page.click("[data-preview=force]")
    said = page.locator("#preview-said")
    expect(said).to_contain_text("samples")
    assert float(re.search(r"; (-?[\d.]+) to", said.inner_text())[1]) < -50  # type: ignore[index]
    assert looker.fits()
    page.click("text=Find the contacts")
    expect(page.get_by_text("is negative in contact").first).to_be_visible(timeout=PATIENCE)
    page.click("text=Turn the sign of the force, and cut again")
    frame = cut_frame(page)
    expect(frame.locator(".verdict")).to_contain_text("All 8 contacts")
    assert looker.fits()
    page.click("text=Describe the rig")
    fill_rig(page)
    assert looker.fits()
    page.click("text=Save the rig")
    page.wait_for_url("**/cut")
    expect(page.locator("a.first", has_text="Diagnose")).to_be_visible(timeout=PATIENCE)
    page.goto(page.url.replace("/cut", "/open"))
    assert page.is_checked("#force-turned")
    looker.done()


def drop(page: Any, path: Path) -> None:
    """Let a file or folder of the disk fall onto the field, as the browser gets it from the desktop."""
    box = page.locator("#drop").bounding_box()
    at = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
    mouse = page.context.new_cdp_session(page)
    carried = {"items": [], "files": [str(path)], "dragOperationsMask": 1}
    for kind in ("dragEnter", "dragOver", "drop"):
        mouse.send("Input.dispatchDragEvent", {"type": kind, **at, "data": carried})
        if kind == "dragOver":
            expect(page.locator("#drop")).to_have_class("drop over")
    mouse.detach()


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory, wrong_sign: Path) -> dict[str, Path]:
    """What people drop."""
    from scipy.io import savemat

    from tests.recording.sessions import FEW, columns, made, small

    folder = tmp_path_factory.mktemp("dropped")
    savemat(folder / "logged.mat", columns(made(7, FEW, rate=4000.0)))
    for files, kind in (("a bag", "mcap"), ("an older bag", "db3")):
        (folder / files).mkdir()
        for name, content in small(kind).items():
            (folder / files / name).write_bytes(content)
    (folder / "a bag/.hidden").touch()
    (folder / "nothing").mkdir()
    return {
        "mcap": EXAMPLES / "session.mcap",
        "bag": folder / "a bag",
        "db3": folder / "an older bag",
        "csv": wrong_sign,
        "mat": folder / "logged.mat",
        "nothing": folder / "nothing",
    }


@pytest.mark.parametrize(
    "kind, way, session, force",
    [
        ("mcap", "dropped", "session", "/flange/wrench:wrench.force.z"),
        ("bag", "dropped", "a bag", "/ft/wrench:wrench.force.z"),
        ("bag", "chosen", "a bag", "/ft/wrench:wrench.force.z"),
        ("db3", "dropped", "an older bag", "/ft/wrench:wrench.force.z"),
        ("csv", "dropped", "pressed", "force_n"),
        ("mat", "dropped", "logged", "force_n"),
    ],
)
@pytest.mark.long
def test_a_recording_is_dropped_or_chosen(
    browser: Any, tmp_path: Path, recordings: dict[str, Path], kind: str, way: str, session: str, force: str
) -> None:
    with served(tmp_path) as app:
        looker = Looker(browser, app)
        page, path = looker.page, recordings[kind]
        if way == "dropped":
            drop(page, path)
        else:
            page.set_input_files("#folder", path)
        page.wait_for_url(f"**/{session.replace(' ', '%20')}/open")
        sent = {file.name: file.read_bytes() for file in (tmp_path / session / "recording").iterdir()}
        files = [file for file in path.iterdir() if file.name[0] != "."] if path.is_dir() else [path]
        assert sent == {file.name: file.read_bytes() for file in files}
        expect(page.locator("#preview")).to_be_hidden()  # it would be empty
        page.get_by_role("button", name=f"force: take {force}").click()
        said = page.locator("#preview-said")
        expect(said).to_contain_text("samples")
        least, most = map(float, re.search(r"; (-?[\d.]+) to (-?[\d.]+)", said.inner_text()).groups())  # type: ignore[union-attr]
        assert (least < -50) == (kind == "csv") and (most > 50) == (kind != "csv")
        expect(page.locator("#preview .trace")).to_be_visible()
        if kind == "mat":
            page.click("text=Find the contacts")
            expect(cut_frame(page).locator(".verdict")).to_contain_text("All 8 contacts")
        looker.done()


def test_what_is_dropped_may_be_no_recording(browser: Any, app: Served, recordings: dict[str, Path]) -> None:
    looker = Looker(browser, app)
    page, before = looker.page, set(app.home.iterdir())
    drop(page, recordings["nothing"])
    expect(page.locator("#upload-said")).to_contain_text("nothing: holds no files")
    expect(page.locator("#upload-progress")).to_be_hidden()
    assert set(app.home.iterdir()) == before
    looker.done()


@pytest.mark.long
def test_cuts_are_dropped_by_a_click_moved_by_a_drag_and_saved(
    browser: Any, app: Served, wrong_sign: Path
) -> None:
    name = f"sign {os.urandom(3).hex()}"
    (app.home / name).mkdir()
    recording = shutil.copy(wrong_sign, app.home / f"{name}.csv")
    (app.home / name / "session.yaml").write_text(
        f"schema: acf-session/1\nrecording: {json.dumps(str(recording))}\n"
    )
    (app.home / name / "mapping.yaml").write_text("force: -1*force_n\n")
    looker = Looker(browser, app)
    page = looker.page
    page.set_viewport_size({"width": 1280, "height": 3600})  # the whole frame is drawn
    page.goto(f"{app.origin}/s/0/{name}/open")
    page.click("text=Find the contacts")
    frame = cut_frame(page)
    save = frame.locator("#save-cuts")
    expect(save).to_be_disabled()
    # all cuts lie over one another from contact, one line each
    assert frame.locator("#all .scatterlayer .trace").count() == 8
    # a click on the third mark drops it
    mark = frame.locator("#whole .scatterlayer .points path").nth(2)
    reach(frame, mark)
    mark.click(force=True)
    expect(frame.locator("#cuts-said")).to_contain_text("t002: not kept")
    # the upright line of the first cut is dragged to the right
    line = frame.locator("#cut .shapelayer path[data-index='0']")
    before = float(frame.locator("[data-contact=t000]").input_value())
    box = line.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + 12, box["y"] + box["height"] / 2, steps=6)
    page.mouse.up()
    expect(frame.locator("#cuts-said")).to_contain_text("t000: kept, at")
    moved = float(frame.locator("[data-contact=t000]").input_value())
    assert 0.0 < moved - before < 0.01
    # and the last is typed
    frame.locator("[data-contact=t007]").fill(
        f"{float(frame.locator('[data-contact=t007]').input_value()) + 1e-3:.6f}"
    )
    frame.locator("[data-contact=t007]").blur()
    save.click()
    expect(page.get_by_text("Forget what was decided")).to_be_visible(timeout=PATIENCE)
    rows = (app.home / name / "data/trials.csv").read_text().splitlines()[1:]
    contact = {row.split(",")[0]: float(row.split(",")[-1]) for row in rows}
    assert "t002" not in contact and contact["t000"] == pytest.approx(moved, abs=2e-6)
    assert "keep: false" in (app.home / name / "cuts.yaml").read_text()
    looker.done()


def test_a_page_of_the_command_saves_cuts_by_itself(
    browser: Any, app: Served, wrong_sign: Path, tmp_path: Path
) -> None:
    """import.html from the disk, without the app: the button saves the same file."""
    from click.testing import CliRunner

    from acf_jax.cli.main import commands

    arguments = ["import", str(wrong_sign), "--force", "-1*force_n", "--out", str(tmp_path / "set")]
    assert CliRunner().invoke(commands, arguments).exit_code == 0
    page = browser.new_page(viewport=DESKTOP)
    page.goto((tmp_path / "set/import.html").as_uri())
    page.locator("html[data-drawn]").wait_for(state="attached")
    page.uncheck("[data-keep=t001]")
    with page.expect_download(timeout=PATIENCE) as download:
        page.click("#save-cuts")
    download.value.save_as(tmp_path / "cuts.yaml")
    page.close()
    again = CliRunner().invoke(commands, [*arguments, "--review", str(tmp_path / "cuts.yaml")])
    assert again.exit_code == 0 and again.output.startswith("8 contacts") and "7 kept" in again.output


@pytest.mark.long
def test_the_keyboard_is_enough_for_every_step(browser: Any, ready: Served, wrong_sign: Path) -> None:
    """No wait is on a clock: each is on what the page shows."""
    looker = Looker(browser, ready)
    page, keys, to = looker.page, looker.page.keyboard, looker.tab_to
    # 1 Open
    to(".skip")
    to("#files")
    with page.expect_file_chooser(timeout=PATIENCE) as chooser:
        keys.press("Enter")  # Chromium 156 without a window opens none by Space
    chooser.value.set_files(wrong_sign)
    page.wait_for_url("**/open")
    to("#force-unit")
    to("#force-turned")
    keys.press("Space")
    to("form#signals button.first")
    keys.press("Enter")
    # 2 Cut: into the page of the import; drop a cut, type where another begins, save
    page.wait_for_url("**/cut")
    frame = cut_frame(page)
    to("a.button.first")
    keys.press("Tab")
    for _ in range(400):
        keys.press("Tab")
        if frame.locator("[data-contact=t003]:focus").count():
            break
    keys.press("ArrowUp")
    expect(frame.locator("#cuts-said")).to_contain_text("t003")
    keys.press("Tab")
    keys.press("Space")
    expect(frame.locator("#cuts-said")).to_contain_text("t003: not kept")
    for _ in range(400):
        keys.press("Shift+Tab")
        if frame.locator("#save-cuts:focus").count():
            break
    keys.press("Enter")
    expect(page.get_by_text("Forget what was decided")).to_be_visible(timeout=PATIENCE)
    # 3 Rig
    to("a.button.first")
    keys.press("Enter")
    page.wait_for_url("**/rig")
    for name, (value, std) in RIG.items():
        for field, text in ((f"#{name}-value", value), (f"#{name}-std", std)):
            to(field)
            keys.press("ControlOrMeta+A")
            keys.type(text)
    to("main button[type=submit]")
    keys.press("Enter")
    page.wait_for_url("**/cut")
    expect(page.locator("a.first", has_text="Diagnose")).to_be_visible(timeout=PATIENCE)
    # 4 Plan
    to("nav a[href$='/plan']")
    keys.press("Enter")
    page.wait_for_url("**/plan")
    to("#repeats")
    keys.press("ArrowRight")
    expect(page.locator("#plan-count")).to_contain_text("24 trials")
    to("#plan button.first")
    keys.press("Enter")
    expect(page.locator("#job-title")).to_be_visible()
    expect(page.locator("#answer")).to_be_visible(timeout=PATIENCE)
    # 5 Diagnose: the page renews itself as the report fills, and Cancel keeps the focus
    to("nav a[href$='/diagnose']")
    keys.press("Enter")
    page.wait_for_url("**/diagnose")
    to("main button.first")
    keys.press("Enter")
    expect(page.locator("#known-so-far")).to_contain_text("nothing speaks against them", timeout=PATIENCE)
    to("#job form button")
    known = int(page.get_attribute("#job", "data-known"))
    expect(page.locator("#job")).not_to_have_attribute("data-known", str(known), timeout=PATIENCE)
    expect(page.locator("#job form button")).to_be_focused()
    keys.press("Enter")
    expect(page.get_by_text("Cancelled; nothing is left half-written")).to_be_visible(timeout=PATIENCE)
    expect(page.locator("main button.first")).to_be_enabled()
    # 6 Use, of a session that is diagnosed
    to(".brand")
    keys.press("Enter")
    to("main a[href='/s/0/known/diagnose']")
    keys.press("Enter")
    to("nav a[href$='/use']")
    keys.press("Enter")
    page.wait_for_url("**/use")
    said = page.locator("#peak-said")
    expect(said).to_contain_text("±", timeout=PATIENCE)
    before = said.inner_text()
    to("#v_e")
    keys.press("ArrowRight")
    expect(said).not_to_have_text(before)
    to("#speed-limit")
    keys.press("Enter")
    expect(page.locator("#answer-speed")).to_contain_text("m/s", timeout=PATIENCE)
    to("a[href$='script.py']")
    with page.expect_download(timeout=PATIENCE) as saved:
        keys.press("Enter")
    assert "model.speed(" in Path(saved.value.path()).read_text()
    # 7 Fleet
    to("nav a[href='/fleet']")
    keys.press("Enter")
    page.wait_for_url("**/fleet")
    to("main button.first")
    keys.press("Enter")
    expect(page.locator("main")).to_contain_text("damaged")  # its diagnosis.json says only the verdict
    looker.done()


@pytest.mark.long
def test_a_page_renews_itself_in_place(browser: Any, app: Served) -> None:
    """Focus, scroll, what is open and what was typed stay when a job ends, and what is new works."""
    shutil.copytree(EXAMPLES / "rig", app.home / "renewed/data")
    looker = Looker(browser, app)
    page = looker.page
    page.set_viewport_size({"width": 900, "height": 300})
    page.goto(f"{app.origin}/s/0/renewed/plan")
    page.click("#plan button.first")
    expect(page.locator("#job")).to_be_visible()
    page.evaluate("window.kept = document.getElementById('noise-number'); window.scrollTo(0, 200)")
    page.fill("#noise-number", "2.5")
    page.focus("#noise-number")
    place = page.locator("#noise-number").bounding_box()["y"]
    expect(page.locator("#answer")).to_be_visible(timeout=PATIENCE)
    expect(page.locator("#job")).to_have_count(0)
    expect(page.locator("#noise-number")).to_be_focused()
    assert page.locator("#noise-number").input_value() == "2.5"
    assert page.evaluate("window.kept === document.activeElement")
    assert abs(page.locator("#noise-number").bounding_box()["y"] - place) < 2
    expect(page.locator("#plan button.first")).to_be_enabled()
    page.click("#plan button.first")  # what was typed is asked
    expect(page.locator("#answer").locator("..")).to_contain_text("noise of 2.5 N", timeout=PATIENCE)
    looker.done()


@pytest.mark.long
def test_the_report_fills_and_a_killed_diagnosis_goes_on(browser: Any, app: Served) -> None:
    import signal

    folder = app.home / "filling"
    shutil.copytree(EXAMPLES / "rig", folder / "data")
    looker = Looker(browser, app)
    page = looker.page
    page.goto(f"{app.origin}/s/0/filling/diagnose")
    page.click("main button.first")
    known = page.locator("#known-so-far")
    expect(known).to_contain_text("Provisional", timeout=PATIENCE)
    expect(known).to_contain_text("nothing speaks against them")
    expect(known).to_contain_text("refitted to these trials")
    expect(known).to_contain_text("explanations weighed so far")
    expect(known.get_by_text("End stop", exact=True)).to_be_visible(timeout=PATIENCE)  # the rig's cause
    shown = known.inner_text()
    assert "probab" not in shown.lower() and "likely" not in shown and "Identified" not in shown
    assert page.locator(".plot .trace").count() >= 1  # the trials below are not drawn anew each time
    details = page.locator("details", has_text="16 trials")
    details.locator("summary").click()
    before = page.get_attribute("#job", "data-known")
    expect(page.locator("#job")).not_to_have_attribute("data-known", before, timeout=PATIENCE)
    assert details.get_attribute("open") is not None
    pid = json.loads((folder / ".app/diagnose/job.json").read_text())["pid"]
    os.killpg(pid, signal.SIGKILL)
    expect(page.get_by_text("goes on where it was")).to_be_visible(timeout=PATIENCE)
    left = len(list((folder / ".diagnosis.unfinished").glob("*.npz")))
    assert left > 5 and not (folder / "diagnosis").exists()
    page.click("main button.first")
    expect(page.locator("#known-so-far")).to_contain_text("End stop", timeout=PATIENCE)
    assert f"goes on with {left} fits" in (folder / ".app/diagnose/progress.txt").read_text()
    page.click("#job form button")
    expect(page.get_by_text("Cancelled; nothing is left half-written")).to_be_visible(timeout=PATIENCE)
    looker.done()


@pytest.mark.parametrize("size, scheme", LOOKS[:2])
@pytest.mark.long
def test_sliders_and_questions(browser: Any, ready: Served, size: str, scheme: str) -> None:
    looker = Looker(browser, ready, size, scheme)
    page = looker.page
    page.goto(f"{ready.origin}/s/0/known/use")
    said = page.locator("#peak-said")
    expect(said).to_contain_text("±")
    before = float(said.inner_text().split(" ")[0])
    page.locator("#v_e").focus()
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    expect(said).not_to_contain_text(f"{before:.1f}")
    assert float(said.inner_text().split(" ")[0]) > before
    page.fill("#limit-number", "60")
    expect(said).to_contain_text("within the limit")
    page.fill("#speed-limit", "140")
    page.fill("#speed-f_p", "60")
    page.click("#ask-speed button")
    expect(page.locator("#answer-speed")).to_contain_text("m/s")
    page.fill("#speed-limit", "a lot")
    page.click("#ask-speed button")
    expect(page.locator("#answer-speed")).to_contain_text("Limit: 'a lot' is no number")
    assert looker.fits()
    looker.faults = [fault for fault in looker.faults if "400" not in fault]  # the refused question
    looker.done()


@pytest.mark.long
def test_a_recording_is_opened_in_place(browser: Any, ready: Served) -> None:
    looker = Looker(browser, ready)
    page = looker.page
    page.click("text=Open a recording or a data set on this machine")
    page.click(f"a:has-text('{EXAMPLES}')")
    assert page.locator("button", has_text="session.mcap").count() == 1
    assert page.locator("button", has_text="make_rig.py").count() == 0  # no recording
    page.click("button:has-text('session.mcap')")
    page.wait_for_url("**/open")
    expect(page.locator("#force")).to_have_value(json.dumps(["/flange/wrench", "wrench.force.z"]))
    assert page.locator(".tree .leaf").count() == 13
    page.get_by_role("button", name="force: take /flange/wrench:wrench.force.x").click()
    expect(page.locator("#force")).to_have_value(json.dumps(["/flange/wrench", "wrench.force.x"]))
    expect(page.locator("#preview-said")).to_contain_text("26,800 samples")
    assert not (ready.home / "session/recording").exists()
    looker.done()


def axe_source() -> str:
    """axe-core as npm installs it: `npm install --no-save axe-core` in this folder, or AXE=path of axe.min.js."""
    path = Path(os.environ.get("AXE") or ROOT / "node_modules/axe-core/axe.min.js")
    if not path.is_file():
        pytest.skip("needs axe-core: npm install --no-save axe-core, or AXE=PATH of its axe.min.js")
    return path.read_text("utf-8")


def findings(page: Any, source: str) -> list[str]:
    """Serious and critical findings of axe on a page."""
    page.evaluate(source)
    run = "async () => (await axe.run(document, {iframes: false})).violations"
    found = page.evaluate(run)
    return [
        f"{v['id']}: {v['nodes'][0]['html'][:200]}" for v in found if v["impact"] in ("serious", "critical")
    ]


@pytest.mark.parametrize("size, scheme", LOOKS)
def test_axe_finds_nothing_serious(browser: Any, ready: Served, size: str, scheme: str) -> None:
    source = axe_source()
    looker = Looker(browser, ready, size, scheme)
    ready.post("/open", {"place": "1", "path": "session.mcap"})
    paths = ["/", "/browse/1/", "/fleet", "/s/0/session/open", "/s/0/session/cut", "/s/0/session/rig",
             "/s/0/known/plan", "/s/0/known/diagnose", "/s/0/known/use", "/nothing"]  # fmt: skip
    found = {}
    for path in paths:
        looker.page.goto(ready.origin + path)
        looker.page.wait_for_load_state("networkidle") if "use" not in path else looker.page.wait_for_timeout(
            0
        )
        if serious := findings(looker.page, source):
            found[path] = serious
    assert found == {}
    looker.context.close()


@pytest.mark.long
def test_the_whole_job(browser: Any, tmp_path: Path) -> None:
    """examples/session.mcap from the file to the fleet, then looked at on a phone.

    axe looks at the pages that the commands write, too.
    """
    with served(tmp_path) as app:
        looker = Looker(browser, app)
        page = looker.page
        page.set_input_files("#files", EXAMPLES / "session.mcap")
        page.wait_for_url("**/open")
        page.click("text=Find the contacts")
        cut_frame(page)
        page.click("text=Describe the rig")
        fill_rig(page)
        page.click("text=Save the rig")
        expect(page.locator("a.first", has_text="Diagnose")).to_be_visible(timeout=PATIENCE)
        page.click("nav >> text=Plan")
        page.click("text=What would these trials show?")
        expect(page.locator("#answer")).to_be_visible(timeout=PATIENCE)
        assert page.locator("tbody tr").count() >= 13 and looker.fits()
        page.click("nav >> text=Diagnose")
        page.click("main button.first")
        expect(page.locator("#job-stages li").nth(1)).to_be_visible(timeout=PATIENCE)
        page.reload()  # nothing is lost
        expect(page.locator("#job-stages li").nth(1)).to_be_visible(timeout=PATIENCE)
        other = looker.context.new_page()  # a second tab sees the same
        other.goto(page.url)
        expect(other.locator("#job")).to_be_visible()
        other.close()
        frame = page.frame_locator("iframe.embedded")
        expect(frame.locator(".verdict")).to_contain_text("end stop")
        expect(frame.locator("html[data-drawn]")).to_be_attached()
        box = frame.locator("#cause-end_stop")
        name = "() => document.getElementById('causes').data.find((t) => t.meta?.causes && t.visible).name"
        handle = page.locator("iframe.embedded").element_handle().content_frame()
        assert handle.evaluate(name) == "model with end stop"
        box.uncheck()
        assert handle.evaluate(name) == "model without causes"
        click = "document.getElementById('made-of-bars').emit('plotly_click', {points: [{id: 'end_stop'}]})"
        handle.evaluate(click)
        expect(box).to_be_checked()
        assert looker.fits()
        # by the key: right after a jump out of a frame the browser may still give a click to the frame
        page.get_by_role("link", name="Use the corrected model").press("Enter")
        expect(page.locator("#peak-said")).to_contain_text("±")
        for download in (
            "Report, HTML",
            "Report, PDF",
            "Corrected model",
            "the commands",
            "the same in Python",
        ):
            with page.expect_download(timeout=PATIENCE) as saved:
                page.get_by_role("link", name=download).click()
            assert Path(saved.value.path()).stat().st_size > 100
        page.click("text=Train a surrogate")
        expect(page.get_by_text("Surrogate, model.eqx")).to_be_visible(timeout=PATIENCE)
        page.click("text=Write C and ONNX")
        expect(page.get_by_text("ONNX model")).to_be_visible(timeout=PATIENCE)
        expect(page.locator("#peak-said")).to_contain_text("±")
        page.goto(f"{app.origin}/fleet")
        for _ in range(2):  # with an earlier one to compare with
            page.click("main button.first")
            page.wait_for_url("**shown=**")
        expect(page.frame_locator("iframe.embedded").locator(".verdict")).to_contain_text(
            "none of them changed"
        )
        if Path(os.environ.get("AXE") or ROOT / "node_modules/axe-core/axe.min.js").is_file():
            for path in ("data/import.html", "diagnosis/report.html"):
                page.goto(f"{app.origin}/s/0/session/file/{path}")
                page.wait_for_timeout(0)
                assert findings(page, axe_source()) == []
        looker.done()
        phone = Looker(browser, app, "phone", "dark")
        for step in ("open", "cut", "rig", "plan", "diagnose", "use"):
            phone.page.goto(f"{app.origin}/s/0/session/{step}")
            assert phone.page.locator("main").is_visible() and phone.fits(), step
        expect(phone.page.locator("#peak-said")).to_contain_text("±")
        phone.done()


@pytest.mark.long
def test_a_diagnosis_outlives_a_server_that_is_killed(browser: Any, tmp_path: Path) -> None:
    """kill -9 of the app: the job goes on, and the next app shows it."""
    import subprocess
    import sys

    shutil.copytree(EXAMPLES / "rig", tmp_path / "rig/data")

    def start() -> tuple[subprocess.Popen[str], str]:
        command = [sys.executable, "-m", "acf_jax", "app", str(tmp_path), "--no-browser"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        return process, process.stdout.readline().strip()

    process, address = start()
    page = browser.new_page()
    page.goto(address)
    page.goto(f"{address.partition('/?')[0]}/s/0/rig/diagnose")
    page.click("main button.first")
    expect(page.locator("#job-stages li").first).to_be_visible(timeout=PATIENCE)
    process.kill()
    process.communicate()
    process, address = start()
    try:
        page.goto(address)
        page.goto(f"{address.partition('/?')[0]}/s/0/rig/diagnose")
        expect(page.locator("#job")).to_be_visible()
        expect(page.locator("iframe.embedded")).to_be_visible(timeout=PATIENCE)
    finally:
        process.terminate()
        process.communicate()
        page.close()
