"""What the vehicle believes: an error-state Kalman filter on filterpy."""
