"""Memory of a train: blocks of rows for the compiled code, and the names of the rows.

Python hands over a dozen arrays faster than a hundred, so compiled code is given `Blocks`; functions ``..._of`` give
the rows of a block the names by which everything else speaks of them (`data`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple, TypeVar

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.air_data import AirParameters, AirState, DriverValveParameters, DriverValveState
from haul_ros.physics.kernel.data import (
    BrakeState,
    DrawbarExtremes,
    DrawbarState,
    Floats,
    GearExtremes,
    GearParameters,
    GearState,
    GearTrial,
    GradePieces,
    Hinges,
    Ints,
    LineIndex,
    LineSteps,
    MassParameters,
    MassState,
    MassTrial,
    Members,
    Records,
    VehicleParameters,
    VehicleState,
    VehicleTrial,
)

_Named = TypeVar("_Named", bound=NamedTuple)


class Blocks(NamedTuple):
    """Memory of a train: a row of a block for each named array, in the order of `LAYOUT`."""

    settings: Records  # (1,) SETTINGS, read-only
    counters: Records  # (1,) COUNTERS
    waves: Records  # (w,) WAVE, the first ``counters.waves`` are in use
    mass_index: Ints  # (v,) mass of every vehicle, read-only
    vehicle_parameters: Floats  # read-only
    vehicles: Floats
    members: Ints  # read-only
    mass_parameters: Floats  # read-only
    masses: Floats
    gear_parameters: Floats  # read-only
    hinges: Floats  # (6, h, m - 1), read-only
    gears: Floats
    grades: Floats  # read-only
    curves: Floats  # read-only
    line_index: Ints
    air: Records  # (1,) AIR, read-only
    air_account: Records  # (1,) AIR_ACCOUNT
    air_parameters: Floats  # (.., v), without a pneumatic brake (.., 0), as the next; read-only
    air_state: Floats
    driver_valve_parameters: Floats  # read-only
    driver_valves: Floats


class Train(NamedTuple):
    """Everything the kernel works on, by name."""

    settings: Records
    counters: Records
    waves: Records
    air: Records
    air_account: Records
    mass_index: Ints
    vehicle_parameters: VehicleParameters
    vehicles: VehicleState
    brakes: BrakeState
    vehicle_trial: VehicleTrial
    drawbars: DrawbarState
    drawbar_extremes: DrawbarExtremes
    members: Members
    mass_parameters: MassParameters
    masses: MassState
    mass_trial: MassTrial
    gear_parameters: GearParameters
    hinges: Hinges
    gears: GearState
    gear_trial: GearTrial
    gear_extremes: GearExtremes
    grades: GradePieces
    curves: LineSteps
    line_index: LineIndex
    air_parameters: AirParameters
    air_state: AirState
    driver_valve_parameters: DriverValveParameters
    driver_valves: DriverValveState


LAYOUT: dict[str, tuple[Any, ...]] = {
    "vehicle_parameters": (VehicleParameters,),
    "vehicles": (VehicleState, BrakeState, VehicleTrial, DrawbarState, DrawbarExtremes),
    "members": (Members,),
    "mass_parameters": (MassParameters,),
    "masses": (MassState, MassTrial),
    "gear_parameters": (GearParameters,),
    "hinges": (Hinges,),
    "gears": (GearState, GearTrial, GearExtremes),
    "grades": (GradePieces,),
    "curves": (LineSteps,),
    "line_index": (LineIndex,),
    "air_parameters": (AirParameters,),
    "air_state": (AirState,),
    "driver_valve_parameters": (DriverValveParameters,),
    "driver_valves": (DriverValveState,),
}
"""What the rows of the blocks are."""


def row_count(block: str) -> int:
    """Rows of a block of `LAYOUT`."""
    return sum(len(kind._fields) for kind in LAYOUT[block])


def _names(block: str, kind: type[_Named]) -> Callable[[Any], _Named]:
    """Write a function that names rows: as source, because the compiler has to see the row numbers as constants."""
    kinds = LAYOUT[block]
    first = sum(len(before._fields) for before in kinds[: kinds.index(kind)])
    rows = [f"block[{first + n}]" for n in range(len(kind._fields))]
    namespace: dict[str, Any] = {"Kind": kind}
    exec(f"def names(block):\n    return Kind({', '.join(rows)})", namespace)
    function: Callable[[Any], _Named] = inner(namespace["names"])
    return function


vehicle_parameters_of = _names("vehicle_parameters", VehicleParameters)
vehicles_of = _names("vehicles", VehicleState)
brakes_of = _names("vehicles", BrakeState)
vehicle_trial_of = _names("vehicles", VehicleTrial)
drawbars_of = _names("vehicles", DrawbarState)
drawbar_extremes_of = _names("vehicles", DrawbarExtremes)
members_of = _names("members", Members)
mass_parameters_of = _names("mass_parameters", MassParameters)
masses_of = _names("masses", MassState)
mass_trial_of = _names("masses", MassTrial)
gear_parameters_of = _names("gear_parameters", GearParameters)
hinges_of = _names("hinges", Hinges)
gears_of = _names("gears", GearState)
gear_trial_of = _names("gears", GearTrial)
gear_extremes_of = _names("gears", GearExtremes)
grades_of = _names("grades", GradePieces)
curves_of = _names("curves", LineSteps)
line_index_of = _names("line_index", LineIndex)
air_parameters_of = _names("air_parameters", AirParameters)
air_state_of = _names("air_state", AirState)
driver_valve_parameters_of = _names("driver_valve_parameters", DriverValveParameters)
driver_valves_of = _names("driver_valves", DriverValveState)


def named(blocks: Blocks) -> Train:
    """All of a train's memory by name, for Python; compiled code names what it uses."""
    groups = (kind(*rows) for block, kinds in LAYOUT.items() for kind, rows in _rows(getattr(blocks, block), kinds))
    records = (blocks.settings, blocks.counters, blocks.waves, blocks.air, blocks.air_account, blocks.mass_index)
    return Train(*records, *groups)


def _rows(block: Floats, kinds: tuple[Any, ...]) -> Iterator[tuple[Any, Floats]]:
    end = 0
    for kind in kinds:
        start, end = end, end + len(kind._fields)
        yield kind, block[start:end]
