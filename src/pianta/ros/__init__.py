"""For robots that are running: maps from topics, without ROS installed, and what a ROS node asks of a floor."""
