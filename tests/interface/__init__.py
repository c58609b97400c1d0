"""Tests of what modules meet, and of its forms."""
