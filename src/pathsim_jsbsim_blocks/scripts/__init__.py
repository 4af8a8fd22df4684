"""Diagram scripts: loaded, built with other values, and run to their first run or their end."""
