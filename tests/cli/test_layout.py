from __future__ import annotations

import pytest

from haul_ros.cli.layout import file_size, rows


def test_values_stand_one_below_the_other() -> None:
    assert rows([("a", "1"), ("longer", "2")]) == ["  a                  1", "  longer             2"]


@pytest.mark.parametrize(("size", "text"), [(0, "0.0 kB"), (12_340, "12.3 kB"), (15_500_000, "15.5 MB")])
def test_sizes_have_fitting_units(size: int, text: str) -> None:
    assert file_size(size) == text
