"""PathView in a real Chromium."""

import os
import shutil
import threading

import pytest

from .editor import Editor


def _cannot(reason):
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)


@pytest.fixture(scope="session")
def browser():
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _cannot("playwright is not installed")
    names = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
    program = next(filter(None, map(shutil.which, names)), None)
    if program is None:
        _cannot(f"no browser: none of {', '.join(names)}")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=program,
            args=[
                "--no-sandbox",
                "--disable-gpu",
                "--disable-quic",
                "--no-first-run",
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
            ],
        )
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def models():
    """What the server offers to open, by file name: tests add to it before they open."""
    return {}


@pytest.fixture(scope="session")
def server(models):
    """PathView as ``pathsim-jsbsim view`` serves it."""
    from pathsim_jsbsim_blocks.pathview.server import Server

    with Server(models, port=0) as server:
        threading.Thread(target=server.run, daemon=True).start()
        yield server


@pytest.fixture(scope="session")
def profile(browser, server):
    """A browser profile that has opened the editor: PathView's worker process runs."""
    with Editor(browser, server.address, server.url) as first:
        first.open_empty()
        yield first.context


@pytest.fixture
def editor(profile, browser, server):
    """The editor in a page of its own: the cookie is there, and the worker process runs."""
    before = set(profile.pages)
    editor = Editor(browser, server.address, server.url, profile)
    yield editor
    for page in set(profile.pages) - before:
        page.close()


@pytest.fixture
def fresh_editor(browser, server):
    """The editor in a fresh browser profile."""
    with Editor(browser, server.address, server.url) as editor:
        yield editor
