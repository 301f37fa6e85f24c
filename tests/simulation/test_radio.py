"""Radio links: arrival times, order, seeded jitter and loss."""

from __future__ import annotations

import math
from itertools import groupby, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haul_ros.model.radio import RadioLink
from haul_ros.model.sample import FloatArray
from haul_ros.simulation.radio import LinkStatus, Radio


def _arrivals(radio: Radio, slave: str, n: int = 200, period: float = 0.1) -> list[float | None]:
    return [radio.send(slave, i * period) for i in range(n)]


def test_a_telegram_arrives_after_the_delay() -> None:
    assert Radio({"slave_1": RadioLink(delay=1.25)}, 0).send("slave_1", 2.0) == 3.25


@settings(deadline=None)
@given(
    delay=st.floats(0.0, 5.0),
    jitter=st.floats(0.0, 5.0),
    seed=st.integers(0, 2**32),
    gaps=st.lists(st.floats(0.0, 2.0), min_size=1, max_size=50),
)
def test_telegrams_arrive_in_order_and_within_delay_and_jitter_unless_one_before_is_later(
    delay: float, jitter: float, seed: int, gaps: list[float]
) -> None:
    radio = Radio({"slave_1": RadioLink(delay=delay, jitter=jitter)}, seed)
    last = 0.0
    for time in np.cumsum(gaps):
        arrival = radio.send("slave_1", float(time))
        assert arrival is not None
        assert arrival >= last
        assert time + delay <= arrival <= time + delay + jitter
        last = arrival


def test_jitter_spreads_over_its_range() -> None:
    radio = Radio({"slave_1": RadioLink(jitter=0.5)}, 3)
    late = [(radio.send("slave_1", float(i)) or 0.0) - i for i in range(2000)]
    assert np.mean(late) == pytest.approx(0.25, abs=0.02)
    assert min(late) < 0.01
    assert max(late) > 0.49


def test_the_seed_decides_everything() -> None:
    links = {"slave_1": RadioLink(0.1, 0.5, 0.3), "slave_2": RadioLink(0.1, 0.5, 0.3)}
    runs = [Radio(links, seed) for seed in (7, 7, 8)]
    first, again, other = ([_arrivals(radio, slave) for slave in links] for radio in runs)
    assert first == again
    assert first != other
    assert first[0] != first[1]


def test_traffic_on_one_link_leaves_the_luck_of_another_alone() -> None:
    links = {"slave_1": RadioLink(0.1, 0.5, 0.3), "slave_2": RadioLink(0.1, 0.5, 0.3)}
    quiet, busy = Radio(links, 7), Radio(links, 7)
    _arrivals(busy, "slave_1")
    assert _arrivals(quiet, "slave_2") == _arrivals(busy, "slave_2")


def test_a_change_of_the_link_leaves_later_luck_alone() -> None:
    plain, changed = (Radio({"slave_1": RadioLink(loss_probability=0.3)}, 7) for _ in range(2))
    changed.set_link("slave_1", RadioLink(connected=False))
    _arrivals(changed, "slave_1", 50)
    changed.set_link("slave_1", RadioLink(loss_probability=0.3))
    lost = [arrival is None for arrival in _arrivals(plain, "slave_1", 100)]
    assert [arrival is None for arrival in _arrivals(changed, "slave_1", 50)] == lost[50:]


@pytest.mark.parametrize(("probability", "expected"), [(0.0, 0), (0.25, 500), (1.0, 2000)])
def test_telegrams_are_lost_with_their_probability(probability: float, expected: int) -> None:
    radio = Radio({"slave_1": RadioLink(loss_probability=probability)}, 1)
    lost = _arrivals(radio, "slave_1", 2000).count(None)
    assert lost == pytest.approx(expected, abs=60 if 0 < expected < 2000 else 0)
    assert radio.status()["slave_1"].lost == lost


def test_the_next_telegram_goes_over_the_new_link_and_those_under_way_over_the_old() -> None:
    radio = Radio({"slave_1": RadioLink(delay=3.0)}, 0)
    assert radio.send("slave_1", 1.0) == 4.0
    radio.set_link("slave_1", RadioLink(delay=0.5))
    assert radio.send("slave_1", 1.1) == 4.0  # not before the one under way
    assert radio.send("slave_1", 4.0) == 4.5
    assert radio.link("slave_1") == RadioLink(delay=0.5)


def test_status_shows_a_link_that_is_down_and_a_telegram_lost() -> None:
    radio = Radio({"slave_1": RadioLink(delay=0.2), "slave_2": RadioLink(delay=0.3, connected=False)}, 0)
    radio.send("slave_1", 0.0)
    radio.send("slave_2", 0.0)
    assert radio.status() == {
        "slave_1": LinkStatus(connected=True, delay=0.2, sent=1, lost=0),
        "slave_2": LinkStatus(connected=False, delay=0.3, sent=1, lost=1),
    }
    radio.set_link("slave_2", RadioLink(delay=0.3))
    radio.send("slave_2", 1.0)
    assert radio.status()["slave_2"] == LinkStatus(connected=True, delay=0.3, sent=2, lost=1)


def _late(link: RadioLink, n: int = 4000, seed: int = 5) -> FloatArray:
    """How late telegrams are that are sent far apart [s]."""
    radio = Radio({"slave_1": link}, seed)
    return np.array([(radio.send("slave_1", 100.0 * i) or 0.0) - 100.0 * i for i in range(n)])


@pytest.mark.parametrize(
    ("link", "mean", "deviation"),
    [
        (RadioLink(0.5, 0.2), 0.6, 0.2 / math.sqrt(12)),
        (RadioLink(0.5, 0.2, jitter_law="exponential"), 0.7, 0.2),
        (RadioLink(0.5, 0.2, jitter_law="gamma", jitter_shape=4.0), 0.7, 0.2 / 2),
        (RadioLink(2.0, 0.2, jitter_law="normal"), 2.0, 0.2),
        # Half a normal law where nothing else is left of it
        (RadioLink(0.0, 0.2, jitter_law="normal"), 0.2 * math.sqrt(2 / math.pi), 0.2 * math.sqrt(1 - 2 / math.pi)),
        (RadioLink(0.5, 0.2, jitter_law="empirical", jitter_quantiles=(1.0, 2.0, 5.0)), 0.5 + 0.2 * 2.5, 0.2 * 1.190),
    ],
)
def test_every_law_of_jitter_has_its_mean_and_deviation(link: RadioLink, mean: float, deviation: float) -> None:
    late = _late(link)
    error = deviation / math.sqrt(len(late))
    assert np.mean(late) == pytest.approx(mean, abs=4 * error)
    assert np.std(late) == pytest.approx(deviation, rel=0.08)
    assert np.min(late) >= (0.0 if link.jitter_law == "normal" else link.delay)


def test_another_law_leaves_the_luck_alone() -> None:
    plain, other = (Radio({"slave_1": RadioLink(0.1, 0.5, 0.3, jitter_law=law)}, 7) for law in ("uniform", "gamma"))
    lost = [[arrival is None for arrival in _arrivals(radio, "slave_1")] for radio in (plain, other)]
    assert lost[0] == lost[1]


def test_telegrams_overtake_each_other_only_where_they_may() -> None:
    ordered, free = (
        _arrivals(Radio({"slave_1": RadioLink(0.1, 0.5, in_order=o)}, 7), "slave_1") for o in (True, False)
    )
    assert all(b >= a for a, b in pairwise(ordered) if a is not None and b is not None)
    assert any(b < a for a, b in pairwise(free) if a is not None and b is not None)


def test_bursts_take_their_share_of_time_and_last_as_long_as_they_should() -> None:
    length, spacing, period = 2.0, 6.0, 0.1
    link = RadioLink(loss_probability=0.0, burst_length=length, burst_spacing=spacing, burst_loss_probability=1.0)
    lost = [arrival is None for arrival in _arrivals(Radio({"slave_1": link}, 11), "slave_1", 40_000, period)]
    assert np.mean(lost) == pytest.approx(length / (length + spacing), rel=0.12)
    runs = [len(list(group)) for is_lost, group in groupby(lost) if is_lost]
    share = length / (length + spacing)
    stays = share + (1.0 - share) * math.exp(-period * (1.0 / length + 1.0 / spacing))
    assert np.mean(runs) == pytest.approx(1.0 / (1.0 - stays), rel=0.12)
    assert np.mean(runs) == pytest.approx(length / period, rel=0.2)


def test_a_telegram_arrives_twice_with_its_probability() -> None:
    radio = Radio({"slave_1": RadioLink(0.1, 0.2, duplicate_probability=0.25, in_order=False)}, 3)
    fates = [radio.first_attempt("slave_1", float(i)) for i in range(2000)]
    copies = [(fate.arrival, fate.duplicate) for fate in fates if fate.duplicate is not None]
    assert len(copies) == pytest.approx(500, abs=80)
    assert all(first != second for first, second in copies)


@pytest.mark.parametrize(("fails", "arrives", "answered"), [("to_slave", False, True), ("from_slave", True, False)])
def test_one_direction_may_be_dead(fails: str, arrives: bool, answered: bool) -> None:
    radio = Radio({"slave_1": RadioLink(0.5, fails=fails)}, 0)
    assert (radio.send("slave_1", 1.0) is not None) is arrives
    assert (radio.acknowledge("slave_1", 0, 0, 0, 2.0) is not None) is answered
    assert not radio.status()["slave_1"].connected


def test_an_unknown_slave_is_refused() -> None:
    with pytest.raises(KeyError, match="slave_7"):
        Radio({"slave_1": RadioLink()}, 0).set_link("slave_7", RadioLink())
