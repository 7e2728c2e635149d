"""What stands there: maps become a grid of solid boxes; slices, outlines and parts of it."""
