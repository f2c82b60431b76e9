"""The commands of ``dressing-sim``, a module each; every one has ``--help`` with an example.

Simulation and robotics libraries are imported inside the commands: --help and errors in the
arguments should not wait for them.
"""
