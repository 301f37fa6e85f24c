"""What tests of several folders share."""

import os

import pytest
from hypothesis import settings

# CI tries the same examples every time; elsewhere each run looks at new ones.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")

SHORT_TRAIN = """\
description: short train, emergency from 20 km/h
consist:
  - {vehicle: SS4, role: master}
  - {vehicle: C80, count: 20}
  - {vehicle: SS4, role: slave}
coupler: paper_set_b
brakes: paper_set_b
initial_speed_kmh: 20
max_duration_s: 60
radio: {default: {delay_s: 1.0}}
commands:
  - {at_s: 0.5, locomotive: master, emergency: true}
"""


@pytest.fixture(scope="session")
def short_train() -> str:
    """A scenario of 22 vehicles that stop within seconds."""
    return SHORT_TRAIN
