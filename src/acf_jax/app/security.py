"""Who may ask, and for what: a token, this machine's own names, this page's own origin, and paths within folders.

Every answer forbids the browser to load anything from elsewhere. Pages that a command wrote, such as report.html, are
shown in a sandbox of their own: what a recording brought into one reaches neither the cookie nor another page.
"""

import hmac
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple
from urllib.parse import parse_qs, urlencode

from starlette.datastructures import Headers
from starlette.requests import cookie_parser
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from acf_jax.errors import InputError
from acf_jax.files import inside

COOKIE = "acf-jax-token"
NAMES = ("127.0.0.1", "localhost", "[::1]")  # of this machine, in an address
SAFE = ("GET", "HEAD")
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:;"
    " connect-src 'self'; frame-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)
SANDBOX = (
    "sandbox allow-scripts allow-downloads allow-modals; default-src 'none'; script-src 'unsafe-inline';"
    " style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; frame-ancestors 'self'"
)
HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "same-origin",  # with no-referrer a form would tell no origin
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class Guard:
    """In front of the application: refuses what does not come from a page that this server showed."""

    def __init__(self, app: ASGIApp, token: str, port: int):
        self.app, self.token = app, token
        self.hosts = {f"{name}:{port}" for name in NAMES} | (set(NAMES) if port == 80 else set())
        self.cookie = f"{COOKIE}-{port}"  # cookies do not tell ports apart

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            if scope["type"] == "lifespan":
                await self.app(scope, receive, send)
            return

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                given = {name.lower() for name, _ in message["headers"]}
                for name, value in (
                    {"Content-Security-Policy": POLICY, "Cache-Control": "no-store"} | HEADERS
                ).items():
                    if name.lower().encode() not in given:
                        message["headers"].append((name.encode(), value.encode()))
            await send(message)

        answer = self._refusal(scope) or self._welcome(scope)
        await (answer or self.app)(scope, receive, guarded)

    def _refusal(self, scope: Scope) -> Response | None:
        """The answer to what does not come from here; None where it does."""
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if host not in self.hosts:
            return PlainTextResponse("This name is none of this machine's own.", 421)
        origin, site = headers.get("origin"), headers.get("sec-fetch-site", "same-origin")
        if origin is not None and origin != f"http://{host}":
            return PlainTextResponse("Only pages of this server may ask.", 403)
        if scope["method"] not in SAFE and (origin is None or site != "same-origin"):
            return PlainTextResponse("Only pages of this server may change anything.", 403)
        # a page on another port is of the same site, and brings the cookie along
        is_followed = scope["path"] == "/" and headers.get("sec-fetch-dest") == "document"
        if site not in ("same-origin", "none") and not is_followed:
            return PlainTextResponse("Only pages of this server may ask; begin at its first page.", 403)
        return None

    def _welcome(self, scope: Scope) -> Response | None:
        """The answer to who has no cookie yet: the token in the address becomes one; None for who has it."""
        headers = Headers(scope=scope)
        if self._is_token(cookie_parser(headers.get("cookie", "")).get(self.cookie, "")):
            return None
        asked = parse_qs(scope["query_string"].decode("latin-1"))
        if scope["method"] in SAFE and self._is_token(asked.pop("token", [""])[0]):
            rest = urlencode(asked, doseq=True)
            answer = RedirectResponse(f"{scope['path']}{f'?{rest}' if rest else ''}", 303)
            answer.set_cookie(self.cookie, self.token, httponly=True, samesite="strict", path="/")
            return answer
        text = "Open the address that `acf-jax app` printed: it holds the token that this page needs."
        return PlainTextResponse(text, 401)

    def _is_token(self, text: str) -> bool:
        return hmac.compare_digest(text.encode(), self.token.encode())


class Places(NamedTuple):
    """The folders that were chosen on the command line; no path leads out of them."""

    folders: Sequence[Path]

    def resolve(self, number: int, relative: str) -> Path:
        """A path within the folder of that number, links followed; `InputError` where it leaves it."""
        if not 0 <= number < len(self.folders):
            raise InputError(f"folder {number}: is none of those that the app was started with")
        if "\0" in relative:
            raise InputError("the path holds a null character; name a file")
        return inside(self.folders[number], relative)

    def check(self, path: Path) -> Path:
        """The path itself, links followed; `InputError` where it lies in none of the folders."""
        real = path.resolve()
        if not any(real.is_relative_to(folder) for folder in self.folders):
            raise InputError(
                f"{path}: lies outside the folders that the app was started with; name its folder there"
            )
        return real
