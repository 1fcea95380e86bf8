"""ROS 2 by rclpy: a plan played on topics. Nothing here is loaded unless ROS 2 is asked for."""
