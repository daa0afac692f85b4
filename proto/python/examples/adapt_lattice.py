"""Adapts the lattice to scintillation: a coarse lattice while the spots flicker, a fine one while they do not. The fine lattice is
the sensor in use when neither is prepared.

    adapt_lattice.py [SECONDS]
"""
import argparse
import time

import numpy as np

from ovws_client import Client, Spots, Subscription

FINE, COARSE = "fine", "coarse"
parser = argparse.ArgumentParser(description="uses the coarse lattice while the spots flicker")
parser.add_argument("seconds", type=float, nargs="?", default=float("inf"), help="time to run; default: until Ctrl-C")
parser.add_argument("--above", type=float, default=0.15, help="scintillation index that asks for the coarse lattice")
parser.add_argument("--below", type=float, default=0.05, help="scintillation index that allows the fine lattice")
parser.add_argument("--window", type=int, default=100, help="number of frames of each scintillation index")
parser.add_argument("--hold", type=float, default=5.0, help="shortest time between two changes, seconds")
parser.add_argument("--across", type=int, default=3, help="subapertures across the pupil of the coarse lattice")
options = parser.parse_args()


def scintillation_index(peaks):
    """Variance in time of each spot's peak over the square of its mean, the mean over all spots. `peaks`: frames x spots."""
    return float(np.mean(peaks.var(axis=0) / np.maximum(peaks.mean(axis=0), 1.0) ** 2))


with Client() as client, Subscription(Spots, timeout_s=10.0) as stream:
    if not {FINE, COARSE} <= {one["name"] for one in client.lattice_list()["lattices"]}:
        client.lattice_prepare([{"name": FINE}, {"name": COARSE, "sensor": {"subapertures_across": options.across}}]).wait()
    name = FINE
    hologram_id = client.lattice_use(name)["hologram_id"]
    peaks, begun_s = [], time.monotonic()
    changed_s = begun_s - options.hold
    for frame in stream:
        if time.monotonic() - begun_s > options.seconds:
            break
        if frame.hologram_id != hologram_id or not frame.settled:
            continue
        peaks.append(np.nan_to_num(frame.peak_dn))  # a lost spot has no peak
        if len(peaks) < options.window:
            continue
        index, peaks = scintillation_index(np.array(peaks)), []
        wanted = COARSE if index > options.above else FINE if index < options.below else name
        if wanted == name or time.monotonic() - changed_s < options.hold:
            continue
        hologram_id = client.lattice_use(wanted)["hologram_id"]
        name, changed_s = wanted, time.monotonic()
        print(f"scintillation index {index:.3f}: lattice {name}", flush=True)
