"""Fits the spots' displacements in a custom basis: here powers of x and y over the pupil, in units of its radius."""
import numpy as np

from ovws_client import Client, Spots, Subscription, px_per_slope, subaperture_centres

POWERS = [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]

with Client() as client, Subscription(Spots, timeout_s=5.0) as stream:
    config = client.config_get()
    x, y = subaperture_centres(config).T
    spots = next(spots for spots in stream if spots.valid)
    px = px_per_slope(config, client.registration_get())

slopes = [[a * x ** max(a - 1, 0) * y**b, b * x**a * y ** max(b - 1, 0)] for a, b in POWERS]  # d/dx, d/dy at the centres
model_px = np.einsum("kl,bls->skb", px, slopes)  # displacements for one wave of each function: spot, axis, function
found = np.isfinite(spots.displacements_px).all(axis=1)
waves, *_ = np.linalg.lstsq(model_px[found].reshape(-1, len(POWERS)), spots.displacements_px[found].ravel(), rcond=None)
for (a, b), value in zip(POWERS, waves):
    print(f"x^{a} y^{b}: {value:+.4f} waves")
