"""The planners: from a Mission to a Plan."""
