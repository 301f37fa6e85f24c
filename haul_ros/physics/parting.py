"""Couplers and hoses that part: what changes in the memory of a train, and what is told of it.

A parted coupler bears buff on contact and no draft: the hinges of its draft side are gone. The energy that its draft
gear held in draft at that instant comes back to neither part of the train: it is counted as dissipated.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

from haul_ros.model.sample import FloatArray
from haul_ros.physics.assembly import protected
from haul_ros.physics.kernel import data
from haul_ros.physics.kernel.air_flow import FLOW_FACTOR
from haul_ros.physics.kernel.blocks import Blocks


class PartingKind(enum.Enum):
    """What gave way."""

    BROKEN = "broke"
    """A coupler, by its tension."""
    UNCOUPLED = "uncoupled"
    """A coupler, by hand."""
    HOSE = "hose parted"
    """The hose of a parted coupler, by the gap."""


@dataclass(frozen=True, slots=True)
class Parting:
    """What gave way at which coupler (index), when [s], under what tension [N] (negative: buff), at what gap [m]."""

    time: float
    coupler: int
    kind: PartingKind
    tension: float
    gap: float


def without_draft(blocks: Blocks, gear: int, hose_reach: float) -> Blocks:
    """The memory of a train whose draft gear of this index bears no draft any more.

    Its hose parts at a gap of ``hose_reach`` [m]; infinite: it has parted already. From now on there is slack, so
    steps are solved as in trains that have some.
    """
    hinges, parameters, settings = blocks.hinges.copy(), blocks.gear_parameters.copy(), blocks.settings.copy()
    data.Hinges(*hinges).tension_mean[:, gear] = 0.0
    data.Hinges(*hinges).tension_hysteresis[:, gear] = 0.0
    rows = data.GearParameters(*parameters)
    rows.strength[gear] = rows.full_draft_stroke[gear] = np.inf
    rows.hose_reach[gear] = hose_reach
    settings.has_slack = settings.may_part = 1
    return protected(blocks._replace(hinges=hinges, gear_parameters=parameters, settings=settings))


def without_hose(blocks: Blocks, gear: int) -> Blocks:
    """The memory of a train in which no hose is left to part at a draft gear."""
    parameters = blocks.gear_parameters.copy()
    data.GearParameters(*parameters).hose_reach[gear] = np.inf
    return protected(blocks._replace(gear_parameters=parameters))


def stop_waves_at(waves: data.Records, coupler: int) -> None:
    """Let brake waves that have not passed a coupler (index) end there."""
    ahead_of_it = waves.behind <= coupler
    waves.last[ahead_of_it] = np.minimum(waves.last[ahead_of_it], coupler)
    behind_it = waves.ahead > coupler
    waves.first[behind_it] = np.maximum(waves.first[behind_it], coupler + 1)


def leak_areas(pipe_volume: FloatArray, gas: float, pressure: float, rate: float) -> FloatArray:
    """Effective areas [m^2] of openings (v,) through which a pipe that nothing feeds falls at a rate [Pa/s].

    At its charged ``pressure`` [Pa, absolute], at which flow to the atmosphere is choked; it is the same everywhere,
    so nothing flows along the pipe. ``gas`` is R T [J/kg], ``pipe_volume`` (v,) [m^3].
    """
    return np.asarray(rate * pipe_volume / (np.sqrt(gas) * FLOW_FACTOR * pressure))
