"""MAVLink: bytes to orders, state to bytes, and PX4's manner of speaking."""
