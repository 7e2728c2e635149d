"""What the vehicle believes: an error-state Kalman filter, filterpy's or its twin in kernels."""
