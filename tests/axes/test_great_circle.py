"""Great circles against geodesics (pymap3d's Vincenty) and closed forms of the sphere and ellipse."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pymap3d.vincenty import vreckon

from pathsim_jsbsim_blocks import BlocksError
from pathsim_jsbsim_blocks.axes import geodetic_to_ecef, ned_to_geodetic
from pathsim_jsbsim_blocks.axes.earth import _ellipsoid
from pathsim_jsbsim_blocks.axes.navigation import distance, great_circle, motion, place

NMI = 1852.0 / 0.3048  # ft
A, B = 20925646.32546, 20855486.5951  # ft: WGS84, as JSBSim rounds it


def geodesic(lat, lon, course, length):
    """The point at the end of a geodesic."""
    there = [float(x) for x in vreckon(lat, lon, length, course, _ellipsoid())]
    return there[0], (there[1] + 180.0) % 360.0 - 180.0


@pytest.mark.parametrize(
    ("nmi", "beside", "course_error"),
    [(1.0, 0.01, 1e-3), (20.0, 1.0, 1e-3), (100.0, 12.0, 5e-3), (500.0, 300.0, 0.03)],
)
def test_geodesics(nmi, beside, course_error):
    rng = np.random.default_rng(5)
    for _ in range(40):
        start = rng.uniform(-70.0, 70.0), rng.uniform(-180.0, 180.0)
        course, length = rng.uniform(0.0, 360.0), nmi * NMI
        leg = great_circle(start, geodesic(*start, course, length))
        assert leg.length == pytest.approx(length, rel=3e-5)
        found = leg.track(start)
        assert found.across == pytest.approx(0.0, abs=1e-5)
        assert found.to_go == pytest.approx(length, rel=3e-4)
        assert math.remainder(found.course - course, 360.0) == pytest.approx(0.0, abs=course_error)
        middle = leg.track(geodesic(*start, course, length / 2))
        assert abs(middle.across) < beside
        beyond = leg.track(geodesic(*start, course, 1.01 * length))
        assert beyond.to_go == pytest.approx(-0.01 * length, rel=2e-3)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_cross_track_error_to_the_side(side):
    # a point on the geodesic at right angles, right of a leg to the north east
    start = (47.0, 11.0)
    leg = great_circle(start, geodesic(*start, 40.0, 30 * NMI))
    on = geodesic(*start, 40.0, 10 * NMI)
    course = leg.track(on).course
    found = leg.track(geodesic(*on, course + side * 90.0, 3000.0))
    assert found.across == pytest.approx(side * 3000.0, abs=0.5)
    assert found.to_go == pytest.approx(20 * NMI, abs=40.0)


def test_meridian_and_equator():
    north = great_circle((0.0, 0.0), (10.0, 0.0)).track((5.0, 0.0))
    assert (north.across, north.course) == pytest.approx((0.0, 0.0), abs=1e-9)
    east = great_circle((0.0, 10.0), (0.0, 11.0))
    assert east.length == pytest.approx(math.radians(1.0) * A, rel=1e-9)
    found = east.track((0.01, 10.5))
    assert found.course == pytest.approx(90.0, abs=1e-9)
    # radius of curvature of the meridian at the equator, b^2/a; measured from the Earth's centre,
    # as the circle's plane is
    assert found.across == pytest.approx(-math.radians(0.01) * B * B / A, rel=1e-6)
    assert east.track((0.0, 11.5)).to_go == pytest.approx(-math.radians(0.5) * A, rel=1e-9)
    west = great_circle((0.0, 11.0), (0.0, 10.0)).track((0.01, 10.5))
    assert (west.course, west.across) == pytest.approx((270.0, -found.across))


def test_across_the_date_line_and_over_the_pole():
    leg = great_circle((10.0, 179.5), (10.0, -179.5))
    assert leg.length == pytest.approx(great_circle((10.0, 0.0), (10.0, 1.0)).length, rel=1e-12)
    over = great_circle((89.0, 0.0), (89.0, 180.0)).track((89.9, 0.0))
    assert over.course == pytest.approx(0.0, abs=1e-9)
    assert great_circle((89.0, 0.0), (89.0, 180.0)).track((89.9, 180.0)).course == 180.0


def test_the_surface_is_that_of_the_other_functions():
    rng = np.random.default_rng(2)
    for lat, lon in rng.uniform((-90.0, -180.0), (90.0, 180.0), (50, 2)):
        here = place(lat, lon)
        assert here.position == pytest.approx(geodetic_to_ecef(lat, lon, 0.0), abs=1e-6)
        moved = place(*(float(x) for x in ned_to_geodetic(3.0, -2.0, 0.0, lat, lon, 0.0)[:2]))
        assert motion(here, moved) == pytest.approx((3.0, -2.0), abs=1e-5)
        assert distance(here, moved) == pytest.approx(math.hypot(3.0, 2.0), abs=1e-5)


@pytest.mark.parametrize(
    ("start", "end", "parameter"),
    [
        ((1.0, 2.0), (1.0, 2.0), "end"),
        ((0.0, 0.0), (0.0, 180.0), "end"),
        ((91.0, 0.0), (0.0, 0.0), "start: latitude"),
        ((0.0, 0.0), (math.nan, 0.0), "end: latitude"),
        ((0.0, 0.0), (0.0, 400.0), "end: longitude"),
        (0.0, (0.0, 0.0), "start"),
        ((0.0, 0.0), (0.0, 0.0, 0.0), "end"),
    ],
)
def test_bad_points_are_refused(start, end, parameter):
    with pytest.raises(BlocksError) as caught:
        great_circle(start, end)
    assert caught.value.parameter == parameter
