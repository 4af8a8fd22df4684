"""Shared by all folders: checks of arguments, ports by name, sampling at a period."""
