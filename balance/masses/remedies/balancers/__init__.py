"""Balancers on the base: wheels and moving bodies, driven by motors, gears or cams."""
