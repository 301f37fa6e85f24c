"""Changes of radio links: what is given changes, the rest stays."""

from __future__ import annotations

import math
from typing import Any

import pytest

from haul_ros.model.radio import CHANGEABLE, RadioLink, RadioLinkChange

LINK = RadioLink(delay=0.5, jitter=0.25, loss_probability=0.125, connected=False)


def test_a_change_leaves_the_fields_alone_that_it_does_not_give() -> None:
    assert RadioLinkChange("slave_1").applied_to(LINK) == LINK
    assert RadioLinkChange("slave_1", delay=0.0).applied_to(LINK) == RadioLink(0.0, 0.25, 0.125, False)
    assert RadioLinkChange("slave_1", jitter=0.0).applied_to(LINK) == RadioLink(0.5, 0.0, 0.125, False)
    assert RadioLinkChange("slave_1", loss_probability=0.0).applied_to(LINK) == RadioLink(0.5, 0.25, 0.0, False)
    assert RadioLinkChange("slave_1", connected=True).applied_to(LINK) == RadioLink(0.5, 0.25, 0.125, True)


def test_a_change_to_a_link_leads_there_from_any_other() -> None:
    change = RadioLinkChange.to("slave_1", LINK)
    given = {"delay": 0.5, "jitter": 0.25, "loss_probability": 0.125, "connected": False}
    assert change.values().items() >= given.items()
    assert set(change.values()) == set(CHANGEABLE)
    assert change.applied_to(RadioLink(3.0, 2.0, 1.0)) == LINK


@pytest.mark.parametrize("values", [{"delay": -1.0}, {"jitter": math.inf}, {"loss_probability": 1.5}])
def test_a_change_to_a_link_that_cannot_be_is_refused(values: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must be 0 to 3600 s, loss_probability 0 to 1"):
        RadioLinkChange("slave_1", **values).applied_to(LINK)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"retries": 17}, "retries 17: must be 0 to 16"),
        ({"retry_interval": 0.0}, "retry_interval 0.0: must be 0.01 to 3600"),
        ({"duplicate_probability": math.nan}, "duplicate_probability nan: must be 0 to 1"),
        ({"burst_length": -1.0}, "burst_length -1.0: must be 0 to 3600"),
        ({"burst_spacing": 0.0}, "burst_spacing 0.0: must be 0.01 to 3600"),
        ({"burst_loss_probability": 2.0}, "burst_loss_probability 2.0: must be 0 to 1"),
        (
            {"jitter_law": "cauchy"},
            "jitter_law 'cauchy': must be one of uniform, exponential, normal, gamma, empirical",
        ),
        ({"fails": "both"}, "fails 'both': must be one of none, to_slave, from_slave"),
    ],
)
def test_what_no_link_can_have_is_refused_by_name(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        RadioLinkChange("slave_1", **values).applied_to(LINK)
