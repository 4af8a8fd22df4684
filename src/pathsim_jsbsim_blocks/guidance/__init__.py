"""Autopilot, climbs and descents with the stall protection, courses, approach and landing."""
