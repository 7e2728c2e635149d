"""Files: QGroundControl plans, waypoints, tables, KML."""
