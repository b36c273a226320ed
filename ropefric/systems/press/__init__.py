"""A belt filter press: tensions, slip and the transient of its drive train."""
