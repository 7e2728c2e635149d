"""Is it seen, is it safe: the camera, the clearance and the certificate."""
