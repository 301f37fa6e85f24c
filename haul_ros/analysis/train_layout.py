"""Of what a train consists, as far as tables and figures need it: from its scenario, or from names alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haul_ros.analysis.envelopes import full_strokes
from haul_ros.model.consist import Consist, Locomotive
from haul_ros.model.sample import FloatArray
from haul_ros.model.scenario import Scenario
from haul_ros.recording.train_source import TrainSource


@dataclass(frozen=True, slots=True, eq=False)
class TrainLayout:
    """Names of ``vehicles`` and ``couplers``; ``geared`` (n_couplers,): not a rigid drawbar; ``locomotives`` that take
    commands; ``wagons`` (indices of vehicles without traction), ``lengths`` (n_vehicles,) [m] of the vehicles and
    ``full_strokes`` (n_couplers,) [m] of the gears, None: not known."""

    vehicles: tuple[str, ...]
    couplers: tuple[str, ...]
    geared: NDArray[np.bool_]
    locomotives: tuple[Locomotive, ...] = ()
    wagons: tuple[int, ...] = ()
    lengths: FloatArray | None = None
    full_strokes: FloatArray | None = None

    @staticmethod
    def of(consist: Consist) -> TrainLayout:
        """All is known."""
        return TrainLayout(
            vehicles=consist.vehicle_names,
            couplers=consist.coupler_names,
            geared=np.array([gear is not None for gear in consist.couplers], dtype=np.bool_),
            locomotives=consist.locomotives,
            wagons=tuple(i for i, v in enumerate(consist.vehicles) if v.max_tractive_effort == 0.0),
            lengths=np.array([vehicle.length for vehicle in consist.vehicles]),
            full_strokes=full_strokes(consist),
        )

    @staticmethod
    def from_names(source: TrainSource) -> TrainLayout:
        """Without scenario; vehicles that were not recorded have numbers for names."""
        count = len(source.couplers)
        vehicles = source.vehicles or tuple(f"vehicle_{i:03d}" for i in range(1, count + 2))
        return TrainLayout(vehicles, source.couplers, np.ones(count, dtype=np.bool_))

    @staticmethod
    def for_source(source: TrainSource, scenario: Scenario | None) -> TrainLayout:
        """From the scenario if there is one."""
        return TrainLayout.from_names(source) if scenario is None else TrainLayout.of(scenario.consist)

    def place(self, vehicle: int) -> str:
        """head, mid or tail for the first, the middle and the last wagon (vehicle, where wagons are not known)."""
        among = self.wagons or tuple(range(len(self.vehicles)))
        chosen = {among[0]: "head", among[-1]: "tail", among[len(among) // 2]: "mid"}
        return chosen.get(vehicle, "")
