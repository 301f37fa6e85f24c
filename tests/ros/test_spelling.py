"""Slips of the user's are told from names of other things."""

from __future__ import annotations

import pytest

from haul_ros.ros.spelling import edit_distance, is_slip, nearest

KNOWN = ("dt", "scenario", "publish_rate", "publish_clock", "record_path")


@pytest.mark.parametrize(
    ("one", "other", "distance"),
    [
        ("kitten", "sitting", 3),  # the example of the literature
        ("ca", "abc", 3),  # optimal string alignment; 2 with unrestricted swaps
        ("dt", "td", 1),
        ("", "dt", 2),
        ("dt", "dt", 0),
    ],
)
def test_the_distance_is_that_of_optimal_string_alignment(one: str, other: str, distance: int) -> None:
    assert edit_distance(one, other) == edit_distance(other, one) == distance


@pytest.mark.parametrize("name", ["scenaro", "sceanrio", "Scenario", "publishrate", "record_pth", "record-path", "DT"])
def test_a_slip_is_one(name: str) -> None:
    assert is_slip(name, KNOWN)


@pytest.mark.parametrize("name", ["publish_tf", "id", "t", "rate", "record", "publish_frequency", "x" * 100_000])
def test_another_name_is_none(name: str) -> None:
    assert not is_slip(name, KNOWN)


def test_the_nearest_is_the_one_most_like_it() -> None:
    assert nearest("publish_rates", KNOWN) == "publish_rate"
    assert nearest("zzz", KNOWN) is None
