"""The page in the browser: a thin client of `dressing_sim.episode`.

What a session holds and does is in plain Python, without a browser: `choices`, `live`, `lessons`,
`session`, `past`. What is drawn, and what can be pressed, is in `stage`, the panels and `app`.
"""
