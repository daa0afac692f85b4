"""Records two seconds and prints statistics of the file. Needs h5py (python3-h5py), and the daemon on this machine."""
import time

from ovws_client import Client
from ovws_client.recording import Recording

with Client(timeout_s=30.0) as client:
    path = client.record_start(limit_s=10.0)["file"]
    time.sleep(2.0)
    client.record_stop()

with Recording(path) as run:
    good = run.frames["valid"] == 1
    print(len(run.frames), "frames,", good.sum(), "valid,", run.summary["frames_dropped"], "dropped, in", path)
    for j, mean, deviation in zip(run.modes(0), run.coefficients()[good].mean(axis=0), run.coefficients()[good].std(axis=0)):
        print(f"j = {j}: {mean:+.4f} waves, {deviation:.4f} RMS")
