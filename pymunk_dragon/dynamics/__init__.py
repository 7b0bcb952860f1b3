"""Exact dynamics."""
