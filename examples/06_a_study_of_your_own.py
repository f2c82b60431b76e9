"""A study of your own: at which friction between skin and cloth does the operator fail?

python examples/06_a_study_of_your_own.py [--suite random:5] [--frictions 0.2 0.5 1.0]

Everything about the world is in a frozen `EpisodeConfig`; a study is a loop over such configs.
Choose on random suites or on val50, never on the test suites.
"""

import argparse
from dataclasses import replace

from dressing_sim import EpisodeConfig, Operator, dress, load_suite


def with_friction(friction: float) -> EpisodeConfig:
    """The nominal world, but for the sliding friction of cloth on skin."""
    config = EpisodeConfig()
    garment = config.world.sleeve.garment
    garment = replace(garment, fabric=replace(garment.fabric, friction=friction))
    sleeve = replace(config.world.sleeve, garment=garment)
    return replace(config, world=replace(config.world, sleeve=sleeve))


def main() -> None:
    """Dress every arm at every friction, and print a line for each friction."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--suite", default="random:3")
    parser.add_argument("--frictions", type=float, nargs="+", default=[0.2, 0.45, 1.0])
    args = parser.parse_args()
    postures = load_suite(args.suite)
    for friction in args.frictions:
        outcomes = [dress(Operator(), arm, 0, with_friction(friction)) for arm in postures]
        # An episode whose simulation cannot be trusted counts neither way.
        valid = [one for one in outcomes if one.invalid is None]
        dressed = sum(one.success for one in valid)
        pull = max((one.metrics["grip_force"] for one in valid), default=float("nan"))
        print(
            f"friction {friction:g}: dressed {dressed} of {len(valid)}, "
            f"the largest pull was {pull:.1f} N",
            flush=True,
        )


if __name__ == "__main__":
    main()
