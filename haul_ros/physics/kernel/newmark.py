"""One step of the Newmark method, gamma = 1/2, beta = 1/4 (paper eqs. 6, 7), iterated to convergence.

Unknown are the velocities v' at the end of the step. With these gamma and beta

    a' = 2 (v' - v)/h - a,    x' = x + h/2 (v + v')

and Newton's method solves m a' = forces(x', v', t') with a symmetric tridiagonal tangent.

Brake and resistance are dry friction: they oppose motion while a mass slides, and hold it at
v' = 0 as long as the force needed to do so stays below what they can give. A mass that comes to
rest within the step needs the mean friction force m (v' - v)/h - (push + push')/2 over the step,
so the kinetic energy that is lost equals the work done in that step too. A standing mass has a = 0, unless its
friction no longer holds it at the end of the step: then it will slide in the next.
"""

from __future__ import annotations

from haul_ros.physics.kernel import arrays as a
from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.arrays import Floats, Ints, Train
from haul_ros.physics.kernel.brake_force import brake_forces
from haul_ros.physics.kernel.coupler import coupler_forces
from haul_ros.physics.kernel.drawbar import collect, spread, update_drawbars
from haul_ros.physics.kernel.resistance import line_forces, running_resistance
from haul_ros.physics.kernel.tridiagonal import solve_tridiagonal

MAX_ITERATIONS = 25

CAPTURE_SPEED = 1e-4
"""Speed [m/s] below which a mass stands if friction can hold it.

Without it a mass that a coupler eases into balance would creep on for ever, ever more slowly.
"""

LEAST_FRICTION = 1e-9
"""Friction [N] below which there is none to share among the members of a mass."""


@inner
def _predict(masses: Floats, h: float) -> None:
    """First guess of the velocities at the end: the acceleration stays. Nothing turns round at once."""
    for m in range(masses.shape[1]):
        slow = abs(masses[a.VELOCITY, m]) < CAPTURE_SPEED
        masses[a.NEW_DIRECTION, m] = 0.0 if slow else masses[a.DIRECTION, m]
    for m in range(masses.shape[1]):
        guess = masses[a.VELOCITY, m] + h * masses[a.ACCELERATION, m]
        masses[a.NEW_VELOCITY, m] = guess if guess * masses[a.NEW_DIRECTION, m] > 0.0 else 0.0


@inner
def _friction(masses: Floats, vehicles: Floats, members: Ints, places: Ints) -> None:
    """What brakes and resistance can bring up at the trial velocities, by vehicle and by mass."""
    for m in range(masses.shape[1]):
        direction = masses[a.NEW_DIRECTION, m]
        speed = max(direction * masses[a.NEW_VELOCITY, m], 0.0)
        masses[a.SHARE, m] = speed if direction != 0.0 else -1.0
    spread(masses, a.SHARE, vehicles, a.SLIDING_SPEED, places)
    brake_forces(vehicles)
    running_resistance(vehicles)
    collect(vehicles, a.NEW_BRAKE, a.NEW_RESISTANCE, masses, a.FRICTION, members)
    collect(vehicles, a.NEW_SLOPE, -1, masses, a.FRICTION_SLOPE, members)


@inner
def _push(masses: Floats, joints: Floats) -> None:
    """Force of couplers, traction and grade on every mass."""
    last = masses.shape[1] - 1
    masses[a.NEW_PUSH, 0] = masses[a.OUTER, 0] + (joints[a.NEW_FORCE, 0] if last > 0 else 0.0)
    for m in range(1, last):
        masses[a.NEW_PUSH, m] = masses[a.OUTER, m] + (joints[a.NEW_FORCE, m] - joints[a.NEW_FORCE, m - 1])
    if last > 0:
        masses[a.NEW_PUSH, last] = masses[a.OUTER, last] - joints[a.NEW_FORCE, last - 1]


@inner
def _holding_force(masses: Floats, m: int, h: float) -> float:
    """Mean friction force over the step that leaves a mass at rest at its end [N], forward positive."""
    return -masses[a.MASS, m] * masses[a.VELOCITY, m] / h - 0.5 * (masses[a.PUSH, m] + masses[a.NEW_PUSH, m])


@inner
def _rows(masses: Floats, joints: Floats, h: float) -> None:
    """Residual and tangent of every mass, as if all were sliding."""
    last = masses.shape[1] - 1
    for m in range(last + 1):
        change = 2.0 / h * (masses[a.NEW_VELOCITY, m] - masses[a.VELOCITY, m]) - masses[a.ACCELERATION, m]
        force = masses[a.NEW_PUSH, m] - masses[a.NEW_DIRECTION, m] * masses[a.FRICTION, m]
        masses[a.RESIDUAL, m] = force - masses[a.MASS, m] * change
    for m in range(last + 1):
        masses[a.DIAGONAL, m] = 2.0 / h * masses[a.MASS, m] + masses[a.FRICTION_SLOPE, m]
    for k in range(last):
        masses[a.DIAGONAL, k] += joints[a.TANGENT, k]
    for k in range(last):
        masses[a.DIAGONAL, k + 1] += joints[a.TANGENT, k]
    for k in range(last):
        masses[a.OFF_DIAGONAL, k] = -joints[a.TANGENT, k]


@inner
def _standing_rows(masses: Floats, h: float) -> int:
    """Rows of the masses that stand; sets those sliding that friction cannot hold, and returns their number."""
    loose = 0
    for m in range(masses.shape[1]):
        if masses[a.NEW_DIRECTION, m] != 0.0:
            continue
        needed = _holding_force(masses, m, h)
        if abs(needed) > masses[a.FRICTION, m]:
            loose += 1
            masses[a.NEW_DIRECTION, m] = 1.0 if needed < 0.0 else -1.0
        masses[a.RESIDUAL, m] = 0.0
        masses[a.DIAGONAL, m] = 1.0
        masses[a.OFF_DIAGONAL, m] = 0.0
        if m > 0:
            masses[a.OFF_DIAGONAL, m - 1] = 0.0
    return loose


@inner
def _open_masses(masses: Floats, tolerance: float) -> int:
    """Number of masses that are not in balance within the tolerance."""
    count = 0
    for m in range(masses.shape[1]):
        count += 0 if abs(masses[a.RESIDUAL, m]) <= tolerance else 1
    return count


@inner
def _correct(masses: Floats) -> None:
    """Newton's correction of the velocities; a mass that would turn round stands first."""
    solve_tridiagonal(masses[a.DIAGONAL], masses[a.OFF_DIAGONAL], masses[a.RESIDUAL])
    for m in range(masses.shape[1]):
        masses[a.NEW_VELOCITY, m] += masses[a.RESIDUAL, m]
    for m in range(masses.shape[1]):
        turned = masses[a.NEW_VELOCITY, m] * masses[a.NEW_DIRECTION, m] < 0.0
        masses[a.NEW_DIRECTION, m] = 0.0 if turned else masses[a.NEW_DIRECTION, m]
    for m in range(masses.shape[1]):
        masses[a.NEW_VELOCITY, m] = 0.0 if masses[a.NEW_DIRECTION, m] == 0.0 else masses[a.NEW_VELOCITY, m]


@inner
def _account_arrested(masses: Floats, vehicles: Floats, members: Ints, h: float) -> None:
    """Friction work of masses that come to rest in this step, over what the trapezoidal rule will add for them."""
    for m in range(masses.shape[1]):
        if masses[a.NEW_DIRECTION, m] != 0.0 or masses[a.VELOCITY, m] == 0.0:
            continue
        mean = -_holding_force(masses, m, h) / max(masses[a.FRICTION, m], LEAST_FRICTION)
        share = masses[a.SHARE, m]
        way = masses[a.WAY, m]
        for i in range(members[a.FIRST, m], members[a.END, m]):
            brake, resistance = vehicles[a.NEW_BRAKE, i], vehicles[a.NEW_RESISTANCE, i]
            ruled = 0.5 * (vehicles[a.BRAKE_FORCE, i] + share * brake)
            vehicles[a.BRAKE_WORK, i] += (mean * brake - ruled) * way
            ruled = 0.5 * (vehicles[a.RESISTANCE_FORCE, i] + share * resistance)
            vehicles[a.RESISTANCE_WORK, i] += (mean * resistance - ruled) * way


@inner
def _commit_friction(vehicles: Floats, available: int, force: int, work: int) -> None:
    """Friction force at the end of the step, and its work by the trapezoidal rule."""
    for i in range(vehicles.shape[1]):
        now = vehicles[a.VEHICLE_SHARE, i] * vehicles[available, i]
        vehicles[work, i] += 0.5 * (vehicles[force, i] + now) * vehicles[a.VEHICLE_WAY, i]
    for i in range(vehicles.shape[1]):
        vehicles[force, i] = vehicles[a.VEHICLE_SHARE, i] * vehicles[available, i]


@inner
def _commit_forces(t: Train, h: float) -> None:
    """Forces of all vehicles at the end of the step, and their works."""
    masses, vehicles = t.masses, t.vehicles
    for m in range(masses.shape[1]):
        # Members of a standing mass share the holding force in proportion to what each can give.
        held = masses[a.NEW_PUSH, m] / max(masses[a.FRICTION, m], LEAST_FRICTION)
        held = min(1.0, max(-1.0, held))
        direction = masses[a.NEW_DIRECTION, m]
        masses[a.SHARE, m] = direction if direction != 0.0 else held
    for m in range(masses.shape[1]):
        masses[a.WAY, m] = 0.5 * h * (masses[a.VELOCITY, m] + masses[a.NEW_VELOCITY, m])
    spread(masses, a.SHARE, vehicles, a.VEHICLE_SHARE, t.places)
    spread(masses, a.WAY, vehicles, a.VEHICLE_WAY, t.places)
    _account_arrested(masses, vehicles, t.members, h)
    _commit_friction(vehicles, a.NEW_BRAKE, a.BRAKE_FORCE, a.BRAKE_WORK)
    _commit_friction(vehicles, a.NEW_RESISTANCE, a.RESISTANCE_FORCE, a.RESISTANCE_WORK)
    if t.settings[0].has_traction:
        for i in range(vehicles.shape[1]):
            mean = 0.5 * (vehicles[a.TRACTION, i] + vehicles[a.NEW_TRACTION, i])
            vehicles[a.TRACTION_WORK, i] += mean * vehicles[a.VEHICLE_WAY, i]
        for i in range(vehicles.shape[1]):
            vehicles[a.TRACTION, i] = vehicles[a.NEW_TRACTION, i]
    if t.settings[0].has_line:
        for i in range(vehicles.shape[1]):
            mean = 0.5 * (vehicles[a.GRAVITY, i] + vehicles[a.NEW_GRAVITY, i])
            vehicles[a.GRAVITY_WORK, i] += mean * vehicles[a.VEHICLE_WAY, i]
        for i in range(vehicles.shape[1]):
            vehicles[a.GRAVITY, i] = vehicles[a.NEW_GRAVITY, i]


@inner
def _excess_acceleration(push: float, friction: float, mass: float) -> float:
    """Acceleration of a standing mass by what its friction cannot hold, 0 if it can hold all."""
    excess = max(abs(push) - friction, 0.0) / mass
    return excess if push > 0.0 else -excess


@inner
def _commit_motion(masses: Floats, h: float) -> None:
    for m in range(masses.shape[1]):
        change = 2.0 / h * (masses[a.NEW_VELOCITY, m] - masses[a.VELOCITY, m]) - masses[a.ACCELERATION, m]
        excess = _excess_acceleration(masses[a.NEW_PUSH, m], masses[a.FRICTION, m], masses[a.MASS, m])
        masses[a.ACCELERATION, m] = change if masses[a.NEW_DIRECTION, m] != 0.0 else excess
    for m in range(masses.shape[1]):
        masses[a.DISPLACEMENT, m] += masses[a.WAY, m]
    for m in range(masses.shape[1]):
        masses[a.VELOCITY, m] = masses[a.NEW_VELOCITY, m]
    for m in range(masses.shape[1]):
        masses[a.DIRECTION, m] = masses[a.NEW_DIRECTION, m]
    for m in range(masses.shape[1]):
        masses[a.PUSH, m] = masses[a.NEW_PUSH, m]


@inner
def _commit_connections(joints: Floats) -> None:
    for k in range(joints.shape[1]):
        way = joints[a.NEW_STROKE, k] - joints[a.STROKE, k]
        joints[a.WORK, k] += 0.5 * (joints[a.FORCE, k] + joints[a.NEW_FORCE, k]) * way
    for k in range(joints.shape[1]):
        joints[a.STROKE, k] = joints[a.NEW_STROKE, k]
    for k in range(joints.shape[1]):
        joints[a.STROKE_RATE, k] = joints[a.NEW_RATE, k]
    for k in range(joints.shape[1]):
        joints[a.FORCE, k] = joints[a.NEW_FORCE, k]


@inner
def _outer_forces(t: Train, h: float) -> None:
    """Traction and grade on every mass; they do not depend on the trial velocities."""
    settings = t.settings[0]
    if settings.has_line:
        line_forces(settings.start_chainage, t.grades, t.curves, t.masses, t.vehicles, t.places, h)
    if settings.has_line or settings.has_traction:
        collect(t.vehicles, a.NEW_TRACTION, a.NEW_GRAVITY, t.masses, a.OUTER, t.members)


@inner
def balance_at_start(t: Train) -> None:
    """Forces and accelerations of the initial state, from its strokes and velocities."""
    masses = t.masses
    for m in range(masses.shape[1]):
        masses[a.NEW_VELOCITY, m] = masses[a.VELOCITY, m]
        masses[a.NEW_DIRECTION, m] = masses[a.DIRECTION, m]
    _outer_forces(t, 0.0)
    coupler_forces(masses, t.connections, t.hinges, 0.0)
    _friction(masses, t.vehicles, t.members, t.places)
    _push(masses, t.connections)
    for m in range(masses.shape[1]):
        push, friction, direction = masses[a.NEW_PUSH, m], masses[a.FRICTION, m], masses[a.DIRECTION, m]
        sliding = (push - direction * friction) / masses[a.MASS, m]
        standing = _excess_acceleration(push, friction, masses[a.MASS, m])
        masses[a.ACCELERATION, m] = sliding if direction != 0.0 else standing
        masses[a.PUSH, m] = push
    _commit_forces(t, 0.0)
    _commit_connections(t.connections)
    if t.settings[0].has_drawbars:
        update_drawbars(masses, t.connections, t.vehicles, t.members, 0.0)


@inner
def largest_residual(masses: Floats) -> float:
    """Largest force residual of the last iterate [N]; NaN if any is."""
    largest = 0.0
    for m in range(masses.shape[1]):
        size = abs(masses[a.RESIDUAL, m])
        if not size <= largest:
            largest = size
    return largest


@inner
def newmark_step(t: Train, h: float, last_resort: bool) -> int:
    """Advance the masses by ``h`` [s] under the brake coefficients ``GAIN`` and ``TRIM``.

    Returns the number of Newton iterations. A step that does not converge returns -1 and leaves
    the state as it was, or takes the last iterate all the same with ``last_resort``.
    """
    masses, joints = t.masses, t.connections
    tolerance = t.settings[0].tolerance
    _outer_forces(t, h)
    _predict(masses, h)
    iterations = 0
    while True:
        coupler_forces(masses, joints, t.hinges, h)
        _friction(masses, t.vehicles, t.members, t.places)
        _push(masses, joints)
        _rows(masses, joints, h)
        if _standing_rows(masses, h) + _open_masses(masses, tolerance) == 0:
            break
        if iterations == MAX_ITERATIONS:
            iterations = -1
            break
        _correct(masses)
        iterations += 1
    if iterations >= 0 or last_resort:
        _commit_forces(t, h)
        _commit_motion(masses, h)
        _commit_connections(joints)
    return iterations
