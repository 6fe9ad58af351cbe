"""Where results come from, and that nothing of others is overwritten."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from acf_jax.cli.main import main
from acf_jax.fleet.page import fleet_page
from acf_jax.fleet.record import Fleet
from acf_jax.provenance import Origin, digest_of
from acf_jax.recording.rig import read_rig_file
from acf_jax.training.report import write_page
from tests.recording.sessions import FEW, RIG, columns, made
from tests.validation.blind.test_summary import NONE
from train import fit
from validation.blind.page import score_page
from validation.blind.summary import summarise

ROOT = Path(__file__).resolve().parents[2]

DATE = "2026-03-01T10:00:00Z"
EPOCH = "1772359200"


@pytest.fixture
def call(monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", EPOCH)
    (tmp_path / "rig.yaml").write_text(RIG)

    def call(*arguments: object) -> tuple[int, str]:
        with pytest.raises(SystemExit) as end:
            main([str(a) for a in arguments])
        out = capsys.readouterr()
        return end.value.code, out.out + out.err

    return call


def recording(path: Path, seed: int = 3) -> Path:
    np.savez(path, **columns(made(seed, FEW)))
    return path


def test_a_data_set_says_where_it_comes_from(call, tmp_path):
    log = recording(tmp_path / "log.npz")
    command = ("import", "log.npz", "--out", "my set", "--rig", "rig.yaml")
    code, said = call(*command)
    assert code == 0, said
    digest = hashlib.sha256(log.read_bytes()).hexdigest()
    origin = json.loads((tmp_path / "my set/provenance.json").read_text())
    assert origin["made_of"] == [{"input": "log.npz", "sha256": digest}]
    assert (
        origin["command"] == "acf-jax import log.npz --out 'my set' --rig rig.yaml" and origin["date"] == DATE
    )
    assert origin["program"].startswith("acf-jax ")
    page = (tmp_path / "my set/import.html").read_text()
    assert digest[:12] in page and "Made on 2026-03-01 at 10:00 UTC" in page


def test_another_recording_renews_what_an_import_said_of_itself(call, tmp_path):
    recording(tmp_path / "june.npz")
    recording(tmp_path / "july.npz", 4)
    assert call("import", "june.npz", "--out", "set", "--rig", "rig.yaml")[0] == 0
    assert call("import", "july.npz", "--out", "set")[0] == 0
    found = tmp_path / "set/dataset.yaml"
    assert "description: impacts cut from july.npz" in found.read_text()
    assert json.loads((tmp_path / "set/provenance.json").read_text())["made_of"][0]["input"] == "july.npz"
    found.write_text(found.read_text().replace("impacts cut from july.npz", "flange 2"))
    assert call("import", "june.npz", "--out", "set")[0] == 0
    assert "description: flange 2" in found.read_text()  # what a user wrote stays
    assert read_rig_file(found).prior.m.value == 2.1


FOREIGN = {
    "import": (("import", "log.npz", "--out", "out", "--rig", "rig.yaml"), "out/trials.csv"),
    "import page": (("import", "log.npz", "--out", "out", "--rig", "rig.yaml"), "out/import.html"),
    "import trace": (("import", "log.npz", "--out", "out", "--rig", "rig.yaml"), "out/traces/t000.csv"),
    "diagnose": (("diagnose", "no_set", "--out", "out"), "out/report.html"),
    "diagnose origin": (("diagnose", "no_set", "--out", "out"), "out/provenance.json"),
    "train": (("train", "no_model", "--out", "out"), "out/model.eqx"),
    "train config": (("train", "no_model", "--out", "out"), "out/config.yaml"),
    "fleet": (("fleet", "no_rigs", "--out", "out"), "out/index.html"),
    "fleet rig": (("fleet", "no_rigs", "--out", "out"), "out/north/report.html"),
    "blind": (("blind", "--out", "out", "--cases", "3"), "out/results/score.txt"),
    "blind score": (("blind", "score", "no_rigs", "--out", "out"), "out/score.html"),
    "predict": (("predict", "no_model", "--conditions", "none.csv", "--out", "out"), "out/predictions.csv"),
    "predict trace": (("predict", "no_model", "--conditions", "asked.csv", "--out", "out"), "out/traces/a.csv"),
    "run": (("run", "log.npz", "--rig", "rig.yaml", "--limit", "140", "--out", "out"), "out/index.html"),
    "export": (("export", "--c", "peak.h"), "peak.h"),
    "peak": (("peak", "--m", "4", "--d", "0", "--k-f", "0", "--k-c", "2e5", "--v-e", "0.2", "--f-p", "100",
              "--plot", "peak.html"), "peak.html"),
    "run trace": (("run", "log.npz", "--rig", "rig.yaml", "--limit", "140", "--out", "out"),
                  "out/data/traces/t003.csv"),
    "design": (("design", "--config", "none.yaml", "--plot", "design.html"), "design.html"),
    "check": (("check", "--model", "rig.yaml", "--situations", "none.csv", "--out", "said.csv"), "said.csv"),
}  # fmt: skip


@pytest.mark.parametrize("name", FOREIGN)
def test_nothing_of_others_is_overwritten(call, tmp_path, name):
    arguments, file = FOREIGN[name]
    recording(tmp_path / "log.npz")
    (tmp_path / "validation").symlink_to(ROOT / "validation")  # `blind` looks for it where it is called
    (tmp_path / "asked.csv").write_text("trial,contact_velocity_m_per_s,pretension_n\na,0.2,60\n")
    (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / file).write_text("mine")
    code, said = call(*arguments)
    assert code == 2 and "--overwrite" in said and file.split("/")[0] in said
    assert (tmp_path / file).read_text() == "mine"
    code, said = (
        call(*arguments, "--overwrite") if name not in ("run", "run trace", "peak", "blind") else (2, "")
    )
    assert "--overwrite" not in said
    if name in ("export", "import", "import page", "import trace"):
        assert code == 0 and (tmp_path / file).read_text() != "mine"


def test_a_review_that_names_trials_otherwise_overwrites_nothing_of_others(call, tmp_path):
    recording(tmp_path / "log.npz")
    command = ("import", "log.npz", "--out", "out", "--rig", "rig.yaml", "--review", "cuts.yaml")
    assert call(*command)[0] == 0
    cuts = tmp_path / "cuts.yaml"
    cuts.write_text(cuts.read_text().replace("t000", "calibration").replace("t001", "spare"))
    for name in ("traces/calibration.csv", "motion/spare.csv"):
        mine = tmp_path / "out" / name
        mine.parent.mkdir(exist_ok=True)
        mine.write_text("mine")
        code, said = call(*command)
        assert code == 2 and f"{name}: is there already" in said and mine.read_text() == "mine"
        mine.unlink()
    (tmp_path / "out/traces/calibration.csv").write_text("mine")
    assert call(*command, "--overwrite")[0] == 0
    assert (tmp_path / "out/traces/calibration.csv").read_text() != "mine"
    assert call(*command)[0] == 0  # it is of an import now


def test_training_from_a_configuration_overwrites_nothing_of_others(tmp_path, capsys):
    """`train.fit`, whose folder may be the one in which its configuration lies."""
    config = tmp_path / "config.yaml"
    config.write_text((ROOT / "configs/table1.yaml").read_text().replace("artifacts/table1", str(tmp_path)))
    (tmp_path / "table1_rig.yaml").write_text((ROOT / "configs/table1_rig.yaml").read_text())
    before = config.read_text()
    assert fit.main(["--config", str(config)]) == 2
    assert "config.yaml: is there already" in capsys.readouterr().err
    assert config.read_text() == before and len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("page", ("fleet", "score", "training"))
def test_every_page_says_where_it_comes_from(page, monkeypatch, tmp_path):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", EPOCH)
    origin = Origin("acf-jax <b>", {"my set": "0123456789abcdef"})
    if page == "fleet":
        text = fleet_page(Fleet(label="june", finished=DATE, rigs=()), [], str(origin))
    elif page == "score":
        rows = [NONE]
        text = str(score_page("rig", rows, summarise(rows), str(origin)))
    else:
        write_page(tmp_path / "report.html", "net", "", [], origin)
        text = (tmp_path / "report.html").read_text()
    foot = text.split("<footer>")[1].split("</footer>")[0]
    assert "Made on 2026-03-01 at 10:00 UTC by `acf-jax &lt;b&gt;` of my set (SHA-256 0123456789ab)." in foot


def test_what_a_command_wrote_it_may_write_again(call, tmp_path):
    for _ in range(2):
        assert call("export", "--c", "peak.h")[0] == 0
        assert call("export", "--surrogate", "shipped", "--c", "net.h")[0] == 0


def test_a_digest_is_of_names_and_contents(tmp_path):
    for name, content in {
        "a/x": b"1",
        "a/y": b"2",
        "b/x": b"1",
        "b/y": b"2",
        "c/x": b"2",
        "c/y": b"1",
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    a, b, c = (digest_of(tmp_path / name) for name in "abc")
    assert a == b != c
    assert digest_of(tmp_path / "a/x") == hashlib.sha256(b"1").hexdigest()


def test_an_origin_is_told_in_a_sentence(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", EPOCH)
    told = str(Origin("acf-jax diagnose set", {"set": "0123456789abcdef"}))
    assert told == "Made on 2026-03-01 at 10:00 UTC by `acf-jax diagnose set` of set (SHA-256 0123456789ab)."
    many = str(Origin("acf-jax fleet rigs", {f"rig-{n}": f"{n:064x}" for n in range(1000)}))
    assert (
        many.endswith(", rig-4 (SHA-256 000000000000), 995 others in provenance.json.")
        and "rig-5" not in many
    )
