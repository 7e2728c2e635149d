"""The link: a planned trajectory, streamed to a vehicle and logged."""
