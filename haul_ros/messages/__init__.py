"""Messages of a train: its topics, their CDR bytes, and what is said on them. No ROS needed, and no files."""
