"""``view`` as a user starts it: a process of its own, and what it leaves behind."""

import os
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import urlopen

COMMAND = [sys.executable, "-m", "pathsim_jsbsim_blocks.cli", "view"]


def page_headers(url):
    """What a browser sends with the requests of the page, once it has opened a printed address."""
    with urlopen(url, timeout=30) as answer:
        cookie = answer.headers["Set-Cookie"].partition(";")[0]
    return {
        "Cookie": cookie,
        "Sec-Fetch-Site": "same-origin",
        "Origin": f"http://{urlsplit(url).netloc}",
    }


class Served:
    """``pathsim-jsbsim view`` in a folder of its own."""

    def __init__(self, folder, *arguments, env=None):
        self.home, self.temporary = folder / "home", folder / "tmp"
        self.home.mkdir()
        self.temporary.mkdir()
        # the address must come at once, also through a pipe
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONUNBUFFERED"}
        self.process = subprocess.Popen(
            [*COMMAND, *arguments],
            cwd=self.home,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**environment, "TMPDIR": str(self.temporary), **(env or {})},
        )
        line = self.process.stdout.readline()
        found = re.search(r"http://127\.0\.0\.1:(\d+)/\S*", line)
        if not found:
            self.process.kill()
            raise AssertionError(line + self.process.stderr.read())
        self.url, self.port = found[0], int(found[1])

    @property
    def address(self):
        return f"http://127.0.0.1:{self.port}"

    def children(self):
        """The processes that it has started."""
        out = []
        for stat in Path("/proc").glob("[0-9]*/stat"):
            try:
                fields = stat.read_text().rpartition(")")[2].split()
            except OSError:
                continue
            if int(fields[1]) == self.process.pid and fields[0] != "Z":
                out.append(int(stat.parent.name))
        return out

    def end(self, number=signal.SIGINT):
        """Interrupt it; returns its exit status and what it wrote to stderr."""
        self.process.send_signal(number)
        _, errors = self.process.communicate(timeout=20)
        return self.process.returncode, errors

    def left_behind(self, children):
        """Its port, processes and files, as far as they are still there."""
        left = [pid for pid in children if Path(f"/proc/{pid}").exists()]
        left += [*self.home.iterdir(), *self.temporary.iterdir()]
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", self.port)) == 0:
                left.append(f"port {self.port}")
        return left
