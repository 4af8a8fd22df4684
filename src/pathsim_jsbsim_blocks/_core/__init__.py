"""What the other folders share: checks of arguments, ports by name, sampling at a period."""
