"""The figures of the paper from the shipped scenarios, as `haul run` has them.

Gao et al., J. Cent. South Univ. 24(10) 2017, 2449-2457. Numbers of the paper's text are allowed 3 %, those that an
independent implementation gave for the same fitted parameter set 1.5 %. Forces in kN, strokes in mm.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from haul_ros.scenario.loader import load_scenario
from haul_ros.simulation.session import Session

PAPER = 0.03
REFERENCE = 0.015

Overrides = dict[str, object]


@dataclass(frozen=True)
class Stop:
    """Envelopes along the train of one emergency stop, and how it ended."""

    compression: NDArray[np.float64]
    tension: NDArray[np.float64]
    stroke: float
    time: float

    @property
    def envelope(self) -> NDArray[np.float64]:
        """Largest magnitude of the force at each coupler [kN]."""
        return np.maximum(self.compression, self.tension)

    @property
    def peak(self) -> float:
        return float(self.envelope.max())


def stop(name: str, overrides: Overrides | None = None) -> Stop:
    """Run a shipped scenario to standstill; runs are kept, for several tests look at the same one."""
    return _run(name, json.dumps(overrides or {}))


@cache
def _run(name: str, overrides: str) -> Stop:
    session = Session(load_scenario(name, json.loads(overrides)), play_commands=True)
    while not session.finished:
        session.advance()
    solver = session.status().solver
    assert solver.fallback_steps == solver.unconverged_steps == 0
    assert abs(session.energy().relative_imbalance) < 1e-6
    assert session.stop_time is not None
    extremes = session.extremes()
    stroke = max(extremes.compression_stroke.max(), extremes.tension_stroke.max())
    return Stop(extremes.compression / 1e3, extremes.tension / 1e3, float(stroke) * 1e3, session.stop_time)


def _from_speed(kmh: float) -> float:
    return stop("daqin_1_2_1", {"initial_speed_kmh": kmh} if kmh != 80 else {}).peak


# -- section 4.1, 1+2+1 from different speeds ------------------------------------------------------------------------


def test_the_train_1_2_1_from_80_kmh_has_about_700_kn_under_25_mm() -> None:
    run = stop("daqin_1_2_1")
    assert run.peak == pytest.approx(700, rel=PAPER)
    assert run.stroke < 25.0
    assert run.peak == pytest.approx(701.7, rel=REFERENCE)
    assert run.stroke == pytest.approx(24.26, rel=REFERENCE)
    assert run.time == pytest.approx(44.7, rel=REFERENCE)


@pytest.mark.parametrize(("kmh", "paper"), [(40, 780), (80, 700), (100, 670)])
def test_the_peak_is_that_of_the_paper_s_text_at_each_initial_speed(kmh: float, paper: float) -> None:
    assert _from_speed(kmh) == pytest.approx(paper, rel=PAPER)


@pytest.mark.parametrize(("kmh", "reference"), [(40, 780.4), (60, 734.7), (80, 701.7), (100, 677.1)])
def test_the_peak_is_that_of_an_independent_implementation_at_each_initial_speed(kmh: float, reference: float) -> None:
    assert _from_speed(kmh) == pytest.approx(reference, rel=REFERENCE)


def test_the_peak_falls_with_the_initial_speed() -> None:
    peaks = [_from_speed(kmh) for kmh in (40, 60, 80, 100)]
    assert peaks == sorted(peaks, reverse=True)
    assert min(-np.diff(peaks)) > 10.0


# -- section 4.1, along the train ------------------------------------------------------------------------------------


def _quarters(envelope: NDArray[np.float64]) -> list[float]:
    return [float(quarter.max()) for quarter in np.array_split(envelope, 4)]


def test_compression_and_tension_peak_in_every_quarter_each_the_mirror_of_the_other() -> None:
    run = stop("daqin_1_2_1")
    assert _quarters(run.compression) == pytest.approx([701, 601, 701, 601], rel=REFERENCE)
    assert _quarters(run.tension) == pytest.approx([601, 701, 601, 701], rel=REFERENCE)


def test_the_envelope_of_the_magnitude_has_four_equal_peaks_and_its_minimum_between_locomotives() -> None:
    # "Four nearly equal peaks" of the paper is met by |F|, not by compression or tension alone.
    envelope = stop("daqin_1_2_1").envelope
    assert _quarters(envelope) == pytest.approx([700] * 4, rel=PAPER)
    assert np.ptp(_quarters(envelope)) < 0.01 * envelope.max()
    # Couplers 0..206: locomotives at vehicles 0, 103, 104 and 207; mid-way between them are couplers 51 and 155.
    for first, last in ((20, 83), (124, 187)):
        inside = envelope[first : last + 1]
        lowest = first + int(inside.argmin())
        assert abs(lowest - (51 if first == 20 else 155)) <= 4
        assert inside.min() < 0.8 * envelope.max()


# -- section 4.2, slaves late ----------------------------------------------------------------------------------------

DELAYS = {0.0: 702, 0.5: 789, 1.0: 967, 2.0: 1321, 3.0: 1712, 5.0: 2523}


def _delayed(delay: float) -> float:
    return stop("daqin_1_2_1", {"radio.default.delay_s": delay} if delay else {}).peak


@pytest.mark.parametrize(("delay", "reference"), DELAYS.items())
def test_the_peak_of_late_slaves_is_that_of_an_independent_implementation(delay: float, reference: float) -> None:
    assert _delayed(delay) == pytest.approx(reference, rel=REFERENCE)


def test_the_peak_is_lowest_when_all_brake_at_once_and_rises_with_the_delay() -> None:
    peaks = [_delayed(delay) for delay in DELAYS]
    assert peaks == sorted(peaks)
    # A 30 000 t train is published at +336 % for 5 s (Wei 2011); this one is in the same region.
    assert 2.5 < peaks[-1] / peaks[0] < 5.0


# -- section 4.3, stiffness at constant capability -------------------------------------------------------------------


def _stiffness(k1: float) -> Stop:
    gear = "couplers.paper_set_b"
    overrides: Overrides = {
        f"{gear}.loading_stiffness_kN_per_mm": k1,
        f"{gear}.unloading_stiffness_kN_per_mm": 0.9 * k1,
    }
    # Capability Q limits how far a gear may go, sqrt(2 Q/K1), and none of these goes there.
    return stop("daqin_1_2_1", overrides if k1 != 30 else {})


@pytest.mark.parametrize(
    ("k1", "force", "stroke"), [(20, 657, 33.7), (25, 684, 28.3), (30, 702, 24.3), (40, 713, 18.6)]
)
def test_force_and_stroke_of_each_stiffness_are_those_of_an_independent_implementation(
    k1: float, force: float, stroke: float
) -> None:
    run = _stiffness(k1)
    assert run.peak == pytest.approx(force, rel=REFERENCE)
    assert run.stroke == pytest.approx(stroke, rel=REFERENCE)


def test_stiffer_gears_bear_more_force_over_less_stroke() -> None:
    runs = [_stiffness(k1) for k1 in (20, 25, 30, 40)]
    assert [run.peak for run in runs] == sorted(run.peak for run in runs)
    assert [run.stroke for run in runs] == sorted((run.stroke for run in runs), reverse=True)
    # 100 kJ, the class of the paper's capability Q, takes all of them.
    for k1, run in zip((20, 25, 30, 40), runs, strict=True):
        assert 0.5 * k1 * run.stroke**2 < 100e3


# -- section 4.4, rigid arms -----------------------------------------------------------------------------------------


def test_rigid_pairs_lower_force_and_stroke_a_little_with_set_b() -> None:
    # "Much smaller" in the paper; computed: 4 %.
    single, pairs = stop("daqin_1_2_1"), stop("daqin_1_2_1_rigid_pairs")
    draft_gears = pairs.envelope[
        [gear is not None for gear in load_scenario("daqin_1_2_1_rigid_pairs").consist.couplers]
    ]
    assert float(draft_gears.max()) == pytest.approx(678, rel=REFERENCE)
    assert pairs.stroke == pytest.approx(23.5, rel=REFERENCE)
    assert draft_gears.max() < single.peak
    assert pairs.stroke < single.stroke


def test_rigid_pairs_raise_the_force_with_set_a() -> None:
    pairs: Overrides = {"consist.1.drawbar_group": 2, "consist.3.drawbar_group": 2}
    single, paired = stop("daqin_1_2_1_set_a"), stop("daqin_1_2_1_set_a", pairs)
    assert paired.peak > 1.1 * single.peak
    assert paired.peak == pytest.approx(814, rel=REFERENCE)


@pytest.mark.parametrize(("kmh", "force"), [(40, 796), (80, 700), (100, 669)])
def test_set_a_gives_the_paper_s_speeds_too(kmh: float, force: float) -> None:
    overrides: Overrides = {"initial_speed_kmh": kmh} if kmh != 80 else {}
    assert stop("daqin_1_2_1_set_a", overrides).peak == pytest.approx(force, rel=REFERENCE)


# -- section 3, validation -------------------------------------------------------------------------------------------


def test_the_validation_train_has_1050_kn_at_two_thirds_and_least_at_both_ends() -> None:
    envelope = stop("validation_ss3_c63").envelope
    assert envelope.max() == pytest.approx(1050, rel=PAPER)
    assert envelope.max() == pytest.approx(1052, rel=REFERENCE)
    assert (int(envelope.argmax()) + 1) / len(envelope) == pytest.approx(0.66, abs=0.03)
    middle = envelope[5:-5]
    assert max(envelope[0], envelope[-1]) < middle.min()
    assert {int(i) for i in np.argsort(envelope)[:2]} == {0, len(envelope) - 1}


# -- beyond the paper ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("coupler", "low", "high"), [("paper_set_b", 340, 355), ("paper_set_a", 250, 290)])
def test_a_realistic_build_up_gives_far_smaller_forces(coupler: str, low: float, high: float) -> None:
    # Ranges of a reference calculation written apart (its own build-ups of 8 to 18 s; a pneumatic brake gave 344, 276).
    overrides: Overrides = {"coupler": coupler} if coupler != "paper_set_b" else {}
    assert low < stop("daqin_1_2_1_realistic", overrides).peak < high


@pytest.mark.parametrize("name", ["daqin_1_2_1", "validation_ss3_c63"])
def test_the_peak_at_1_ms_is_within_a_thousandth_of_that_at_a_quarter_of_it(name: str) -> None:
    fine = stop(name, {"time_step_ms": 0.25})
    coarse = stop(name)
    assert coarse.peak == pytest.approx(fine.peak, rel=1e-3)
    assert coarse.stroke == pytest.approx(fine.stroke, rel=1e-3)
    np.testing.assert_allclose(coarse.compression, fine.compression, rtol=0.0, atol=2e-3 * fine.peak)


def test_peaks_hold_up_to_steps_of_5_ms() -> None:
    assert stop("daqin_1_2_1", {"time_step_ms": 5}).peak == pytest.approx(stop("daqin_1_2_1").peak, rel=5e-3)
