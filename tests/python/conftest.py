"""Shared mechanisms."""

import pytest

import assur


def four_bar(law=(0, 6.283185307179586)):
    """A crank-rocker with a point of its coupler."""
    return (
        assur.SceneBuilder("four_bar", 2)
        .point("A", (0, 0), fixed=True)
        .point("D", (3, 0), fixed=True)
        .point("B", (1, 0))
        .point("C", (2.5, 2.4))
        .distance("crank", "A", "B", 1)
        .distance("coupler", "B", "C", 3)
        .distance("rocker", "D", "C", 2.5)
        .drive_angle("motor", "A", "B", law)
        .measure_angle("rocker_angle", "D", "C")
        .output("C", "rocker_angle")
        .time(0, 1, 0.005)
        .build()
    )


@pytest.fixture
def mechanism():
    return four_bar()
