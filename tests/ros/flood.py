"""``python -m tests.ros.flood TOPIC ...`` publishes demands to topics as fast as it can."""

from __future__ import annotations

import itertools
import sys
from time import sleep

import rclpy
from std_msgs.msg import Float64

from haul_ros.messages.cdr import encode_float64


def main() -> None:
    """Until it is killed."""
    rclpy.init()
    node = rclpy.create_node("flood", start_parameter_services=False)
    publishers = [node.create_publisher(Float64, topic, 10) for topic in sys.argv[1:]]
    while not all(publisher.get_subscription_count() for publisher in publishers):
        sleep(0.01)
    print("found", flush=True)
    for number in itertools.count():
        for publisher in publishers:
            publisher.publish(encode_float64((number % 10) / 10))


if __name__ == "__main__":
    main()
