"""Changes of wheels from their window table: change points, class, alarm and forecast."""
