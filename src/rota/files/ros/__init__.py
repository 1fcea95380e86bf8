"""What ROS reads: names, poses, grids, and bags of both generations. Places are in the mission's metres, frame map."""
