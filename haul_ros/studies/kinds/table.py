"""The kinds of studies by name, as the schema of study files lists them."""

from __future__ import annotations

from collections.abc import Mapping

from haul_ros.studies.kinds.along_train import DISTRIBUTION, VALIDATION
from haul_ros.studies.kinds.beside import COMPARISON, SWEEP
from haul_ros.studies.kinds.kind import Kind
from haul_ros.studies.kinds.map import MAP
from haul_ros.studies.kinds.rigid_arm_map import RIGID_ARM_MAP
from haul_ros.studies.kinds.rigid_arms import RIGID_ARMS
from haul_ros.studies.kinds.series import INITIAL_SPEED, STIFFNESS, SYNCHRONISATION
from haul_ros.studies.kinds.vibration import VIBRATION

KINDS: Mapping[str, Kind] = {
    "sweep": SWEEP,
    "comparison": COMPARISON,
    "validation": VALIDATION,
    "distribution": DISTRIBUTION,
    "initial_speed": INITIAL_SPEED,
    "synchronisation": SYNCHRONISATION,
    "stiffness": STIFFNESS,
    "rigid_arms": RIGID_ARMS,
    "rigid_arm_map": RIGID_ARM_MAP,
    "vibration": VIBRATION,
    "map": MAP,
}
