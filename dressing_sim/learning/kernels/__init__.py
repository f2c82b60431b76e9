"""Compiled loops (numba), imported on first use only: numba takes longer to import than numpy.

Everything here works on plain arrays and checks nothing; the modules one level up check, document
and call it.
"""
