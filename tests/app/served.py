"""The app as it is served, in a thread of the test, and requests that are as rough as they have to be."""

import http.client
import json
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from needs import need_module

from acf_jax.app import jobs

TOKEN = "a token that nobody guesses"
RIG = {
    "m-value": "2.10", "m-std": "0.04", "m-unit": "kg", "d-value": "60", "d-std": "18", "d-unit": "N s/m",
    "k_f-value": "0.8", "k_f-std": "0.5", "k_f-unit": "N/mm", "k_c-value": "340", "k_c-std": "40",
    "k_c-unit": "N/mm",
}  # fmt: skip


@dataclass
class Answer:
    status: int
    headers: dict[str, str]
    text: str

    @property
    def json(self) -> Any:
        return json.loads(self.text)


@dataclass
class Served:
    """Where the app answers, and how to ask it as its own pages do."""

    port: int
    home: Path
    cookie: str = ""
    usual: dict[str, str] = field(init=False)

    def __post_init__(self) -> None:
        self.cookie = f"acf-jax-token-{self.port}={TOKEN}"
        self.usual = {"Host": f"127.0.0.1:{self.port}", "Cookie": self.cookie, "Origin": self.origin}

    @property
    def origin(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def address(self) -> str:
        return f"{self.origin}/?{urlencode({'token': TOKEN})}"

    def ask(self, method: str, path: str, body: Any = None, **headers: str | None) -> Answer:
        """A header that is None is left out."""
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        sent = {name: value for name, value in {**self.usual, **named}.items() if value is not None}
        if isinstance(body, dict):
            body = urlencode(body, doseq=True)
            sent.setdefault("Content-Type", "application/x-www-form-urlencoded")
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        connection.request(method, path, body, sent)
        answer = connection.getresponse()
        found = Answer(answer.status, {k.lower(): v for k, v in answer.getheaders()}, answer.read().decode())
        connection.close()
        return found

    def get(self, path: str, **headers: str | None) -> Answer:
        return self.ask("GET", path, **headers)

    def post(self, path: str, fields: Any = None, **headers: str | None) -> Answer:
        return self.ask("POST", path, fields or {}, **headers)

    def upload(self, path: Path, name: str = "", session: str = "") -> Answer:
        query = {"name": name or path.name} | ({"session": session} if session else {})
        return self.ask("PUT", f"/upload?{urlencode(query)}", path.read_bytes(), Accept="application/json")


@contextmanager
def served(home: Path, *others: Path, port: int = 0) -> Iterator[Served]:
    """The app on a free port of this machine."""
    uvicorn = need_module("uvicorn", "pip install 'acf-jax[app]'")
    need_module("starlette", "pip install 'acf-jax[app]'")
    from acf_jax.app.server import make_app

    with socket.socket() as listening:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind(("127.0.0.1", port))
        port = listening.getsockname()[1]
        app = make_app([home, *others], TOKEN, port)
        config = uvicorn.Config(app, log_level="critical", timeout_graceful_shutdown=1, ws="none")
        server = uvicorn.Server(config)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, daemon=True)
        listening.listen(64)  # requests wait until the thread takes them
        thread.start()
        try:
            yield Served(port, home)
        finally:
            server.should_exit = True
            thread.join()


def wait(app: Served, url: str) -> jobs.Job:
    """The last job of a session, once it has ended."""
    folder = app.home / url.rpartition("/")[2].replace("%20", " ")
    end = time.monotonic() + 300
    while time.monotonic() < end:
        job = jobs.last(folder)
        if job is not None and not job.is_running:
            return job
        time.sleep(0.02)
    raise AssertionError("the job does not end")
