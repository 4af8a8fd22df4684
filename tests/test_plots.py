"""Figures: the right curves in the right panels, and what `show` does without a display."""

import io

import matplotlib.pyplot as plt
import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source

from pathsim_jsbsim_blocks import Aircraft, ParameterError
from pathsim_jsbsim_blocks.plots import (
    ground_track,
    phase_portrait,
    saving_to,
    show,
    signal,
    subplots,
    time_histories,
)


@pytest.fixture
def scope():
    scope = Scope(labels=["height [ft]", "pitch [deg]", "heading [deg]", "plain"])
    signals = (lambda t: 100 + t, lambda t: 2 * t, lambda t: (350 + 10 * t) % 360, lambda t: -t)
    sources = [Source(signal) for signal in signals]
    wires = [Connection(source, scope[i]) for i, source in enumerate(sources)]
    Simulation([*sources, scope], wires, dt=0.1, log=False).run(3.0)
    return scope


def test_one_panel_for_each_unit(scope):
    figure = time_histories(scope, title="a flight")
    height, angles, plain = figure.axes
    assert height.get_ylabel() == "height\n[ft]"
    assert angles.get_ylabel() == "angle\n[deg]"
    assert [t.get_text() for t in angles.get_legend().get_texts()] == ["pitch", "heading"]
    assert plain.get_ylabel() == "plain"
    assert plain.get_xlabel() == "time [s]"
    assert figure.get_suptitle() == "a flight"
    assert height.get_lines()[0].get_ydata()[-1] == pytest.approx(103.0)
    # a heading goes on through north, without a line across the panel
    assert angles.get_lines()[1].get_ydata() == pytest.approx(np.arange(350.0, 381.0))


@pytest.mark.parametrize(
    ("labels", "expected"),
    [
        (["sideslip angle, bare [deg]", "sideslip angle, damped [deg]"], "sideslip angle\n[deg]"),
        (["elevator command [-]", "aileron command [-]"], "command\n[-]"),
        (["rate of climb [ft/s]", "demanded [ft/s]"], "velocity\n[ft/s]"),
        (["difference in angle of attack [deg]"], "difference in angle\nof attack\n[deg]"),
        (["power [%]", "load [%]"], "[%]"),
    ],
)
def test_an_axis_names_what_its_curves_share(labels, expected):
    scope = Scope(labels=labels)
    source = Source(lambda t: t)
    wires = [Connection(source, *(scope[i] for i in range(len(labels))))]
    Simulation([source, scope], wires, dt=0.5, log=False).run(1.0)
    (ax,) = time_histories(scope).axes
    assert ax.get_ylabel() == expected


def test_the_labels_of_panels_are_aligned(scope):
    figure = time_histories(scope)
    figure.canvas.draw()
    edges = {round(ax.yaxis.label.get_window_extent().x1) for ax in figure.axes}
    assert len(edges) == 1


def test_references_are_drawn_in_the_panel_of_their_signal(scope):
    figure = time_histories(scope, references={"height": 101.0, "pitch [deg]": lambda t: 2 * t + 1})
    height, angles, plain = figure.axes
    assert height.get_lines()[1].get_ydata() == pytest.approx(np.full(31, 101.0))
    assert height.get_ylabel() == "height\n[ft]"
    assert [t.get_text() for t in height.get_legend().get_texts()] == ["reference"]
    _, pitch = signal(scope, "pitch")
    assert angles.get_lines()[2].get_ydata() == pytest.approx(pitch + 1)
    assert angles.get_legend().get_texts()[2].get_text() == "pitch: reference"
    assert len(plain.get_lines()) == 1


@pytest.mark.parametrize(
    ("call", "parameter"),
    [
        (lambda scope: signal(scope, "pich"), "label"),
        (lambda scope: signal(Aircraft("c172p", 5000, 90), "h"), "scope"),
        (lambda scope: time_histories(), "scopes"),
        (lambda scope: time_histories(Scope()), "scope"),  # not run
        (lambda scope: time_histories([1.0]), "scope"),
        (lambda scope: time_histories(scope, references={"hight": 1.0}), "label"),
        *(
            (lambda scope, bad=bad: time_histories(scope, references=bad), "references")
            for bad in (3, {"height": "a"}, {"height": [1.0, 2.0]}, {"height": lambda t: t[:3]})
        ),
    ],
)
def test_what_cannot_be_drawn_is_refused(call, parameter, scope):
    with pytest.raises(ParameterError) as error:
        call(scope)
    assert error.value.parameter == parameter
    assert parameter != "label" or "did you mean" in str(error.value)


def test_ground_track_is_in_longitude_and_latitude_with_its_ends_marked():
    time = np.linspace(0, 10, 11)
    figure = ground_track(time, 60.0 + time / 60, 10.0 + time / 60)
    track = figure.axes[0].collections[0]
    end = track.get_segments()[-1][-1]
    assert end == pytest.approx([10.0 + 1 / 6, 60.0 + 1 / 6])
    marks = {line.get_label(): line.get_xydata()[0] for line in figure.axes[0].get_lines()}
    assert marks["start"] == pytest.approx([10.0, 60.0])
    assert marks["end"] == pytest.approx(end)
    # at 60 deg north a degree of longitude is half as long as one of latitude
    assert figure.axes[0].get_aspect() == pytest.approx(2.0)
    assert np.array_equal(track.get_array(), time[:-1])


@pytest.mark.parametrize(("north", "east"), [(0.0, 0.02), (0.02, 0.0)])
def test_a_ground_track_fills_its_picture(north, east):
    share = np.linspace(0.0, 1.0, 5)
    figure = ground_track(share, north * share, east * share)
    figure.canvas.draw()
    box, size = figure.axes[0].get_window_extent(), figure.bbox
    # what is left is for labels and the colour bar
    assert size.height - box.height < 2.4 * figure.dpi
    assert box.height > 1.5 * figure.dpi


def test_phase_portrait_shows_one_over_the_other():
    (ax,) = phase_portrait(np.array([1.0, 2.0]), np.array([3.0, 4.0]), ("x", "y")).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x", "y")
    assert ax.get_lines()[0].get_xydata().tolist() == [[1.0, 3.0], [2.0, 4.0]]


@pytest.mark.parametrize("n", [200, 5000])  # of more than 1000 points paths are made when drawn
def test_curves_keep_their_points(n):
    assert plt.rcParams["path.simplify_threshold"] == 1.0  # PathSim's
    x = np.linspace(0.0, 1.0, n)

    def picture(figure):
        file = io.BytesIO()
        figure.savefig(file, format="raw", dpi=100)
        return file.getvalue()

    def drawn(make):
        figure, ax = make()
        ax.plot(x, np.sin(20 * x))
        return picture(figure)

    ours, rough = drawn(subplots), drawn(plt.subplots)
    with plt.rc_context({"path.simplify_threshold": 1 / 9}):  # matplotlib's own
        exact = drawn(plt.subplots)
    assert ours == exact != rough
    assert plt.rcParams["path.simplify_threshold"] == 1.0


def test_show_writes_a_file_where_there_is_no_display(scope, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    plt.switch_backend("agg")
    show(time_histories(scope), "flight")
    assert (tmp_path / "flight.png").read_bytes().startswith(b"\x89PNG")
    assert capsys.readouterr().out == "figure saved: flight.png\n"
    with saving_to(tmp_path / "b.png"):
        show(time_histories(scope), "flight")
    assert (tmp_path / "b.png").exists()


def test_a_headline_wider_than_its_figure_is_broken():
    figure, _ = subplots(figsize=(4, 3), layout="constrained")
    title = figure.suptitle("distance from the median of all simulators, " * 3)
    figure.canvas.draw()
    extent = title.get_window_extent()
    assert extent.x0 >= 0.0
    assert extent.x1 <= figure.bbox.width
