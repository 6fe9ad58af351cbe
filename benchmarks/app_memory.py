"""A 2 GB recording in the app: time and peak memory of the server and of its helpers, from the upload to the cuts.

python -m benchmarks.app_memory
"""

import argparse
import http.client
import json
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlencode, urlsplit

from benchmarks.import_memory import write_bag
from benchmarks.machine import describe

PIECE = 1 << 20  # bytes of the upload at once
EVERY_S = 0.05  # between two looks at the memory
ROLES = {"force": ["/wrench", "wrench.force.z"], "speed": ["/twist", "twist.linear.z"]}


class Watched:
    """Largest resident memory of a process and of each of its descendants since it was last asked, by /proc."""

    def __init__(self, pid: int):
        self.pid, self.server, self.helper, self.lives = pid, 0.0, 0.0, True
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self) -> None:
        while self.lives:
            self.server = max(self.server, megabytes(self.pid))
            self.helper = max([self.helper, *map(megabytes, descendants(self.pid))])
            time.sleep(EVERY_S)

    def told(self) -> tuple[float, float]:
        """Of the server and of the largest helper, MB."""
        found = self.server, self.helper
        self.server = self.helper = 0.0
        return found


def megabytes(pid: int) -> float:
    """Resident memory of a process; 0 of one that has ended."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return 0.0
    return next((int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS")), 0.0)


def descendants(pid: int) -> list[int]:
    """Processes that a process has started, directly or not."""
    try:
        found = [int(c) for c in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
        for task in Path(f"/proc/{pid}/task").iterdir():
            found += [int(c) for c in (task / "children").read_text().split()]
    except OSError:
        return []
    return [child for c in set(found) for child in (c, *descendants(c))]


class App:
    """The app in a process of its own, asked as its pages ask it."""

    def __init__(self, home: Path):
        command = [sys.executable, "-m", "acf_jax", "app", str(home), "--no-browser"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()
        address = urlsplit(self.address)
        self.host = address.netloc
        token = address.query.partition("=")[2]
        cookie = f"acf-jax-token-{address.port}={token}"
        self.headers = {
            "Host": self.host,
            "Cookie": cookie,
            "Origin": f"http://{self.host}",
            "Accept": "application/json",
        }

    def ask(self, method: str, path: str, body: Any = None, **headers: str) -> str:
        connection = http.client.HTTPConnection(self.host, timeout=3600)
        connection.request(method, path, body, self.headers | headers)
        answer = connection.getresponse()
        text = answer.read().decode()
        assert answer.status < 400, text
        return text


def pieces(path: Path) -> Iterator[bytes]:
    with path.open("rb") as file:
        while piece := file.read(PIECE):
            yield piece


@contextmanager
def app_in(home: Path) -> Iterator[App]:
    app = App(home)
    try:
        yield app
    finally:
        app.process.terminate()
        app.process.wait()


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.app_memory", description=__doc__.splitlines()[0]
    )
    parser.add_argument(
        "--gigabytes", type=float, default=2.0, help="size of the bag, most of it a camera's images"
    )
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as name:
        home = Path(name) / "sessions"
        home.mkdir()
        bag = Path(name) / "bag"
        write_bag(bag, options.gigabytes, camera=True)
        recording = next(bag.glob("*.mcap"))
        size = recording.stat().st_size
        print(f"{describe()}\n\na bag of {size / 1e9:.2f} GB\n")
        print("| | s | server, MB | largest helper, MB |")
        print("|---|--:|--:|--:|")
        with app_in(home) as app:
            watched = Watched(app.process.pid)
            time.sleep(2 * EVERY_S)

            def told(step: str, begin: float) -> None:
                server, helper = watched.told()
                print(
                    f"| {step} | {time.perf_counter() - begin:.1f} | {server:,.0f} | {helper:,.0f} |",
                    flush=True,
                )

            told("started", time.perf_counter())
            begin = time.perf_counter()
            sent = app.ask(
                "PUT", "/upload?name=large.mcap", pieces(recording), **{"Content-Length": str(size)}
            )
            told("uploaded", begin)
            page = json.loads(sent)["next"]
            url = page.removesuffix("/open")
            begin = time.perf_counter()
            app.ask("GET", page)
            told("what it holds", begin)
            begin = time.perf_counter()
            topic, field = ROLES["force"]
            app.ask("GET", f"{url}/preview?{urlencode({'name': topic, 'field': field})}")
            told("the force previewed", begin)
            begin = time.perf_counter()
            fields = {role: json.dumps(value) for role, value in ROLES.items()}
            fields |= {
                "speed-kind": "velocity",
                "pretension": "number",
                "pretension-number": "60",
                "version": "none",
            }
            kind = {"Content-Type": "application/x-www-form-urlencoded"}
            app.ask("POST", f"{url}/signals", urlencode(fields), **kind)
            job = home / "large/.app/import"
            while not (job / "code.txt").exists():
                time.sleep(EVERY_S)
            told(f"cut: {(job / 'output.txt').read_text().splitlines()[0]}", begin)
            watched.lives = False


if __name__ == "__main__":
    main()
