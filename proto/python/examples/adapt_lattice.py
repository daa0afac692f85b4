"""Adapts the lattice to scintillation: uses the coarse lattice while the spots flicker, and the fine one while they do not.
lattice.prepare has prepared both.

    adapt_lattice.py FINE COARSE
"""
import argparse
import time

import numpy as np

from ovws_client import Client, Spots, Subscription

parser = argparse.ArgumentParser(description="uses the coarse lattice while the spots flicker")
parser.add_argument("fine")
parser.add_argument("coarse")
parser.add_argument("--above", type=float, default=0.15, help="scintillation index that asks for the coarse lattice")
parser.add_argument("--below", type=float, default=0.05, help="scintillation index that allows the fine lattice")
parser.add_argument("--window", type=int, default=100, help="number of frames of each scintillation index")
parser.add_argument("--hold", type=float, default=5.0, help="shortest time between two changes, seconds")
parser.add_argument("--switches", type=int, default=0, help="end after so many changes; 0: never")
options = parser.parse_args()


def scintillation_index(peaks):
    """Variance in time of each spot's peak over the square of its mean, the mean over all spots. `peaks`: frames x spots."""
    return float(np.mean(peaks.var(axis=0) / np.maximum(peaks.mean(axis=0), 1.0) ** 2))


with Client() as client, Subscription(Spots, timeout_s=10.0) as stream:
    name = options.fine
    hologram_id = client.lattice_use(name)["hologram_id"]
    peaks, changed_s, switches = [], time.monotonic(), 0
    for frame in stream:
        if frame.hologram_id != hologram_id or not frame.settled:
            continue
        peaks.append(np.nan_to_num(frame.peak_dn))  # a lost spot has no peak
        if len(peaks) < options.window:
            continue
        index, peaks = scintillation_index(np.array(peaks)), []
        wanted = options.coarse if index > options.above else options.fine if index < options.below else name
        if wanted == name or time.monotonic() - changed_s < options.hold:
            continue
        hologram_id = client.lattice_use(wanted)["hologram_id"]
        name, changed_s, switches = wanted, time.monotonic(), switches + 1
        print(f"scintillation index {index:.3f}: lattice {name}", flush=True)
        if switches == options.switches:
            break
