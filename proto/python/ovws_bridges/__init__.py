"""Bridges of ovwsd to other frameworks: Bluesky, Tango, EPICS. Each module needs its framework only, and the daemon knows none of them."""
