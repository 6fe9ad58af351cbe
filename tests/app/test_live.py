"""What the sliders of step 6 state, and what they leave unstated."""

import json
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from served import Served

from acf_jax.app import live
from acf_jax.app.live import Asked, curve
from acf_jax.dataset import read_dataset
from acf_jax.errors import InputError
from acf_jax.surrogate.saved import read_header

MODEL = Path(__file__).resolve().parents[2] / "examples/rig_model.json"  # tried: 0.05 to 0.35 m/s, 50 to 90 N
V_E = np.array([0.1, 0.2, 0.3, 0.4])
NONE = np.nan


@pytest.fixture(scope="module")
def diagnosis(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("diagnosis")
    shutil.copy(MODEL, folder / "model.json")
    return folder


@pytest.mark.parametrize(
    "upper, highest, told",
    [
        ([100, 120, 160, 200], 0.25, "up to about 0.250 m/s"),
        ([100, 120, 130, 140], 0.4, "every velocity shown, up to 0.400 m/s"),
        ([150, 160, 170, 180], None, "No velocity shown keeps"),
        ([NONE, 120, 160, 200], 0.25, "up to about 0.250 m/s"),  # almost at rest there is no first peak
        ([100, 120, NONE, 130], 0.2, "up to about 0.200 m/s"),  # a force that keeps rising keeps no limit
        ([100, 120, NONE, NONE], 0.2, "up to about 0.200 m/s"),
        ([NONE, NONE, NONE, NONE], None, "nothing is known"),
        ([100, 160, 120, 130], 0.166, "up to about 0.166 m/s"),  # not rounded up, and not beyond a stretch
    ],
)
def test_a_velocity_is_stated_only_where_every_slower_one_keeps_the_limit(
    upper: list[float], highest: float | None, told: str
) -> None:
    found, words = live._highest(V_E, np.array(upper, float), 140.0)
    assert found == highest and told in words
    assert ("ask below" in words) == (highest is not None) and "%" not in words


def test_what_lies_beyond_the_trials_is_told(diagnosis: Path) -> None:
    model = live.model_of(diagnosis, diagnosis / "model.eqx")
    inner = curve(model, Asked(0.2, 60.0, 1.0, 100.0))
    assert inner["notes"] == [] and "up to about" in inner["allowed"]
    tried = [0.05 <= v <= 0.35 for v in inner["v_e"]]
    assert [not beyond for beyond in inner["beyond"]] == tried and 10 < sum(tried) < len(tried)
    # the velocity that is named counts, not only that of the slider
    high = curve(model, Asked(0.2, 60.0, 1.0, 1000.0))
    assert "up to 0.525 m/s" in high["allowed"]
    assert high["notes"] == [
        "v_e = 0.525 m/s lies outside the tried 0.05 to 0.35 m/s: the model extrapolates"
    ]
    for asked, told in (
        (Asked(0.5, 60.0, 1.0, 100.0), "v_e = 0.5 m/s lies outside the tried 0.05 to 0.35 m/s"),
        (Asked(0.2, 120.0, 1.0, 140.0), "f_p = 120 N lies outside the tried 50 to 90 N"),
        (Asked(0.2, 60.0, 1.5, 100.0), "k_c = "),
    ):
        found = curve(model, asked)
        assert any(told in note and "the model extrapolates" in note for note in found["notes"]), asked
        assert all(found["beyond"]) == (asked.v_e == 0.2)


def changed(app: Served, name: str, **values: object) -> str:
    """A session whose model.json says something else."""
    folder = app.home / name / "diagnosis"
    folder.mkdir(parents=True)
    (folder / "model.json").write_text(json.dumps(json.loads(MODEL.read_text()) | values))
    (folder / "diagnosis.json").write_text(json.dumps({"verdict": values.get("verdict", "identified")}))
    return f"/s/0/{name}"


QUESTIONS = {
    "speed": {"f_p": "60", "limit": "140"},
    "design": {"limit": "140", "v-low": "0.05", "v-high": "0.35", "f-low": "50", "f-high": "90"},
    "check": {"v": "0.1", "f_p": "60", "area": "17", "stop": "0.05"},
}
AT = "v_e=0.2&f_p=60&stiffness=1&limit=140"


def test_nothing_is_stated_where_the_data_did_not_suffice(app: Served) -> None:
    url = changed(app, "short", verdict="insufficient_data", lack="separation")
    page = app.get(f"{url}/use").text
    assert "gives no answers" in page and "too little data to answer" in page
    assert 'id="sliders"' not in page and "Ask the model" not in page
    answers = [app.get(f"{url}/curve?{AT}", Accept="application/json")]
    answers += [app.post(f"{url}/ask/{q}", f, Accept="application/json") for q, f in QUESTIONS.items()]
    for answer in answers:
        assert answer.status == 400 and set(answer.json) == {"faults"}
        assert "too little data to answer" in " ".join(answer.json["faults"])
    assert "speed(" not in app.get(f"{url}/script.py").text


@pytest.mark.parametrize(
    "values, told",
    [
        ({"verdict": "unknown"}, "no known cause"),
        ({"verdict": "ambiguous"}, "the diagnosis is ambiguous"),
        ({"better": False}, "not better than the recalibrated one"),
    ],
)
def test_a_doubt_of_the_diagnosis_stands_beside_the_curve(
    app: Served, values: dict[str, object], told: str
) -> None:
    url = changed(app, f"doubt {'-'.join(values)} {values.get('verdict')}".replace("None", "x"), **values)
    found = app.get(f"{url}/curve?{AT}".replace(" ", "%20"), Accept="application/json")
    assert found.status == 200 and any(told in note for note in found.json["notes"])


def test_the_ends_of_the_sliders_can_be_asked(app: Served) -> None:
    """A slider's steps do not lead out of its range."""
    url = changed(app, "odd", v_range=[0.0333, 0.3333], f_p_range=[51.3, 88.7], corners=[])
    page = app.get(f"{url}/use").text
    ends = {}
    for name in ("v_e", "f_p", "stiffness", "limit"):
        control = page.split(f'id="{name}"')[1].split(">")[0]
        ends[name] = [control.split(f'{end}="')[1].split('"')[0] for end in ("min", "max")]
    for k in range(2):
        query = "&".join(f"{name}={span[k]}" for name, span in ends.items())
        assert app.get(f"{url}/curve?{query}", Accept="application/json").status == 200
    with pytest.raises(InputError, match="v_e: must lie between"):
        model = live.model_of(app.home / "odd/diagnosis", Path("none"))
        live.asked_of({"v_e": "2", "f_p": "60", "stiffness": "1", "limit": "9e9"}, model)


def test_what_belongs_to_another_diagnosis_or_data_set_is_told(app: Served) -> None:
    """By content: times may be of a copy, a checkout or a clock that was set."""
    folder = app.home / "again"
    shutil.copytree(MODEL.parent / "rig", folder / "data")
    digest = read_dataset(folder / "data").digest
    url = changed(app, "again")
    (folder / "diagnosis/diagnosis.json").write_text(json.dumps({"data_sha256": digest}))
    (folder / "surrogate").mkdir()
    shutil.copy(MODEL.parent / "rig_surrogate.eqx", folder / "surrogate/model.eqx")
    checksum = read_header(folder / "surrogate/model.eqx")[0]["sha256"]
    (folder / "surrogate/peak.h").write_text(f"/* SHA-256 {checksum}. */")
    (folder / "surrogate/peak.onnx").write_bytes(b"\x00" + b"0" * 64)  # of another surrogate

    def page() -> str:
        return app.get(f"{url}/use").text

    other = "another than the one that was diagnosed"
    known = page()
    assert (
        other not in known
        and "Surrogate, model.eqx" in known
        and "answered by the surrogate" in known.lower()
    )
    assert "C99 header" in known and "ONNX model" not in known
    for path in folder.rglob("*"):  # as after a copy, in whatever order
        os.utime(path, (1, hash(path) % 1000))
    assert page() == known
    table = folder / "data/trials.csv"
    text = table.read_text()
    table.write_text(text.replace("0.05", "0.06", 1))
    os.utime(table, (1, 1))
    assert other in page()
    (folder / "diagnosis/provenance.json").write_text(
        json.dumps({"made_of": [{"input": "data", "sha256": read_dataset(folder / "data").digest}]})
    )
    assert other not in page()  # diagnosed behind a low-pass: data_sha256 is of what came out of it
    table.write_text("trial\n")
    assert other in page()
    table.write_text(text)
    model = json.loads(MODEL.read_text()) | {"description": "another"}
    (folder / "diagnosis/model.json").write_text(json.dumps(model))
    os.utime(folder / "diagnosis/model.json", (1, 1))
    found = page()
    assert (
        "of an earlier diagnosis" in found
        and "Surrogate, model.eqx" not in found
        and "C99 header" not in found
    )
    assert "answered by the simulation" in found.lower()
