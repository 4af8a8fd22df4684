"""A flight report in Chromium, opened as a file without a network."""

import numpy as np
import pytest

from pathsim_jsbsim_blocks.tracks import Track, save_tracks

pytest.importorskip("playwright")


@pytest.fixture
def page(browser, tmp_path):
    time = np.arange(0, 60, 1 / 20)
    tracks = [
        Track(
            name,
            "c172p",
            time,
            lat=47 + np.sin(time / 10) / 100,
            lon=11 + side + np.cos(time / 10) / 100,
            h=5000 + 10 * time,
            theta=5 + time / 20,
            phi=np.full_like(time, 30.0),
            psi=(350 + 2 * time) % 360,
            signals={"calibrated airspeed [kt]": 90 + time, "a <b>& [<i>]": time},
        )
        for name, side in (("lead", 0.0), ("wing", 0.01))
    ]
    save_tracks(tmp_path / "flight.html", tracks)
    page = browser.new_page(viewport={"width": 1300, "height": 800})
    page.complaints = []
    page.on("pageerror", lambda error: page.complaints.append(str(error)))
    page.on("console", lambda m: page.complaints.append(m.text) if m.type == "error" else None)
    page.on("requestfailed", lambda r: page.complaints.append(r.url))
    asked = []
    page.on("request", lambda r: asked.append(r.url))
    page.goto((tmp_path / "flight.html").as_uri())
    page.wait_for_selector("body[data-ready]")
    yield page
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
    assert page.complaints == []
    page.close()


def nose(page):
    """East, north and up of the drawn nose of the lead."""
    drawn = (
        "(() => { const g = document.getElementById('track').data.find(t => t.type === 'mesh3d');"
    )
    return page.evaluate(drawn + " return [g.x[0], g.y[0], g.z[0], g.x[1], g.y[1], g.z[1]]; })()")


@pytest.mark.long
def test_a_report_plays_and_links_its_views(page):
    assert page.title() == "lead, wing"
    # text, not HTML
    assert {"lead: a <b>&", "[<i>]"} <= set(page.locator("#plots text").all_text_contents())
    assert "pitch    5.0°  roll   30.0°  heading  350.0°" in page.inner_text("#attitude")
    page.evaluate(
        "t => { const s = document.getElementById('time'); s.value = t; s.oninput(); }", 20
    )
    assert "t = 20.00 s" in page.inner_text("#now")
    # 350 + 40 deg: it points 30 deg east of north, and up by 6 deg
    assert "pitch    6.0°  roll   30.0°  heading   30.0°" in page.inner_text("#attitude")
    x, y, z, *tail = nose(page)
    ahead = np.subtract([x, y, z], tail)
    assert np.degrees(np.arctan2(ahead[0], ahead[1])) == pytest.approx(30, abs=0.1)
    assert np.degrees(np.arcsin(ahead[2] / np.linalg.norm(ahead))) == pytest.approx(6, abs=0.1)
    page.click("#play")
    page.wait_for_function("parseFloat(document.getElementById('now').textContent.slice(4)) > 0.2")
    page.click("#play")
    page.wait_for_function("document.getElementById('play').textContent === 'Play'")
    held = page.inner_text("#now")
    page.wait_for_timeout(200)
    assert page.inner_text("#now") == held
    # a click into the time histories puts the cursor there: the middle of the axis is 30 s
    box = page.locator("#plots .nsewdrag").first.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.wait_for_function(
        "Math.abs(parseFloat(document.getElementById('now').textContent.slice(4)) - 30) < 0.3"
    )
    cursor = page.locator("#plots .shapelayer path").first.bounding_box()
    assert cursor["x"] == pytest.approx(box["x"] + box["width"] / 2, abs=4)
    # the other aircraft's attitude, by choice; then the flight plays to its end and stops
    page.select_option("#which", "1")
    page.select_option("#speed", "16")
    page.click("#play")
    page.wait_for_function("document.getElementById('now').textContent.includes('59.95')")
    assert page.inner_text("#play") == "Play"
    assert page.inner_text("#attitude").startswith("pitch    8.0°")
