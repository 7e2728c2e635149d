"""The body and the world around it: what really happens."""
