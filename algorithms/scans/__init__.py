"""Scans of lidars: levelled, matched, searched, and the maps they form."""
