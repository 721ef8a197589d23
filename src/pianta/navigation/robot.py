"""The robot for which ways are found."""

# Radius of a robot, metres: the default of Nav2's costmaps.
ROBOT_RADIUS = 0.22
