"""Sines and cosines from the table of whole degrees, and of all other angles."""

import math

import numpy as np

from cprm_gym.envs.kernels.bearings import SINGLE, bearing, bearing_within, turned


def test_whole_degrees_and_other_angles_have_their_sines():
    angles = [math.radians(d) for d in range(-400, 401)] + np.random.default_rng(1).uniform(-7.0, 7.0, 500).tolist()
    for angle in angles:
        np.testing.assert_allclose(bearing(angle), (math.cos(angle), math.sin(angle)), rtol=0, atol=1e-14)
        np.testing.assert_allclose(turned(0.6, 0.8, angle), np.array([[0.6, -0.8], [0.8, 0.6]]) @ bearing(angle), rtol=0, atol=1e-15)


def test_an_angle_of_single_precision_stands_for_whole_degrees_and_others_lose_less_than_it_shows():
    for degrees in range(-180, 181):
        told = float(np.float32(math.radians(degrees)))
        assert bearing_within(told, SINGLE) == bearing(math.radians(degrees))
        beside = math.radians(degrees + 2.9e-5)
        np.testing.assert_allclose(bearing_within(beside, SINGLE), (math.cos(beside), math.sin(beside)), rtol=0, atol=6e-7)
