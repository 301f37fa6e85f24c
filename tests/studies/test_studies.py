from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from haul_ros.studies import study as study_module
from haul_ros.studies.definition import free_sweep, load_study
from haul_ros.studies.errors import StudyError
from haul_ros.studies.pools import local_pool
from haul_ros.studies.study import RESULTS_FILE, run_study
from haul_ros.studies.tables import case_row

PNG = b"\x89PNG\r\n\x1a\n"


def names(files: tuple[Path, ...]) -> list[str]:
    return [file.name for file in files if file.suffix != ".parquet"]


def test_a_sweep_of_few_cases_writes_tables_and_profiles(tmp_path: Path, short: str) -> None:
    sweep = free_sweep(short, [], ["initial_speed_kmh=20,30"], [], None, 0)
    outcome = run_study(sweep, tmp_path / "out", local_pool)
    assert outcome.complete
    assert names(outcome.files) == ["sweep.csv", "sweep_profiles.csv", "sweep.png"]
    assert all(file.is_file() for file in outcome.files)
    assert (tmp_path / "out" / "sweep.png").read_bytes().startswith(PNG)


def test_a_sweep_of_samples_writes_quantiles(tmp_path: Path, short: str) -> None:
    sweep = free_sweep(short, [], [], ["vehicles.C80.mass_t=normal(100,5)"], 6, 1)
    outcome = run_study(sweep, tmp_path, local_pool)
    assert names(outcome.files) == ["sweep.csv", "sweep_profiles.csv", "sweep_quantiles.csv", "sweep.png"]
    quantiles = np.genfromtxt(tmp_path / "sweep_quantiles.csv", delimiter=",", names=True)
    assert len(quantiles) == 11
    spread = quantiles["force_quantile_095_kN"] - quantiles["force_quantile_005_kN"]
    assert spread.min() >= 0.0
    assert spread[0] > 1.0
    assert "median" in outcome.claims[0].found


def test_trains_of_different_length_have_no_quantiles(tmp_path: Path, short: str) -> None:
    outcome = run_study(free_sweep(short, [], ["consist.1.count=4:12:1"], [], None, 0), tmp_path, local_pool)
    assert names(outcome.files) == ["sweep.csv", "sweep_profiles.csv"]


def test_a_study_goes_on_where_it_stopped_and_ends_with_the_same_files(tmp_path: Path, short: str) -> None:
    sweep = free_sweep(short, [], ["initial_speed_kmh=20:31:1"], [], None, 0)
    finished: list[None] = []
    run = partial(run_study, sweep, tmp_path / "a", partial(local_pool, 1), on_finished=lambda: finished.append(None))
    first = run(stop=lambda: len(finished) >= 3)
    assert 3 <= first.finished < first.total == 12
    assert not first.complete
    assert names(first.files) == ["sweep.csv", "sweep_profiles.csv"]
    assert run().complete
    run_study(sweep, tmp_path / "b", local_pool)
    for name in ("sweep.csv", "sweep_profiles.csv", "sweep_quantiles.csv"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_nothing_is_made_when_a_key_is_unknown(tmp_path: Path, short: str) -> None:
    sweep = free_sweep(short, [], ["initial_sped_kmh=20,30"], [], None, 0)
    with pytest.raises(Exception, match="unknown key"):
        run_study(sweep, tmp_path / "out", local_pool)
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path, short: str) -> None:
    (tmp_path / "file").write_text("")
    sweep = free_sweep(short, [], ["initial_speed_kmh=20"], [], None, 0)
    with pytest.raises(StudyError, match="file: cannot be written"):
        run_study(sweep, tmp_path / "file", local_pool)


def test_cases_whose_steps_did_not_converge_are_named(
    tmp_path: Path, short: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study_module, "case_row", lambda *a: case_row(*a) | {"unconverged_steps": 2})
    outcome = run_study(free_sweep(short, [], ["initial_speed_kmh=20"], [], None, 0), tmp_path, local_pool)
    assert outcome.unconverged == ("initial_speed_kmh=20",)
    assert outcome.faulty == ()
    assert "couplers.paper_set_b: all values fitted" in outcome.caveats


def test_the_vibration_study_simulates_nothing_and_finds_what_the_paper_says(tmp_path: Path) -> None:
    outcome = run_study(load_study("vibration"), tmp_path, local_pool)
    assert all(claim.holds for claim in outcome.claims)
    assert "factor of 0.8165 to 0.8165" in outcome.claims[0].found
    assert names(outcome.files) == ["vibration.csv", "vibration_modes.csv", "vibration.png"]
    assert not (tmp_path / RESULTS_FILE).exists()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Shared, so that studies share the cases that they have in common."""
    return tmp_path_factory.mktemp("studies")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("validation", ["1054.4 kN", "at 0.667"]),
        ("distribution", ["702.2 kN", "24.25 mm"]),
        ("initial-speed", ["784.2/736.3/702.2/676.9 kN"]),
        ("synchronisation", ["702.2/787.4/965.3/1319.5/1714.0/2514.0 kN"]),
        ("stiffness", ["657.3/688.2/702.2/711.3 kN", "33.72/28.34/24.25/18.54 mm"]),
    ],
)
def test_the_paper_s_claims_hold_with_the_default_set(folder: Path, name: str, numbers: list[str]) -> None:
    outcome = run_study(load_study(name), folder, local_pool)
    assert {claim.verdict for claim in outcome.claims} == {"reproduced (fitted)"}
    text = " ".join(claim.found for claim in outcome.claims)
    assert all(number in text for number in numbers)


@pytest.mark.slow
def test_rigid_arms_lower_the_force_with_set_b_and_raise_it_with_set_a(folder: Path) -> None:
    claims = run_study(load_study("rigid-arms"), folder, local_pool).claims
    verdicts = ["reproduced (fitted)", "predicted", "contradicted", "contradicted"]
    assert [claim.verdict for claim in claims] == verdicts
    assert "675.7 kN (-3.8 %)" in claims[0].found
    assert "824.2 kN (+17.9 %)" in claims[2].found
