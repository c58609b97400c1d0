"""Ticks to a file and back: the MCAP recording and its exports."""
