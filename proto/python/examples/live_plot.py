"""Live plot of the wavefront's modes for a number of frames (live_plot.py 500): a matplotlib window, or text bars without matplotlib."""
import sys

from ovws_client import Subscription, Wavefront

try:
    import matplotlib.pyplot as plot
except ImportError:
    plot = None

with Subscription(Wavefront, timeout_s=5.0) as stream:
    for _ in range(int(sys.argv[1]) if len(sys.argv) > 1 else 1000):
        frame = stream.newest(timeout_s=5.0) or next(stream)
        if plot is not None:
            plot.cla()
            plot.bar(frame.j, frame.coefficients_waves)
            plot.xlabel("OSA/ANSI index j")
            plot.ylabel("waves RMS")
            plot.pause(0.05)
        elif frame.valid:
            print(f"frame {frame.frame_id}: {frame.rms_waves:.4f} waves RMS")
            for j, waves in zip(frame.j, frame.coefficients_waves):
                print(f"  j = {j:3d} {waves:+8.4f} {'#' * round(40 * abs(waves))}")
