"""PX4's cascade and commander: from setpoints and modes to motors."""
