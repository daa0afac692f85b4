"""200 frames/s of 512 x 512 Mono8: none lost, every vortex found in every frame. 50 frames/s through the bridges: no event lost.

    OVWS_RATE_FRAMES=12000   number of frames

The rate itself and the latency are measured by tests/bench/latency.
"""
import json
import os
import subprocess
import sys
import unittest

from bridge_case import RUN, environment, reports
from case import PATIENCE_S, PROGRAM_PATIENCE_S, BenchCase, main

RATE_HZ = 200
FRAMES = int(os.environ.get("OVWS_RATE_FRAMES", "1200"))


class Rate(BenchCase):
    daemon_config = {"camera": {"frame_rate_hz": RATE_HZ}}

    def not_sent(self):
        """Number of frames that the twin left out, because the machine was too busy to make them in time."""
        return self.twin.call("twin.get")["frames"]["late"]

    def test_no_frame_is_lost(self):
        self.take_reference(100)
        not_sent = -self.not_sent()
        stream = self.stream("wavefront")
        last = self.settled_frames(stream, 1)[0]
        before = self.call("system.status")["counters"]
        all_tracked = lost = 0
        for _ in range(FRAMES):
            message = stream.next(PATIENCE_S)
            self.assertIsNotNone(message, "the stream stopped")
            self.assertEqual(message["seq"], last["seq"] + 1)
            lost += message["gap"]
            all_tracked += message["tracked"] == 19 and message["valid"]
            last = message
        after = self.call("system.status")["counters"]
        not_sent += self.not_sent()
        changed = {k: after[k] - before[k] for k in after if after[k] != before[k]}
        print(f"\n{FRAMES} frames, {not_sent} not sent, {lost} lost, 19 of 19 valid in {all_tracked}; counters that moved: {changed}")
        self.assertLessEqual(lost, not_sent)
        self.assertLessEqual(changed.get("frames_lost", 0), not_sent)
        for counter in ("frames_incomplete", "frames_dropped", "frames_unexpected", "spots_lost", "messages_dropped"):
            self.assertEqual(changed.get(counter, 0), 0, counter)
        # Frames delayed by a busy machine are counted as late and not tracked as current.
        self.assertGreaterEqual(all_tracked, FRAMES - changed.get("frames_late", 0))


class Bridges(unittest.TestCase):
    def test_events_at_50_per_second_without_loss_or_growth(self):
        done = subprocess.run([sys.executable, RUN, "20"], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, env=environment())
        print(done.stdout, done.stderr)
        self.assertEqual(done.returncode, 0)
        for report in reports(done.stdout)[:2]:
            self.assertEqual(report["missing"], 0, json.dumps(report))


if __name__ == "__main__":
    main()
