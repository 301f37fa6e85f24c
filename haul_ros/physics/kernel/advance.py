"""The loop over time steps: the one compiled function that Python calls."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import entry, inner
from haul_ros.physics.kernel.air import advance_air, brakes_of_cylinders
from haul_ros.physics.kernel.blocks import (
    Blocks,
    brakes_of,
    mass_trial_of,
    masses_of,
    vehicle_parameters_of,
    vehicles_of,
)
from haul_ros.physics.kernel.brake_force import fill_cylinders, interpolate_coefficients
from haul_ros.physics.kernel.brake_wave import advance_waves
from haul_ros.physics.kernel.commit import drawbars_at_end
from haul_ros.physics.kernel.data import PARTS, Floats
from haul_ros.physics.kernel.drawbar_corners import keep_drawbars_on_the_way
from haul_ros.physics.kernel.extremes import keep_extremes, keep_extremes_on_the_way
from haul_ros.physics.kernel.newmark import balance_at_start, largest_residual, solve_step, take_step
from haul_ros.physics.kernel.resolution import too_long
from haul_ros.physics.kernel.separation import gives_way
from haul_ros.physics.kernel.traction import take_up_traction


@inner
def _step(blocks: Blocks) -> int:
    """One time step, whole or, where it does not converge or meets a stiff contact, in parts.

    Returns the number of Newton iterations of the parts that were taken.
    """
    counters = blocks.counters[0]
    time_step = blocks.settings[0].time_step
    total, done, failed, divided = 0, 0, 0, 0
    while done < PARTS:
        part = counters.part
        if part < PARTS:
            interpolate_coefficients(brakes_of(blocks.vehicles), (done + part) / PARTS)
        h = time_step * (part / PARTS)
        iterations = solve_step(blocks, h)
        if part > 1 and (iterations < 0 or too_long(blocks, h)):
            failed += 1 if iterations < 0 else 0
            counters.part = part // 2
            continue
        # Parts lie at multiples of their length.
        grows = part < PARTS and (done + part) % PARTS % (2 * part) == 0 and not too_long(blocks, 2.0 * h)
        counters.part = 2 * part if grows else part
        divided += 1 if part < PARTS else 0
        keep_extremes_on_the_way(blocks, (counters.step + done / PARTS) * time_step, h)
        if blocks.settings[0].has_drawbars:
            keep_drawbars_on_the_way(blocks, (counters.step + done / PARTS) * time_step, h)
        take_step(blocks, h)
        if iterations < 0:
            counters.unconverged_steps += 1
            counters.worst_residual = max(
                counters.worst_residual, largest_residual(mass_trial_of(blocks.masses).residual)
            )
        total += max(iterations, 0)
        done += part
        time = (counters.step + done / PARTS) * time_step
        keep_extremes(blocks, time)
        if blocks.settings[0].has_drawbars:
            drawbars_at_end(blocks, time)
    counters.fallback_steps += 1 if failed > 0 else 0
    counters.divided_steps += 1 if divided > 0 and failed == 0 else 0
    return total


@inner
def _in_motion(direction: Floats) -> bool:
    for m in range(direction.shape[0]):
        if direction[m] != 0.0:
            return True
    return False


@entry
def advance(blocks: Blocks, n_steps: int) -> None:
    """Advance the train by ``n_steps`` time steps, or fewer, up to one at whose end a coupler or a hose gives way.

    The outcome does not depend on how steps are grouped.

    Counters tell how the steps went: Newton iterations, steps that had to be divided, parts of
    steps taken with a residual above the tolerance.
    """
    counters = blocks.counters[0]
    settings = blocks.settings[0]
    parameters, brakes = vehicle_parameters_of(blocks.vehicle_parameters), brakes_of(blocks.vehicles)
    masses = masses_of(blocks.masses)
    take_up_traction(blocks)
    # Once more before the first step, with all the traction of that instant: what lies between one locomotive's
    # and the next one's is no state of the train.
    if blocks.air[0].present and counters.balanced == 0:
        brakes_of_cylinders(blocks, 1.0)
    if counters.step == 0 and (n_steps > 0 or counters.balanced == 0):
        balance_at_start(blocks)
        counters.balanced = 1
    for _ in range(n_steps):
        start = counters.step * settings.time_step
        time = (counters.step + 1) * settings.time_step
        if counters.waves > 0:
            advance_waves(
                settings,
                counters,
                blocks.waves,
                masses.velocity,
                blocks.mass_index,
                parameters,
                brakes,
                vehicles_of(blocks.vehicles),
                start,
                time,
            )
        if blocks.air[0].present:
            advance_air(blocks)
        else:
            fill_cylinders(settings, parameters, brakes, start, time)
        iterations = _step(blocks)
        counters.newton_total += iterations
        counters.newton_max = max(counters.newton_max, iterations)
        counters.step += 1
        if _in_motion(masses.direction):
            counters.last_motion_step = counters.step
        if settings.may_part and gives_way(blocks):
            break
