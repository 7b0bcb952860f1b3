"""What the package's web pages share: parts of HTML, scripts, styles, and frames of live pages.

`html` has functions for any page, `markup` those for texts with formulas, `page` the common parts
of player and live page, and `frames` the data that a live page draws. Scripts, styles and parts of
HTML are files in `assets`.
"""
