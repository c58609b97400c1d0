"""A pole on a cart is that of the textbook, and its two equilibria are told apart."""

import numpy as np

import mjsim
from mjsim.lab import ScenePlant

G = 9.81


def test_a_cart_pole_is_that_of_the_textbook():
    world = mjsim.load_world("lab-6-cart")
    upright, hanging = (ScenePlant(world, plant) for plant in world.plants)
    body = upright.model.body("cart/pole")
    cart, m, half = 1.0, float(body.mass[0]), 0.5
    inertia = float(np.median(body.inertia))  # across a thin rod
    det = (cart + m) * (inertia + m * half**2) - (m * half) ** 2
    falls = m * G * half * (cart + m) / det
    back = (m * half) ** 2 * G / det
    A = [[0, 0, 1, 0], [0, 0, 0, 1], [0, -back, 0, 0], [0, falls, 0, 0]]
    B = [[0], [0], [(inertia + m * half**2) / det], [-m * half / det]]
    found = upright.linear
    assert found.states == ("x", "q", "x.rate", "q.rate")
    np.testing.assert_allclose(found.A, A, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(found.B, B, rtol=1e-7)
    poles = np.linalg.eigvals(hanging.linear.A)
    assert np.abs(poles.real).max() < 1e-5
    np.testing.assert_allclose(np.abs(poles.imag).max() ** 2, falls, rtol=1e-7)
