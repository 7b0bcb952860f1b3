"""The exact model: dragons, curves, speeds, marches, and the runs that are played of them."""
