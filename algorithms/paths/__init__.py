"""Paths: searched, sampled, smooth, and how a base follows them."""
