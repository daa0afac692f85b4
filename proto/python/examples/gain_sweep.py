"""Noise of the modes over camera gain: the exposure is lowered as the gain rises, so that the spots keep their brightness."""
from ovws_client import Client

with Client() as client:
    before = client.camera_get()["settings"]
    for rise_db in (0.0, 6.0, 12.0):
        with client.settings(gain_db=before["gain_db"] + rise_db, exposure_us=before["exposure_us"] / 10 ** (rise_db / 20)) as applied:
            noise_waves = client.wavefront(frames=100).scatter_waves.mean()
        print(f"{applied['gain_db']:4.1f} dB, {applied['exposure_us']:6.0f} us: {1e3 * noise_waves:.3f} milliwaves RMS a mode")
