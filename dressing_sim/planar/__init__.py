"""The paper's two-dimensional study: from a start box to a goal box, out of one U and into another.

``command.planar`` is what ``dressing-sim planar`` runs; ``python -m dressing_sim.planar`` is the
same.
"""
