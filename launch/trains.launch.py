"""Start several trains: ros2 launch haul_ros trains.launch.py trains:=train_a=daqin_1_2_1,train_b=daqin_4x5000."""

from datetime import UTC, datetime

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, ThisLaunchFileDir


def namespaces(trains: str) -> dict[str, str]:
    """Scenario of each namespace in ``train_a=daqin_1_2_1,train_b=...``; RuntimeError if one is none, or twice."""
    entries = (entry.partition("=") for entry in trains.split(","))
    pairs = [(namespace.strip(), scenario.strip()) for namespace, _, scenario in entries]
    if not all(all(pair) for pair in pairs) or len({namespace for namespace, _ in pairs}) != len(pairs):
        raise RuntimeError(f"trains:={trains}: expected NAMESPACE=SCENARIO,NAMESPACE=SCENARIO ..., each namespace once")
    return dict(pairs)


def one_by_one(context: LaunchContext) -> list[IncludeLaunchDescription]:
    """train.launch.py for each, with a recording that is named after its namespace."""
    now = datetime.now(UTC)
    record = LaunchConfiguration("record").perform(context).lower() in ("true", "1")
    train = PythonLaunchDescriptionSource(PathJoinSubstitution([ThisLaunchFileDir(), "train.launch.py"]))
    return [
        IncludeLaunchDescription(
            train,
            launch_arguments={
                "namespace": namespace,
                "scenario": scenario,
                "record_path": f"{namespace.replace('/', '_')}_{now:%Y%m%dT%H%M%SZ}.mcap" if record else "none",
                "log_level": LaunchConfiguration("log_level"),
            }.items(),
        )
        for namespace, scenario in namespaces(LaunchConfiguration("trains").perform(context)).items()
    ]


def generate_launch_description() -> LaunchDescription:
    """Arguments and trains."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "trains", description="NAMESPACE=SCENARIO,NAMESPACE=SCENARIO ...: a train for each, /NAMESPACE/haul"
            ),
            DeclareLaunchArgument("record", default_value="true", description="record each to NAMESPACE_TIME.mcap"),
            DeclareLaunchArgument("log_level", default_value="info", description="debug, info, warn, error or fatal"),
            OpaqueFunction(function=one_by_one),
        ]
    )
