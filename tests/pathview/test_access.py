"""Who gets an answer from the server behind ``view``, and what its pages may do."""

import json
import os
import re
import select
import socket
import subprocess
import sys
import threading
from pathlib import Path
from urllib.parse import quote, urlsplit

import pytest
from pathview_models import block, event, model, subsystem
from served_pathview import page_headers

from pathsim_jsbsim_blocks.errors import DiagramError
from pathsim_jsbsim_blocks.pathview import page, view
from pathsim_jsbsim_blocks.pathview.server import Server
from pathsim_jsbsim_blocks.pathview.toolboxes import Toolbox

pathview = pytest.importorskip("pathview")

ODD = "a b#c?d%20&e.pvm"
PAGES = [
    "/",
    "/editor",
    "/editor.html",
    "/index.html",
    "/somewhere/else",
    "/model/a/b",
    "/..%2f..%2fetc/passwd",
]


@pytest.fixture(scope="module")
def server():
    with Server(
        {"one.pvm": {"graph": {"nodes": []}}, ODD: {"graph": {"nodes": []}}}, port=0
    ) as server:
        threading.Thread(target=server.run, daemon=True).start()
        yield server


@pytest.fixture(scope="module")
def cookie(server):
    return page_headers(server.url())["Cookie"]


@pytest.fixture
def ask(server, cookie):
    """A request as a browser sends it: by default from the page, once it has its cookie."""

    def ask(path, method="GET", **changes):
        headers = {
            "Host": urlsplit(server.address).netloc,
            "Cookie": cookie,
            "Sec-Fetch-Site": "same-origin",
            "Origin": server.address,
            **changes,
        }
        client = server.app.test_client(use_cookies=False)
        port = urlsplit(server.address).port
        return client.open(
            path,
            method=method,
            json={} if method == "POST" else None,
            environ_overrides={"SERVER_PORT": str(port)},
            headers={k: v for k, v in headers.items() if v is not None},
        )

    return ask


def token(server):
    return server.url().rpartition("token=")[2]


CALLS = [
    ("GET", "/api/health"),
    ("POST", "/api/init"),
    ("POST", "/api/exec"),
    ("POST", "/api/eval"),
    ("POST", "/api/stream/start"),
    ("POST", "/api/stream/poll"),
    ("POST", "/api/stream/exec"),
    ("POST", "/api/stream/stop"),
    ("DELETE", "/api/session"),
    ("OPTIONS", "/api/exec"),
]


@pytest.mark.parametrize(("method", "path"), CALLS)
def test_code_runs_only_for_the_served_page(method, path, ask, server, cookie):
    # without X-Session-ID, PathView itself says 400: the call has reached it and starts no worker
    assert ask(path, method).status_code in (200, 400)
    for changes in [
        {"Cookie": None},
        {"Cookie": cookie + "x"},
        {"Sec-Fetch-Site": None},
        {"Sec-Fetch-Site": "none"},
        {"Sec-Fetch-Site": "same-site"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-origin, same-origin"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": ""},
        {"Origin": "http://127.0.0.1:1"},
        {"Host": "evil.example"},
    ]:
        assert ask(path, method, **changes).status_code == 403, changes
    # browsers name the origin with whatever writes
    assert (ask(path, method, Origin=None).status_code == 403) == (method != "GET")
    if method != "GET":  # an address is for opening pages
        assert ask(f"{path}?token={token(server)}", method, Cookie=None).status_code == 403


@pytest.mark.parametrize(
    "path",
    [*PAGES, "/favicon.png", "/model/one.pvm", "/katex/katex.min.css", "/model/none.pvm"],
)
def test_without_the_token_there_is_nothing(path, ask, server, cookie):
    for changes in [
        {"Cookie": None},
        {"Cookie": cookie[:-1]},
        {"Cookie": cookie + "\xe9"},
        {"Cookie": cookie.replace("=", "0=")},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
        {"Sec-Fetch-Site": None},
    ]:
        answer = ask(path, **changes)
        assert answer.status_code == 403
        assert token(server) not in answer.text
        assert "open the address that the command has printed" in answer.text
    assert ask(path).status_code == (404 if "none" in path else 200)
    assert ask(path, Host="rebound.example:80").status_code == 403
    assert ask(f"{path}?token=x", Cookie=None).status_code == 403
    assert ask(f"{path}?token=%E9", Cookie=None).status_code == 403


def test_the_token_gets_a_cookie_of_this_port_without_a_redirect(ask, server):
    path = server.url("one.pvm").removeprefix(server.address)
    answer = ask(path, **{"Cookie": None, "Sec-Fetch-Site": "cross-site"})
    assert answer.status_code == 200
    cookie = answer.headers["Set-Cookie"]
    name, _, value = cookie.partition(";")[0].partition("=")
    assert name == f"pathsim-jsbsim-{urlsplit(server.address).port}"
    assert len(value) == 43  # 256 bits
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    assert "Set-Cookie" not in ask("/editor").headers
    with Server({}, port=0) as other:
        assert token(other) != token(server)
    assert len(token(server)) == 43  # 256 bits


def test_the_token_in_a_cookie_is_worth_nothing(ask, server):
    """Other users see the address in the browser's command line, and can write any header."""
    name = f"pathsim-jsbsim-{urlsplit(server.address).port}"
    for method, path in [*CALLS, ("GET", "/")]:
        assert ask(path, method, Cookie=f"{name}={token(server)}").status_code == 403


@pytest.mark.parametrize("path", PAGES)
def test_each_page_has_a_policy_and_no_inline_script_but_ours(path, ask):
    answers = [ask(path), ask(path, **{"If-None-Match": "*"})]
    nonces = set()
    for answer in answers:
        assert answer.status_code == 200
        assert answer.mimetype == "text/html"
        assert "no-store" in answer.headers["Cache-Control"]
        rules = dict(
            rule.split(" ", 1) for rule in answer.headers["Content-Security-Policy"].split("; ")
        )
        nonce = re.fullmatch(r"'self' 'nonce-([\w-]{22})'", rules["script-src"])[1]
        assert rules["connect-src"] == "'self'"
        for name in ("default-src", "frame-ancestors", "base-uri", "form-action"):
            assert rules[name] == "'none'"
        scripts = re.findall(r"<script([^>]*)>", answer.text)
        assert len(scripts) >= 2
        assert all(f'nonce="{nonce}"' in attributes for attributes in scripts)
        assert "pathview.toolboxes.v1" in answer.text
        nonces.add(nonce)
    assert len(nonces) == 2


@pytest.mark.parametrize("path", PAGES)
def test_a_page_opens_only_what_is_served(path, ask, server):
    origin = server.address
    for good in [
        "",
        "model=/model/one.pvm",
        f"model={quote('/model/' + quote(ODD), safe='')}",
        "model=/examples/vanderpol.json",
        "backend=flask",
        f"backend=flask&host={origin}",
        "theme=dark",
        "new=1",
        "tour=start",
    ]:
        assert ask(f"{path}?{good}").status_code == 200, good
    for bad in [
        "model=http://evil.example/x.pvm",
        "model=//evil.example/model/one.pvm",
        "model=/model/none.pvm",
        "model=/model/../model/one.pvm",
        "model=one.pvm",
        "model=%5C%5Cevil.example/model/one.pvm",
        "model=/api/health",
        "model=",
        "model=/model/one.pvm&model=http://evil.example/x.pvm",
        "model=data:,{}",
        "model=/examples/../index.html",
        "model=/examples/none.json",
        "model=/examples/..",
        "modelgh=someone/something",
        "backend=pyodide",
        "backend=",
        "host=http://evil.example",
        "backend=flask&host=http://127.0.0.1:1",
        "m%6Fdelgh=x",
        "unheard=of",
    ]:
        answer = ask(f"{path}?{bad}")
        assert answer.status_code == 403, bad
        assert "<script" not in answer.text
    assert "<img" not in ask(f"{path}?model=<img src=q>").text


def test_an_odd_file_name_opens(ask, server):
    assert ask(server.url(ODD).removeprefix(server.address)).status_code == 200
    assert ask(f"/model/{quote(ODD)}").json == {"graph": {"nodes": []}}


def test_what_is_no_page_has_a_policy_too(ask):
    for path in ("/model/one.pvm", "/api/health", "/favicon.png", "/katex/katex.min.css"):
        headers = ask(path).headers
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert "script-src 'self';" in headers["Content-Security-Policy"]


def test_formulas_need_no_other_server(ask):
    static = Path(pathview.__file__).parent / "static"
    loading = [f for f in (static / "app").rglob("*.js") if "/npm/katex@" in f.read_text()]
    assert loading
    [version] = {v for f in loading for v in re.findall(r"/npm/katex@([\d.]+)/", f.read_text())}
    style = ask("/katex/katex.min.css").text
    assert f'content:"{version}"' in style  # else take that version's style sheet and fonts
    for file in loading:
        path = f"/{file.relative_to(static).as_posix()}"
        answer = ask(path)
        assert answer.mimetype == "text/javascript"
        assert "/npm/katex@" not in answer.text
        fonts = re.findall(r"/(KaTeX_[\w-]+\.woff2)", answer.text)
        assert all(ask(f"/katex/fonts/{font}").status_code == 200 for font in fonts)
        assert ask(path, **{"If-None-Match": answer.headers["ETag"]}).status_code == 304
    for font in re.findall(r"url\((fonts/[\w-]+\.woff2)\)", style):
        assert ask(f"/katex/{font}").status_code == 200


def test_a_toolboxs_name_cannot_end_the_script():
    text, nonce = page.rendered(
        "<head></head><script>1</script>", [Toolbox("</script><script>alert(1)</script>", "os")]
    )
    assert re.findall(r"<(/?script[^>]*)>", text) == [
        f'script nonce="{nonce}"',
        "/script",
        f'script nonce="{nonce}"',
        "/script",
    ]


LINUX = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="reads Linux's table of connections"
)
CLIENT = """if 1:
    import os, socket, sys
    "".encode("idna")  # another user cannot read this Python's modules
    family, host, port, user, request, wait = sys.argv[1:]
    os.setuid(int(user))
    with socket.socket(getattr(socket, family)) as s:
        s.connect((host, int(port)))
        s.sendall(request.encode())
        print(s.makefile("rb").readline().decode() if wait == "wait" else "")"""


def written(server, secret):
    """The requests of a page as a program writes them, with the token or the cookie."""
    cookie = page_headers(server.url())["Cookie"]
    if secret == "token":
        path = server.url().removeprefix(server.address)
        return [f"GET {path} HTTP/1.0\r\nHost: 127.0.0.1\r\n\r\n"]
    return [
        f"{call} HTTP/1.0\r\nHost: 127.0.0.1\r\nCookie: {cookie}\r\nSec-Fetch-Site: same-origin\r\n"
        f"Origin: http://127.0.0.1\r\nContent-Type: application/json\r\nContent-Length: 2\r\n\r\n{{}}"
        for call in ("GET /editor", "GET /model/one.pvm", "GET /favicon.png", "POST /api/session")
    ]


@LINUX
@pytest.mark.parametrize("secret", ["token", "cookie"])
def test_another_user_with_the_token_or_the_cookie_gets_nothing(secret, server):
    if os.getuid() != 0:
        pytest.skip("only root can act as another user")
    port = str(urlsplit(server.address).port)
    for request in written(server, secret):
        for family, host in (("AF_INET", "127.0.0.1"), ("AF_INET6", "::ffff:127.0.0.1")):
            answers = []
            for user in ("65534", "0"):
                command = [sys.executable, "-c", CLIENT, family, host, port, user, request, "wait"]
                answer = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
                answers.append(answer.stdout.split()[1])
            assert answers[0] == "403"
            assert answers[1] in ("200", "405")  # PathView knows DELETE there only


@LINUX
def test_a_connection_that_its_program_has_closed_is_nobodys():
    """Linux may list such a socket as owned by root, so its owner cannot be known."""
    with Server({}, port=0) as server:
        statuses, answered = [], threading.Event()

        @server.app.after_request
        def note(response):
            statuses.append(response.status_code)
            answered.set()
            return response

        path = server.url().removeprefix(server.address)
        request = f"GET {path} HTTP/1.0\r\nHost: 127.0.0.1\r\n\r\n"
        port = str(urlsplit(server.address).port)
        user = str(os.getuid())
        command = [sys.executable, "-c", CLIENT, "AF_INET", "127.0.0.1", port, user, request, "go"]
        subprocess.run(command, check=True)  # the connection waits to be accepted
        threading.Thread(target=server.run, daemon=True).start()
        assert answered.wait(10)
        assert statuses == [403]


@pytest.mark.parametrize(
    "name", ["step $x$<img src=q onerror=alert(1)>", "<b>$x$", "$x$ </p>", "$a$<!-- $b$"]
)
@pytest.mark.parametrize("place", ["block", "port", "event", "inside"])
def test_a_name_that_the_page_takes_for_html_is_refused(name, place, tmp_path):
    one = block("a", "Constant")
    content = {
        "block": lambda: model({**one, "name": name}),
        "port": lambda: model({**one, "outputs": [{"id": "a-output-0", "name": name}]}),
        "event": lambda: model(events=[event(name, func_act="print")]),
        "inside": lambda: model(subsystem("s", block("i", "Interface"), {**one, "name": name})),
    }[place]()
    assert f"the name {name!r} has HTML" in refused(content, tmp_path)


@pytest.mark.parametrize("address", ["javascript:alert(1)", '" onmouseover="alert(1)', "data:,x"])
def test_a_note_with_a_link_that_runs_something_is_refused(address, tmp_path):
    note = {"id": "n", "content": f"see [this]({address})"}
    assert "not a web address" in refused(model(annotations=[note]), tmp_path)


def refused(content, folder):
    """What ``view`` says of a model that it does not open."""
    path = folder / "model.pvm"
    path.write_text(json.dumps(content))
    with pytest.raises(DiagramError) as error:
        view(path, browser=False)
    return str(error.value)


def sent(server, headers, pieces):
    """Status of a request whose body comes in pieces, and how many were sent before the answer.

    A server that closes a connection with bytes that it has not read resets it, and the answer may
    be lost: the status is then "closed".
    """
    place = urlsplit(server.address)
    kind = "Content-Type: application/json"
    lines = ["POST /api/exec HTTP/1.1", f"Host: {place.netloc}", kind, *headers, "", ""]
    count = 0
    with socket.create_connection((place.hostname, place.port), timeout=30) as connection:
        connection.sendall("\r\n".join(lines).encode())
        try:
            for count, piece in enumerate(pieces):
                if select.select([connection], [], [], 0.5 if count == 0 else 0)[0]:
                    break
                connection.sendall(piece)
            return connection.recv(100).decode().split(" ")[1], count
        except ConnectionError:
            return "closed", count


def test_a_request_without_a_secret_is_refused_before_its_body_is_read(server, cookie):
    size = 30 * 2**20
    pieces = [b"x" * 2**20] * 30
    assert sent(server, [f"Content-Length: {size}"], pieces) == ("403", 0)
    assert sent(server, ["Transfer-Encoding: chunked"], [b"5\r\nhello\r\n"] * 9) == ("403", 0)
    asked = [f"Cookie: {cookie}", "Sec-Fetch-Site: same-origin", f"Origin: {server.address}"]
    # with the secrets PathView reads it, and misses the session
    assert sent(server, [*asked, f"Content-Length: {size}"], pieces)[0] == "400"


def test_a_body_is_at_most_32_mib(server, cookie):
    asked = [f"Cookie: {cookie}", "Sec-Fetch-Site: same-origin", f"Origin: {server.address}"]
    assert sent(server, [*asked, f"Content-Length: {2**25 + 1}"], [b"x"]) == ("413", 0)
    chunk = b"100000\r\n" + b"x" * 2**20 + b"\r\n"
    session = "X-Session-ID: too-large"
    body = json.dumps({"id": "x", "code": "1"}).encode()
    for pieces in ([chunk] * 100, [b"%x\r\n%s\r\n" % (len(body), body), *[chunk] * 100]):
        status, count = sent(server, [*asked, session, "Transfer-Encoding: chunked"], pieces)
        assert status in ("413", "closed")
        assert count <= 40
    # neither has reached PathView, which would have a worker for the session
    assert "too-large" not in pathview.app._sessions
    small = [*asked, session, f"Content-Length: {len(body)}"]
    assert sent(server, small, [body])[0] == "200"
    assert "too-large" in pathview.app._sessions
    pathview.app.remove_session("too-large")


def test_a_path_that_no_file_system_takes_is_one_more_unknown_path(ask, capfd):
    for path in ("/" + 300 * "a", 3000 * "/a", "/%00", f"/?model=/examples/{300 * 'a'}"):
        assert ask(path, Cookie=None).status_code == 403
        assert ask(path).status_code == (403 if "model" in path else 200)
    assert capfd.readouterr().err == ""
