"""The live node: the one part that needs ROS, and adds no physics."""
