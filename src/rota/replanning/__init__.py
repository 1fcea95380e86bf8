"""From a plan that is being driven to one for the robots that remain and the mission as it is now."""
