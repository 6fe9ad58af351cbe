"""The page over all rigs, and the changes on it."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from needs import need_chromium, need_module

from acf_jax.cli.main import commands
from acf_jax.errors import InputError
from acf_jax.fleet.changes import find_changes, threshold
from acf_jax.fleet.page import fleet_page
from acf_jax.fleet.record import Estimate, Fleet, Rig, read_fleet, read_fleets

EVIL = "</script><img src=x onerror=\"document.title='owned'\">"
FRICTION = "coulomb_friction.force_n"


def rig(name: str, data: str, friction: float, std: float = 0.3, **changes: object) -> Rig:
    """A rig with dry friction."""
    content = {
        "rig": name, "data": data, "verdict": "identified", "first": ("coulomb_friction",), "probability": 0.97,
        "component": "actuator", "recalibrated_rms_n": 5.0, "corrected_rms_n": 0.5, "peak_rms_percent": 0.4,
        "shrinkage": 0.9, "parameters": {FRICTION: Estimate(value=friction, std=std, unit="N", at_bound=False)},
    }  # fmt: skip
    return Rig(**{**content, **changes})


def fleet(label: str, *rigs: Rig, finished: str = "2026-11-21 10:00 UTC") -> Fleet:
    return Fleet(label=label, finished=finished, rigs=rigs)


def test_a_rig_whose_friction_grows_is_found() -> None:
    runs = [
        fleet(month, rig("steady", month, 2.0 + 0.2 * (k % 2)), rig("worn", month, 2.0 + 0.9 * k))
        for k, month in enumerate(("april", "may", "june"))
    ]
    changes, trends = find_changes(runs)
    assert [(c.rig, c.what, c.before, c.after) for c in changes] == [
        ("worn", FRICTION, "2 ± 0.3 N", "3.8 ± 0.3 N")
    ]
    assert [t.rig for t in trends] == ["worn", "steady"]
    # NumPy's weighted straight line, with the covariance of the stated uncertainties
    for trend in trends:
        (slope, _), covariance = np.polyfit(trend.run, trend.value, 1, w=1 / trend.std, cov="unscaled")
        assert trend.sigmas == pytest.approx(slope / np.sqrt(covariance[0, 0]), abs=1e-9)


def test_a_class_is_named_whole() -> None:
    """One member alone would pass for the cause."""
    both = (("coulomb_friction",), ("gravity",))
    page = fleet_page(fleet("june", rig("a", "x", 2.0, credible=both, probability=0.5)), [])
    assert "dry friction or constant force" in page


def test_data_that_were_diagnosed_again_are_no_new_evidence() -> None:
    runs = [
        fleet("april", rig("a", "x", 2.0)),
        fleet("may", rig("a", "x", 2.0)),
        fleet("june", rig("a", "y", 2.5)),
    ]
    (trend,) = find_changes(runs)[1]
    assert trend.run.tolist() == [0, 2]
    assert trend.sigmas == pytest.approx(0.5 / np.hypot(0.3, 0.3))
    assert find_changes(runs[:2]) == ([], [])


def test_another_cause_is_a_change_and_ends_the_trends() -> None:
    free = rig("a", "x", 0.0, first=(), parameters={})
    changes, trends = find_changes([fleet("april", free), fleet("may", rig("a", "y", 9.0))])
    assert [(c.what, c.before, c.after) for c in changes] == [("cause", "nothing unmodelled", "dry friction")]
    assert trends == []


def test_one_of_two_causes_that_both_stand_is_no_change() -> None:
    both = (("coulomb_friction",), ("gravity",))
    before = rig("a", "x", 5.0, first=("gravity",), credible=both)
    assert find_changes([fleet("april", before), fleet("may", rig("a", "y", 5.0, credible=both))])[0] == []
    sure = rig("a", "y", 5.0, credible=both[:1])
    assert find_changes([fleet("april", before), fleet("may", sure)])[0] == [], "only the data are better"
    assert (
        find_changes([fleet("april", sure), fleet("may", before.model_copy(update={"data": "z"}))])[0] == []
    )
    weight = before.model_copy(update={"data": "z", "credible": both[1:]})
    assert [c.what for c in find_changes([fleet("april", sure), fleet("may", weight)])[0]] == ["cause"]


def test_a_cause_beside_no_gap_was_none() -> None:
    """Data never rule out an effect that is small enough: it stands, and later it is a clear cause."""
    stands = ((), ("coulomb_friction",))
    free = rig("a", "x", 0.0, first=(), credible=stands, verdict="no_gap", parameters={})
    rubs = rig("a", "y", 9.0, credible=stands[1:])
    there, back = (
        find_changes([fleet("april", *a), fleet("may", *b)])[0]
        for a, b in (((free,), (rubs,)), ((rubs,), (free,)))
    )
    assert [(c.what, c.after) for c in (*there, *back)] == [
        ("cause", "dry friction"),
        ("cause", "nothing unmodelled"),
    ]
    poor = free.model_copy(update={"verdict": "insufficient_data"})
    assert find_changes([fleet("april", poor), fleet("may", rubs)])[0] == [], "these data left it open"


def test_a_cause_outside_the_library_is_another_one_at_another_component() -> None:
    def unknown(component: str, data: str, mass: float, **more: object) -> Fleet:
        known = {"moving_mass_kg": Estimate(value=mass, std=0.02, unit="kg", at_bound=False)}
        first = {"first": ("unknown",), "credible": (("unknown",),), "verdict": "unknown"}
        return fleet(data, rig("a", data, 0.0, component=component, parameters=known, **first, **more))

    changes, trends = find_changes([unknown("robot", "april", 2.3), unknown("sensor", "may", 2.05)])
    assert [(c.what, c.before, c.after) for c in changes] == [
        ("cause", "a cause outside the library at the robot", "a cause outside the library at the sensor")
    ]
    assert trends == [], "a parameter means another thing beside another cause"
    either = {"components": ("actuator", "robot")}
    runs = [unknown("robot", "april", 2.3, **either), unknown("actuator", "may", 2.3)]
    assert find_changes(runs) == ([], []), "both components stood"
    (grown,) = find_changes([unknown("robot", "april", 2.3), unknown("robot", "may", 2.05)])[0]
    assert grown.what == "moving_mass_kg"


def test_chance_alone_rarely_makes_a_change() -> None:
    """A hundred fleets of sixty rigs that do not change: one in twenty may raise an alarm."""
    random = np.random.default_rng(7)
    assert threshold(60) == pytest.approx(3.34, abs=0.01)  # 1.96 for one, by Bonferroni's rule for sixty
    alarms = 0
    for _ in range(100):
        runs = [
            fleet(str(k), *(rig(f"r{i}", str(k), random.normal(5.0, 0.3)) for i in range(60)))
            for k in range(3)
        ]
        alarms += bool(find_changes(runs)[0])
    assert alarms <= 11  # binomial: more in one of a hundred such tests


@pytest.fixture
def page() -> str:
    """The page of two runs over rigs whose names are HTML."""
    runs = [
        fleet(
            f"{month} {EVIL}",
            rig(f"a {EVIL}", month, 2.0 + 3.0 * k),
            rig("b", month, 9.0, verdict="no_gap", first=(), component=None, shrinkage=None, parameters={}),
            rig("c", month, 4.0, recalibrated_rms_n=70.0, probability=0.5, verdict="ambiguous"),
            Rig(rig="d", fault=f"trials.csv row 3: {EVIL}"),
        )
        for k, month in enumerate(("april", "may"))
    ]
    changes, trends = find_changes(runs)
    now = runs[-1].model_copy(update={"since": (runs[0].label,), "changes": tuple(changes)})
    return fleet_page(now, trends)


@pytest.mark.long
def test_the_page_in_a_browser(page: str, tmp_path: Path) -> None:
    """Offline, on a phone in the dark: fits, sorts, runs nothing that a name brings along."""
    sync_api = need_module("playwright.sync_api", "pip install playwright")
    path, faults = tmp_path / "index.html", []
    path.write_text(page, "utf-8")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=need_chromium(), args=["--no-sandbox"])
        options = {"viewport": {"width": 375, "height": 700}, "is_mobile": True, "has_touch": True}
        shown = browser.new_context(offline=True, color_scheme="dark", **options).new_page()
        shown.on("console", lambda m: faults.append(m.text) if m.type in ("error", "warning") else None)
        shown.on("pageerror", lambda e: faults.append(str(e)))
        shown.goto(path.as_uri())
        shown.wait_for_selector("html[data-drawn]")
        assert shown.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
        assert shown.locator("img").count() == 0 and "owned" not in shown.title()[:6]

        def order() -> Sequence[str]:
            return [text[0] for text in shown.locator("table.sortable tbody th").all_inner_texts()]

        assert order() == ["a", "b", "c"]
        for column, expected in {
            "Force error before": "abc",
            "Probability of the first": "cab",
            "Rig": "abc",
        }.items():
            shown.get_by_role("button", name=column, exact=True).tap()
            assert "".join(order()) == expected, column
        shown.get_by_role("button", name="Rig", exact=True).tap()
        assert order() == ["c", "b", "a"]
        assert shown.get_by_role("link", name="b", exact=True).get_attribute("href") == "b/report.html"
        browser.close()
    assert faults == []


def test_a_record_comes_back_and_a_wrong_one_is_named(tmp_path: Path) -> None:
    record = fleet("april", rig("a", "x", 2.0))
    (tmp_path / "fleet.json").write_text(record.model_dump_json(by_alias=True))
    assert read_fleet(tmp_path) == record
    may = json.loads(record.model_dump_json(by_alias=True))

    def strange(**estimate: float) -> str:
        known = may["rigs"][0]["parameters"][FRICTION]
        return json.dumps({**may, "rigs": [{**may["rigs"][0], "parameters": {FRICTION: known | estimate}}]})

    for text, fault in (
        (strange(value=1e308), "value: must be 0, or between 1e-60 and 1e.60 in size"),
        (strange(std=1e-300), "std: must be 0, or between 1e-60 and 1e.60 in size"),
        (strange(std=-1.0), "std: must be greater than or equal to 0"),
        (json.dumps({**may, "rigs": 2 * may["rigs"]}), "rig 'a' is listed more than once"),
        (
            json.dumps({"schema": "acf-gap-fleet/1", "label": "x", "rigs": []}),
            "finished: is missing; name a folder",
        ),
        ("{", "is not JSON"),
        ("[" * 100_000, "is nested too deeply"),
    ):
        (tmp_path / "fleet.json").write_text(text)
        with pytest.raises(InputError, match=fault):
            read_fleet(tmp_path)


@pytest.mark.parametrize(
    ("arguments", "fault"),
    [
        (["--out", "out", "--since", "nowhere"], "nowhere/fleet.json: no such file; check the path"),
        (["--out", "out", "--since", "./out"], "is the folder of --out"),
        (["--out", "file"], "is a file; name a folder"),
    ],
)
def test_faults_of_the_command(arguments, fault, tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("")
    result = CliRunner().invoke(commands, ["fleet", ".", *arguments])
    assert isinstance(result.exception, InputError) and fault in str(result.exception)
    assert "JSON" not in str(result.exception) and not Path("out").exists()


def keep(folder: Path, record: Fleet) -> Path:
    folder.mkdir()
    (folder / "fleet.json").write_text(record.model_dump_json(by_alias=True))
    return folder


def test_earlier_runs_have_to_come_in_their_order(tmp_path: Path) -> None:
    april, may = (
        keep(tmp_path / name, fleet(name, finished=f"2026-{month}-21 10:00 UTC"))
        for name, month in (("april", "04"), ("may", "05"))
    )
    assert [run.label for run in read_fleets([april, may, may])] == ["april", "may", "may"]
    with pytest.raises(
        InputError, match=r"april/fleet.json: ended 2026-04.*, but may, named before it, 2026-05"
    ):
        read_fleets([may, april])


def test_what_became_of_a_rig_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A change between two earlier runs, a rig that is gone, and one whose data set has two faults."""
    since = [
        keep(tmp_path / "april", fleet("april", rig("a", "x", 2.0), rig("z", "x", 2.0))),
        keep(tmp_path / "may", fleet("may", rig("a", "y", 9.0), rig("b", "y", 2.0))),
    ]
    faults = [f"trials.csv row {k}: {'long ' * 120}" for k in (3, 4)]
    now = fleet("june", rig("a", "y", 9.0), Rig(rig="c", fault="\n".join(faults)))
    monkeypatch.setattr("acf_jax.fleet.run.run_fleet", lambda *arguments: now)
    options = [part for folder in since for part in ("--since", str(folder))]
    result = CliRunner().invoke(commands, ["fleet", ".", "--out", str(tmp_path / "june"), *options])
    assert isinstance(result.exception, InputError) and result.exception.faults == faults
    assert "in may, but not among these data sets: b\n" in result.output
    shown = (tmp_path / "june" / "index.html").read_text("utf-8")
    assert "2 rigs, 1 of them changed, compared with april and may." in shown
    assert shown.count("<strong>c</strong>") == 2 and "<strong>b</strong>: in may, but not among" in shown
