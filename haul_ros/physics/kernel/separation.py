"""Couplers that break and hoses that part at the end of a time step: seen here, carried out by who asked for steps."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.blocks import Blocks, gear_parameters_of, gears_of


@inner
def gives_way(blocks: Blocks) -> bool:
    """Whether the tension of a coupler is above its strength, or a gap wider than its hose reaches."""
    parameters, gears = gear_parameters_of(blocks.gear_parameters), gears_of(blocks.gears)
    count = 0
    for k in range(gears.force.shape[0]):
        count += 1 if -gears.force[k] > parameters.strength[k] else 0
    for k in range(gears.stroke.shape[0]):
        count += 1 if -gears.stroke[k] > parameters.hose_reach[k] else 0
    return count > 0
