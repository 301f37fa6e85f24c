"""Maps of a quantity: what they show, how they judge a trend, and the published trends on small grids."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from haul_ros.errors import HaulError
from haul_ros.model.sample import CouplerExtremes
from haul_ros.studies.case import Case, CaseResult, Finished, simulate
from haul_ros.studies.definition import load_study
from haul_ros.studies.kinds.map import QUANTITIES, axis_label, judge, map_figure, values
from haul_ros.studies.sweep import Axis, Sweep, Trend, list_axis, variants_axis

BRAKE, DELAY = "driver.electric_brake_kN", "radio.default.delay_s"


def result(force: float, released: int = 0) -> CaseResult:
    none, forces = np.zeros(3), np.array([0.0, force, force / 2.0])
    extremes = CouplerExtremes(forces, none, none, none, forces / 3e7, none, np.full(3, np.nan))
    return CaseResult(extremes, np.full(3, True), np.array([0]), np.nan, 900.0, 0.0, 0, "", 20.0, released)


def study(*trends: Trend) -> Sweep:
    axes = (
        list_axis(BRAKE, [200, 300, 400]),
        list_axis(DELAY, [0, 2]),
        variants_axis("train", {"short": {"consist.1.count": 4}, "long": {}}),
    )
    return Sweep("trial", "a trial", ("cyclic_descent",), axes=axes, kind="map", trends=trends)


def results(of: Sweep, force: Callable[[Case], float], released: int = 0) -> list[Finished[CaseResult]]:
    return [Finished(case, result(force(case), released)) for case in of.cases()]


def number(case: Case, key: str) -> float:
    value = case.overrides[key]
    assert isinstance(value, int | float)
    return float(value)


def test_each_value_stands_at_its_points() -> None:
    trial = study()
    found = values(trial, results(trial, lambda case: number(case, BRAKE) * 1e3 + number(case, DELAY)), "force")
    assert found.shape == (3, 2, 2)
    assert found[2, 1] == pytest.approx([400.002, 400.002])
    for name, expected in (("top_speed", 72.0), ("distance", 900.0), ("released", 0.0)):
        assert QUANTITIES[name].of(result(1e5)) == pytest.approx(expected)


def test_a_trend_holds_if_something_goes_with_it_and_nothing_against_it() -> None:
    trial = study(Trend(BRAKE, "force", True, "source"), Trend(DELAY, "force", False, "source"))
    rising, level, _ = judge(trial, results(trial, lambda case: number(case, BRAKE) * 1e3))
    assert rising.holds is True
    assert rising.found == "with it in 8, against it in 0 of 8 steps"
    assert rising.text == "largest coupler force [kN] rises with electric brake [kN] (source)"
    assert level.holds is None, "nothing changes"
    once: dict[tuple[object, ...], float] = {(300, 2, "long"): 1e5}
    turned = results(
        trial, lambda case: once.get(tuple(case.values[axis.name] for axis in trial.axes), number(case, BRAKE) * 1e3)
    )
    assert judge(trial, turned)[0].holds is False
    assert judge(trial, turned)[0].found == "with it in 7, against it in 1 of 8 steps"


def test_the_picture_names_axes_in_words_with_units_and_frames_what_released() -> None:
    trial = study()
    figure = map_figure(trial, results(trial, lambda case: number(case, BRAKE) * 1e3, released=7))
    panels, bar = figure.axes[:2], figure.axes[2]
    assert [panel.get_title() for panel in panels] == ["train short", "train long"]
    (below,) = (text.get_text() for text in figure.texts if text.get_text().startswith("electric brake [kN]\n"))
    assert panels[0].get_ylabel() == "delay [s]"
    assert [label.get_text() for label in panels[0].get_xticklabels()] == ["200", "300", "400"]
    assert bar.get_ylabel() == "largest coupler force [kN]"
    assert [text.get_text() for text in panels[1].texts].count("7") == 6
    assert "unasked" in below
    assert axis_label(trial.axes[2]) == "train"
    assert axis_label(list_axis("initial_speed_kmh", [40, 60])) == "initial speed [km/h]"


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"axes": study().axes[:1]}, "two or three things"),
        ({"scenarios": ("cyclic_descent", "daqin_1_1_0")}, "one scenario"),
        ({"trends": (Trend("speed", "force", True, "x"),)}, "trends: along speed, expected one of driver.electric"),
    ],
)
def test_what_cannot_be_a_map_is_refused(change: Mapping[str, object], problem: str) -> None:
    from haul_ros.studies.kinds.table import KINDS

    with pytest.raises(HaulError, match=problem):
        KINDS["map"].check(replace(study(), **change))  # type: ignore[arg-type]


def test_a_trend_in_a_file_is_read(tmp_path: Path) -> None:
    text = (
        "kind: map\nscenario: cyclic_descent\nover:\n  driver.electric_brake_kN: [200, 400]\n"
        "  radio.default.delay_s: [0, 2]\n"
        "trends: [{along: radio.default.delay_s, quantity: force, sense: falls, source: nobody}]\n"
    )
    (tmp_path / "own.yaml").write_text(text, "utf-8")
    assert load_study(str(tmp_path / "own.yaml")).trends == (Trend(DELAY, "force", False, "nobody"),)


def thinned(name: str, **kept: tuple[int, ...]) -> list[CaseResult]:
    """Results of a shipped study, of axes whose names end so with these points alone, of others with the first."""
    whole = load_study(name)

    def axis(old: Axis) -> Axis:
        numbers = next((points for end, points in kept.items() if old.name.endswith(end)), (0,))
        return Axis(old.name, tuple(old.points[number] for number in numbers))

    return [simulate(case.load()) for case in replace(whole, axes=tuple(map(axis, whole.axes))).cases()]


@pytest.mark.slow
def test_a_longer_train_releases_when_applied_too_soon_and_a_later_or_deeper_application_does_not() -> None:
    """Tests on a rack of 200 valves: longer trains likelier, a deeper or a later second application avoids it."""
    short, long = thinned("unintended-release", of=(0, 2), application=(1,))
    assert long.unbraked > short.unbraked
    # Of 60 kPa; 50 after four minutes are released again by the brake valve, which quick service has overtaken
    soon, later = thinned("unintended-release", of=(2,), application=(1, 3), reduction=(1,))
    assert later.unbraked < soon.unbraked
    fifty, eighty = thinned("unintended-release", of=(2,), application=(1,), reduction=(0, 2))
    assert eighty.unbraked < fifty.unbraked


@pytest.mark.slow
def test_more_electric_brake_is_worse_and_a_higher_speed_at_release_better_while_reservoirs_recover() -> None:
    """Railway Sciences 4(2); where they do not, a shorter cycle releases unasked and is worse."""
    found = thinned("release-speed", release_below_kmh=(0, 1), electric_brake_kN=(1, 2))
    (slow_weak, slow_strong, fast_weak, fast_strong) = found
    assert all(case.released == 0 for case in found)
    assert slow_strong.gear_force > slow_weak.gear_force
    assert fast_strong.gear_force > fast_weak.gear_force
    assert fast_weak.gear_force < slow_weak.gear_force
    assert fast_strong.gear_force < slow_strong.gear_force


@pytest.mark.slow
def test_a_slave_that_does_not_hear_of_the_release_is_worse_than_one_that_hears_of_nothing() -> None:
    """It holds its part of the train braked while the head pulls away."""
    never, releasing, both = thinned("radio-outage", out=(0, 2, 3), reduction=(0,))
    assert never.gear_force < both.gear_force < releasing.gear_force


@pytest.mark.slow
def test_a_hose_that_parts_stops_the_train_wherever_it_is() -> None:
    for found in thinned("burst-hose", vehicle=(0, 4, 8), initial_speed_kmh=(2,)):
        assert np.isfinite(found.stop_time)
        assert found.energy_fault == ""
