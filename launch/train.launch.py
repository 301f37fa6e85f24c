"""Start the live train: ros2 launch haul_ros train.launch.py scenario:=daqin_4x5000."""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

NODE_PARAMETERS = {
    "scenario": (str, "name of a shipped scenario, or path of a scenario file"),
    "real_time_factor": (float, "1 real time, 0 as fast as possible"),
    "record_path": (str, "file to record to; none: no recording"),
    "record_compression": (str, "compression of the recording: zstd, lz4 or none"),
    "publish_clock": (bool, "publish the simulation time on /clock"),
    "use_sim_time": (bool, "let the node's logger and clock follow /clock; the train makes its time itself"),
}


def bag_recorder(context: LaunchContext) -> list[ExecuteProcess]:
    """Where a folder for it is given, ``ros2 bag record`` of the train's topics, beside the node's own recording."""
    folder = LaunchConfiguration("bag").perform(context)
    if not folder:
        return []
    parts = (LaunchConfiguration(name).perform(context).strip("/") for name in ("namespace", "node_name"))
    topics = f"^/{'/'.join(filter(None, parts))}/|^/diagnostics$|^/clock$"
    command = ["ros2", "bag", "record", "--storage", "mcap", "--output", folder, "--regex", topics]
    return [ExecuteProcess(cmd=command, name="bag", output="screen")]


def train_node(context: LaunchContext) -> list[Node]:
    """The node with the parameter file, and on top of it the arguments that were given."""
    given = {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, (kind, _) in NODE_PARAMETERS.items()
        if LaunchConfiguration(name).perform(context)
    }
    return [
        Node(
            package="haul_ros",
            executable="train_node",
            name=LaunchConfiguration("node_name"),
            namespace=LaunchConfiguration("namespace"),
            output="screen",
            parameters=[LaunchConfiguration("params_file"), *([given] if given else [])],
            ros_arguments=["--log-level", LaunchConfiguration("log_level")],
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Arguments, recorder and node."""
    params_file = PathJoinSubstitution([FindPackageShare("haul_ros"), "config", "train_node.yaml"])
    arguments = [
        DeclareLaunchArgument("namespace", default_value="", description="namespace of the node"),
        DeclareLaunchArgument("node_name", default_value="haul", description="name of the node"),
        DeclareLaunchArgument("params_file", default_value=params_file, description="parameters of the node, YAML"),
        DeclareLaunchArgument("log_level", default_value="info", description="debug, info, warn, error or fatal"),
        DeclareLaunchArgument(
            "bag", default_value="", description="new folder for ros2 bag record of the train's topics; empty: none"
        ),
        *(
            DeclareLaunchArgument(name, default_value="", description=f"{text}; empty: as in params_file")
            for name, (_, text) in NODE_PARAMETERS.items()
        ),
    ]
    # The recorder first: it finds topics as they appear, and nothing of a run is earlier than its latched state
    return LaunchDescription([*arguments, OpaqueFunction(function=bag_recorder), OpaqueFunction(function=train_node)])
