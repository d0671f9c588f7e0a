"""The TurtleBot over ROS: a simulated robot as a node, and an environment that drives it or a real one.

Reads in the order errors, odometry, simulated, ros, watch, node, driver, collect. Nothing here needs
ROS before it is used, and no other module needs anything here.
"""
