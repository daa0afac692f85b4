"""Noise of the modes over camera gain: the exposure is lowered as the gain rises, so that the spots keep their brightness."""
from itertools import islice

import numpy as np

from ovws_client import Client, Subscription, Wavefront

with Client() as client, Subscription(Wavefront, timeout_s=5.0) as stream:
    before = client.camera_get()["settings"]
    for rise_db in (0.0, 6.0, 12.0):
        exposure_us = before["exposure_us"] / 10 ** (rise_db / 20)
        applied = client.camera_set(gain_db=before["gain_db"] + rise_db, exposure_us=exposure_us)["applied"]
        frames = (frame for frame in stream if frame.valid and frame.gain_db == applied["gain_db"])
        waves = np.array([frame.coefficients_waves for frame in islice(frames, 100)])
        print(f"{applied['gain_db']:4.1f} dB, {applied['exposure_us']:6.0f} us: {1e3 * waves.std(axis=0).mean():.3f} milliwaves RMS a mode")
    client.camera_set(gain_db=before["gain_db"], exposure_us=before["exposure_us"])
