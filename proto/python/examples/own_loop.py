"""A custom closed loop: an integrator that drives the wavefront to that of the reference, one step per hologram."""
import numpy as np

from ovws_client import Client, Subscription, Wavefront

GAIN = 0.5

with Client() as client, Subscription(Wavefront, timeout_s=5.0) as stream:
    hologram_id, correction_waves = client.correction_clear()["hologram_id"], 0.0
    for step in range(12):
        frame = next(frame for frame in stream if frame.valid and frame.hologram_id == hologram_id)
        residual_waves = np.sqrt(np.sum(frame.coefficients_waves**2))
        print(f"step {step}: residual {residual_waves:.4f} waves RMS, tilts included")
        correction_waves = correction_waves + GAIN * frame.coefficients_waves
        hologram_id = client.correction_set(dict(zip(frame.j.tolist(), correction_waves.tolist())))["hologram_id"]
