import numpy as np
import pytest

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import add_white_noise, noise_deviation

PATH = np.stack([np.sin(np.linspace(0, 6, 5000)), np.cos(np.linspace(0, 6, 5000))], axis=1)


@pytest.mark.parametrize("reference", ["centred", "world"])
def test_the_ratio_is_met(reference):
    shifted = PATH + 3.0
    noisy = add_white_noise(shifted, 20.0, np.random.default_rng(0), reference)
    signal = shifted - shifted.mean(axis=0) if reference == "centred" else shifted
    ratio = 10 * np.log10((signal**2).mean() / ((noisy - shifted) ** 2).mean())
    assert ratio == pytest.approx(20.0, abs=0.2)


def test_only_the_centred_reference_ignores_where_the_world_is():
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    moved = PATH @ turn.T + 10
    assert noise_deviation(moved, 30, "centred") == pytest.approx(
        noise_deviation(PATH, 30, "centred")
    )
    assert noise_deviation(moved, 30, "world") > 5 * noise_deviation(PATH, 30, "world")


def test_infinite_ratio_is_no_noise_and_a_seed_repeats():
    rng = np.random.default_rng
    np.testing.assert_array_equal(add_white_noise(PATH, np.inf, rng(0)), PATH)
    np.testing.assert_array_equal(
        add_white_noise(PATH, 30, rng(4)), add_white_noise(PATH, 30, rng(4))
    )


def test_unusable_settings_are_errors():
    with pytest.raises(InvalidInputError, match="centred"):
        noise_deviation(PATH, 30, "origin")
    with pytest.raises(InvalidInputError, match="decibels"):
        noise_deviation(PATH, np.nan, "world")


@pytest.mark.parametrize(
    ("snr_db", "share"), [(0.0, 1.0), (20.0, 0.1), (-20.0, 10.0), (30.0, 10**-1.5)]
)
def test_twenty_decibels_are_a_tenth_of_the_amplitude(snr_db, share):
    path = np.array([[3.0, 0.0], [0.0, 4.0]])
    assert noise_deviation(path, snr_db, "world") == pytest.approx(share * 2.5)
    assert noise_deviation(path, snr_db, "centred") == pytest.approx(share * 1.25 * np.sqrt(2))
