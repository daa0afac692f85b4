"""Recording at high rates: no frame is missing in the file, and the pipeline is not slowed down.

    OVWS_RECORD_S=60 OVWS_RECORD_HZ=500   seconds of recording, and frames/s; from 60 s on the latency is checked too
"""
import os
import time

from case import BenchCase, main
from ovws_client.recording import Recording

SECONDS = float(os.environ.get("OVWS_RECORD_S", "4"))
RATE_HZ = float(os.environ.get("OVWS_RECORD_HZ", "200"))
PARTS = 2  # alternate with and without recording, so that other load affects both
LOST = ("frames_lost", "frames_incomplete", "frames_dropped", "messages_dropped")


class RecordRate(BenchCase):
    daemon_config = {"camera": {"frame_rate_hz": RATE_HZ, "exposure_us": min(2000.0, 0.95e6 / RATE_HZ)},
                     "record": {"directory": "recordings"}, "stream": {"image_rate_hz": 0}}
    twin_config = {"noise": "pool", "light": {"peak_electrons": 6000}}

    def watch(self, stream, seconds):
        """Latencies of the frames within `seconds`, us, and the increase of the loss counters."""
        while stream.next(0.001):
            pass
        before = self.call("system.status")["counters"]
        end, latencies_us = time.monotonic() + seconds, []
        while time.monotonic() < end:
            message = stream.next(2.0)
            self.assertIsNotNone(message, "the stream stopped")
            latencies_us.append(message["latency_us"])
        after = self.call("system.status")["counters"]
        return latencies_us, {name: after[name] - before[name] for name in LOST}

    def test_nothing_is_lost_and_nobody_waits(self):
        self.take_reference(50)
        stream = self.stream("wavefront")
        self.settled_frames(stream, 1)
        with_us, without_us, recorded, raw = [], [], 0, 0
        for part in range(PARTS):
            alone_us, _ = self.watch(stream, SECONDS / PARTS)
            without_us += alone_us
            self.call("record.start", {"name": f"part-{part}"})
            beside_us, lost = self.watch(stream, SECONDS / PARTS)
            with_us += beside_us
            report = self.call("record.stop")
            self.assertEqual((report["frames_dropped"], report["pictures_dropped"]), (0, 0), report)
            path = self.bench.directory / "recordings" / f"part-{part}.h5"
            with Recording(path) as run:
                self.assertEqual(run.frames["dropped_before"].sum(), 0)
                self.assertTrue((run.frames["picture"] >= 0).all())
                self.assertEqual(int(run.frames["gap"][1:].sum()), int(run.frames["frame_id"][-1] - run.frames["frame_id"][0]) + 1 - len(run.frames))
                recorded += len(run.frames)
            raw += report["bytes"]
            path.unlink()
            self.assertEqual((lost["frames_dropped"], lost["messages_dropped"]), (0, 0), lost)
        p50, p99 = ([sorted(all_us)[int(q * (len(all_us) - 1))] for all_us in (without_us, with_us)] for q in (0.5, 0.99))
        print(f"\n  {recorded} frames recorded ({recorded / SECONDS:.0f}/s, {raw / SECONDS / 2**20:.0f} MiB/s), none lacking; arrival to message without and with:"
              f" p50 {p50[0]:.0f} and {p50[1]:.0f} us, p99 {p99[0]:.0f} and {p99[1]:.0f} us")
        if SECONDS >= 60.0:
            self.assertLessEqual(p99[1], 1.1 * p99[0])


if __name__ == "__main__":
    main()
