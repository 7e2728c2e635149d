"""When to be there: limits, the fastest time law under them, and the trajectory that they make."""
