"""Recording and playback: messages as CDR bytes, MCAP files written beside the loop and read back. No ROS needed."""
