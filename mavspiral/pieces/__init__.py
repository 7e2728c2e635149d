"""What is flown along: round towers, inside courts, along façades, above roofs, and past what those leave unseen."""
