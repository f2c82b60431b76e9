"""What the paper prints for this study: Zhu, Gienger and Kober (2022), Table I."""

INITIAL_TRAINING_COST = 2.17
INITIAL_VALIDATION_COST = 2.11

# (selection, method) -> training cost, validation cost; the best of 20 runs.
TABLE = {
    ("original", "noise"): (1.97, 2.50),
    ("original", "rf"): (2.08, 1.85),
    ("original", "rf+noise"): (2.04, 1.84),
    ("generalisation", "noise"): (2.21, 1.48),
    ("generalisation", "rf"): (2.41, 1.79),
    ("generalisation", "rf+noise"): (2.17, 1.82),
}
