"""Demonstrations from elsewhere and for elsewhere: recordings of a lab, data sets of others."""
