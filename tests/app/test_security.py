"""Who is answered, what leads out of the chosen folders, and what a file's text can do."""

import asyncio
import json
import logging
from pathlib import Path
from urllib.parse import quote

import pytest
from served import TOKEN, Served, served

from acf_jax.app import uploads
from acf_jax.errors import InputError

EVIL = "<img src=x onerror=\"document.title='owned'\">"


def made(app: Served, name: str) -> str:
    """The address of a new session."""
    answer = app.post("/new", {"name": name})
    assert answer.status == 303
    return answer.headers["location"].removesuffix("/rig")


@pytest.mark.parametrize(
    "path", ["/", "/static/app.js", "/browse/0/", "/fleet", "/s/0/x/open", "/s/0/x/events"]
)
def test_nothing_is_told_without_the_token(app: Served, path: str) -> None:
    for cookie in (None, "", "acf-jax-token=guess", app.cookie[:-1]):
        answer = app.get(path, Cookie=cookie)
        assert answer.status == 401 and "session" not in answer.text.lower()
    assert app.get(f"{path}?token=guess", Cookie=None).status == 401


def test_the_token_of_the_address_becomes_a_cookie_that_scripts_and_other_sites_do_not_have(
    app: Served,
) -> None:
    answer = app.get(f"/?token={quote(TOKEN)}&shown=a%20b", Cookie=None, Origin=None)
    assert answer.status == 303 and answer.headers["location"] == "/?shown=a+b"
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie and "samesite=strict" in cookie


def test_a_token_in_the_address_changes_nothing(app: Served) -> None:
    before = list(app.home.iterdir())
    assert app.post(f"/new?token={quote(TOKEN)}", {"name": "x"}, Cookie=None).status == 401
    assert list(app.home.iterdir()) == before


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1", "127.0.0.1:1", "evil.example:80", "localhost.evil.example"]
)
def test_a_name_that_is_not_this_machine_s_is_refused(app: Served, host: str) -> None:
    """A page elsewhere whose name is made to lead here (DNS rebinding)."""
    assert app.get("/", Host=host).status == 421


def test_localhost_is_this_machine(app: Served) -> None:
    assert app.get("/", Host=f"localhost:{app.port}", Origin=None).status == 200


@pytest.mark.parametrize(
    "origin", ["https://evil.example", "null", "http://127.0.0.1", None, "http://localhost:{port}"]
)
def test_only_pages_of_this_server_change_anything(app: Served, origin: str | None) -> None:
    before = list(app.home.iterdir())
    own = origin and origin.format(port=app.port)
    for method, path in (
        ("POST", "/new"),
        ("PUT", "/upload?name=a.csv"),
        ("POST", "/s/0/x/cancel"),
        ("DELETE", "/"),
    ):
        assert app.ask(method, path, "name=x", Origin=own).status == 403
    assert list(app.home.iterdir()) == before
    if origin is not None:
        assert app.get("/", Origin=own).status == 403


def test_a_page_of_another_site_is_refused_whatever_origin_it_tells(app: Served) -> None:
    assert app.post("/new", {"name": "x"}, Sec_Fetch_Site="cross-site").status == 403


def test_every_answer_keeps_the_browser_here(app: Served) -> None:
    for path in ("/", "/static/page.js", "/nothing", "/s/0/none/open"):
        headers = app.get(path).headers
        policy = dict(part.strip().split(" ", 1) for part in headers["content-security-policy"].split(";"))
        assert policy["default-src"] == "'none'" and policy["script-src"] == "'self'"
        assert policy["connect-src"] == "'self'" and policy["frame-ancestors"] == "'none'"
        assert "http" not in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"
    assert "server" not in app.get("/").headers or "uvicorn" in app.get("/").headers["server"]


@pytest.mark.parametrize(
    "path",
    [
        "/browse/0/..", "/browse/0/%2e%2e", "/browse/0/..%2f..%2fetc", "/browse/0/%2fetc", "/browse/1/", "/browse/99/", 
        "/browse/" + "9" * 5000 + "/", "/browse/-1/", "/browse/x/", "/s/x/y/open",
        "/browse/0/a%00b", "/s/0/..%2f..%2fetc/open", "/s/0/%2e%2e/open", "/s/1/x/open", "/s/0/.hidden/open",
        "/static/..%2fserver.py", "/static/%2e%2e%2fserver.py", "/static/server.py",
    ],
)  # fmt: skip
def test_no_path_leads_out_of_the_chosen_folders(app: Served, path: str) -> None:
    answer = app.get(path)
    assert answer.status in (400, 404) and "root:" not in answer.text and "def _" not in answer.text


def test_files_of_a_session_are_what_commands_wrote_and_nothing_else(app: Served, tmp_path: Path) -> None:
    url = made(app, "files")
    folder = app.home / "files"
    (folder / "data").mkdir()
    (folder / "data/inside.json").write_text("{}")
    (tmp_path / "secret.txt").write_text("secret")
    assert app.get(f"{url}/file/data/inside.json").text == "{}"
    (folder / "data/link.txt").symlink_to(tmp_path / "secret.txt")
    for path in ("session.yaml", ".app/job.json", "data/../session.yaml", "data/%2e%2e/session.yaml", "data/link.txt",
                 "data/%2fetc%2fpasswd", "data"):  # fmt: skip
        answer = app.get(f"{url}/file/{path}")
        assert answer.status in (400, 404) and "secret" not in answer.text.replace("secret.txt", "")


@pytest.mark.parametrize("part", [".app", "data", "diagnosis", "plan", "surrogate", "rig.yaml", "recording"])
def test_a_session_with_a_link_that_leads_out_is_refused(app: Served, tmp_path: Path, part: str) -> None:
    url = made(app, f"linked {part.strip('.')}")
    folder = app.home / f"linked {part.strip('.')}"
    (folder / part).symlink_to(tmp_path)
    for answer in (
        app.get(f"{url}/open"),
        app.post(f"{url}/diagnose"),
        app.post(f"{url}/plan", {"of": "trials"}),
    ):
        assert answer.status == 400 and "outside the folders" in answer.text
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "file", ["diagnosis/report.html", "diagnosis/diagnosis.json", "data/trials.csv", ".app/import/job.json",
             "data/traces/t000.csv", "surrogate/model.eqx"],
)  # fmt: skip
def test_no_file_of_a_session_is_a_link_that_leads_out(app: Served, tmp_path: Path, file: str) -> None:
    name = f"linked {file.replace('/', ' ').replace('.', '')}"
    url = made(app, name)
    (tmp_path / "secret").write_text("secret")
    (app.home / name / file).parent.mkdir(parents=True, exist_ok=True)
    (app.home / name / file).symlink_to(tmp_path / "secret")
    for path in ("open", "diagnose", "use", "report.pdf", "file/diagnosis/report.html"):
        assert app.get(f"{url}/{path}").status == 400
    answer = app.post("/fleet", {"session": f"0/{name}"})
    assert "outside the folders" in answer.text and "secret" not in answer.text
    # one that stays in the chosen folders is taken
    (app.home / name / file).unlink()
    (app.home / name / file).symlink_to(app.home / name / "session.yaml")
    assert app.get(f"{url}/rig").status == 200


def test_comparisons_are_written_in_the_chosen_folders(tmp_path: Path) -> None:
    (tmp_path / "home/one/diagnosis").mkdir(parents=True)
    for name in ("diagnosis.json", "model.json"):
        (tmp_path / "home/one/diagnosis" / name).write_text("{}")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "home/fleets").symlink_to(tmp_path / "elsewhere")
    with served(tmp_path / "home") as app:
        answer = app.post("/fleet", {"session": "0/one"})
    assert answer.status == 400 and "outside the folders" in answer.text
    assert list((tmp_path / "elsewhere").iterdir()) == []


def test_a_session_file_that_names_a_recording_elsewhere_is_refused(app: Served, tmp_path: Path) -> None:
    """Session folders may come from others."""
    url = made(app, "foreign")
    (tmp_path / "other.csv").write_text("time_s,force_n\n0,1\n")
    (app.home / "foreign/session.yaml").write_text("schema: acf-session/1\nrecording: --out=x.csv\n")
    assert "begins with a dash" in app.get(f"{url}/open").text  # no option of a command
    for name in (str(tmp_path / "other.csv"), "../../etc/passwd"):
        (app.home / "foreign/session.yaml").write_text(
            f"schema: acf-session/1\nrecording: {json.dumps(name)}\n"
        )
        answer = app.get(f"{url}/open")
        assert answer.status == 400 and "outside the folders" in answer.text


def test_opening_in_place_stays_in_the_chosen_folders(app: Served, tmp_path: Path) -> None:
    (tmp_path / "rec.csv").write_text("time_s,force_n\n0,1\n")
    (app.home / "link.csv").symlink_to(tmp_path / "rec.csv")
    before = sorted(p.name for p in app.home.iterdir())
    for path in ("link.csv", "../x", str(tmp_path / "rec.csv"), "a\0b"):
        assert app.post("/open", {"place": "0", "path": path}).status == 400
    assert app.post("/open", {"place": "-1", "path": "x"}).status == 400
    assert sorted(p.name for p in app.home.iterdir()) == before


def test_a_page_that_a_command_wrote_has_a_sandbox_of_its_own(app: Served) -> None:
    url = made(app, "boxed")
    (app.home / "boxed/diagnosis").mkdir()
    (app.home / "boxed/diagnosis/report.html").write_text("<script>document.title = document.cookie</script>")
    shown = app.get(f"{url}/file/diagnosis/report.html")
    policy = shown.headers["content-security-policy"]
    assert policy.startswith("sandbox allow-scripts") and "allow-same-origin" not in policy
    assert "default-src 'none'" in policy
    assert (
        "attachment" in app.get(f"{url}/file/diagnosis/report.html?download=1").headers["content-disposition"]
    )


@pytest.mark.parametrize(
    "name",
    [
        "",
        "../a.csv",
        "a/b.csv",
        "..",
        ".hidden",
        "a\\b.csv",
        "a\nb",
        "-rf.csv",
        "a.csv ",
        "x" * 300,
        "a\0.csv",
    ],
)
def test_names_of_uploads_are_plain(app: Served, tmp_path: Path, name: str) -> None:
    before = sorted(app.home.rglob("*"))
    file = tmp_path / "a.csv"
    file.write_text("x")
    answer = app.ask("PUT", f"/upload?name={quote(name)}", file.read_bytes())
    assert answer.status == 400 and "file name" in answer.text
    assert sorted(app.home.rglob("*")) == before


def test_an_upload_beyond_the_limit_leaves_nothing(app: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uploads.receive, "__defaults__", (1000,))
    before = sorted(app.home.rglob("*"))
    answer = app.ask("PUT", "/upload?name=large.csv", b"x" * 1001, Accept="application/json")
    assert answer.status == 400 and "open it in place" in " ".join(answer.json["faults"]).replace(
        "and open it", "open it"
    )
    assert sorted(app.home.rglob("*")) == before
    assert app.ask("PUT", "/upload?name=small.csv", b"x" * 1000).status == 200


def test_a_form_has_a_limit(app: Served) -> None:
    assert app.post("/new", "name=" + "x" * 5_000_000).status == 413
    assert (
        app.post(
            "/new", "&".join(f"a{i}=1" for i in range(3000)), Content_Type="application/x-www-form-urlencoded"
        ).status
        == 400
    )


def test_texts_of_files_and_forms_are_escaped(app: Served) -> None:
    url = made(app, "escaped")
    folder = app.home / "escaped"
    (folder / "recording").mkdir()
    name = "a&b<i>.csv"
    (folder / "recording" / name).write_text(
        f"time_s,{EVIL},velocity_m_per_s,pretension_n\n0,1,2,3\n0.1,1,2,3\n"
    )
    (folder / "session.yaml").write_text(
        f"schema: acf-session/1\nrecording: {json.dumps(f'recording/{name}')}\n"
    )
    (folder / "mapping.yaml").write_text(f"force: {json.dumps(EVIL)}\n")
    pages = [app.get(f"{url}/open").text, app.get(f"/browse/0/{quote('escaped/recording')}").text]
    pages.append(app.post(f"{url}/rig", {"m-unit": EVIL}).text)
    pages.append(app.get(f"/fleet?shown={quote(EVIL)}").text + app.get(f"/s/0/{quote(EVIL)}/open").text)
    assert all("<img" not in page and "<i>" not in page for page in pages)
    assert "&lt;img" in pages[0]


@pytest.mark.parametrize("site", ["same-site", "cross-site"])
@pytest.mark.parametrize(
    "path", ["open", "curve?v_e=1", "preview?name=x", "report.pdf", "events", "script.sh", "file/data/x"]
)
def test_no_other_page_of_this_machine_may_start_work(app: Served, site: str, path: str) -> None:
    """A page on another port of localhost is of the same site: the browser gives it the cookie."""
    url = made(app, "other pages")
    for dest in ("document", "iframe", "image", "empty", "script"):
        answer = app.get(f"{url}/{path}", Sec_Fetch_Site=site, Sec_Fetch_Dest=dest, Origin=None)
        assert answer.status == 403 and "begin at its first page" in answer.text
    assert app.get(f"{url}/open", Sec_Fetch_Site="same-origin", Origin=None).status == 200
    assert app.get(f"{url}/open", Sec_Fetch_Site="none", Origin=None).status == 200  # typed, or a bookmark
    assert app.get(f"{url}/open", Origin="http://127.0.0.1:1").status == 403


def test_a_link_to_the_printed_address_may_lie_on_another_page(app: Served) -> None:
    there = {"Sec_Fetch_Site": "same-site", "Sec_Fetch_Dest": "document", "Origin": None}
    assert app.get(f"/?token={quote(TOKEN)}", Cookie=None, **there).status == 303
    assert app.get("/", **there).status == 200
    assert app.get("/", **there | {"Sec_Fetch_Dest": "iframe"}).status == 403


def test_a_second_app_on_another_port_has_a_cookie_of_its_own(app: Served, tmp_path: Path) -> None:
    with served(tmp_path) as other:
        assert other.get("/", Cookie=app.cookie).status == 401


def test_plain_names_are_taken() -> None:
    assert uploads.file_name("Messung 3 (neu)+1.mcap") == "Messung 3 (neu)+1.mcap"
    with pytest.raises(InputError):
        uploads.file_name("a:b")


@pytest.mark.parametrize("fault, is_told", [(asyncio.CancelledError(), False), (ValueError("x"), True)])
def test_an_answer_that_the_end_cuts_off_is_no_fault(fault: BaseException, is_told: bool) -> None:
    from acf_jax.app.serve import _is_told

    told = (type(fault), fault, None)
    record = logging.LogRecord(
        "uvicorn.error", logging.ERROR, "", 1, "Exception in ASGI application", (), told
    )
    assert _is_told(record) == is_told
