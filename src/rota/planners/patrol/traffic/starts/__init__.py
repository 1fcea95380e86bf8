"""From where robots start to their loops."""
