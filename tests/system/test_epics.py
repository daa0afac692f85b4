"""The EPICS PV Access server with a real PV Access client, where p4p can be imported (it is not in Debian)."""
import time
import unittest

from bridge_case import BridgeCase, environment, has
from case import main, wait_for

import numpy as np

WITHOUT = "p4p cannot be imported: it is not in Debian 12, and this test needs its server and client"


@unittest.skipUnless(has("p4p"), WITHOUT)
class Server(BridgeCase):
    def start(self):
        super().start()
        import os

        from p4p.client.thread import Context
        os.environ.update(environment())  # PV Access stays on this machine
        self.start_bridge("epics", ready="serving")
        self.context = Context("pva")
        self.addCleanup(self.context.close)
        wait_for(lambda: self.get("rms_waves").severity == 0, what="a valid frame")

    def get(self, name):
        return self.context.get(f"OVWS:{name}")

    def refused_with(self, name, value):
        from p4p.client.thread import RemoteError
        with self.assertRaises(RemoteError) as caught:
            self.context.put(f"OVWS:{name}", value)
        return str(caught.exception)

    def test_frames_images_and_settings(self):
        self.context.put("OVWS:aberration", [0.0, 0.0, 0.0, 0.1])
        wait_for(lambda: abs(self.get("coefficients")[3] - 0.1) < 0.005, what="the aberration")
        coefficients, rms = self.get("coefficients"), self.get("rms_waves")
        self.assertEqual((coefficients.raw.getID(), len(coefficients)), ("epics:nt/NTScalarArray:1.0", len(self.get("j"))))
        self.assertEqual((rms.raw.display.units, rms.raw.display.description), ("wave", self.schema("wavefront")["properties"]["rms_waves"]["description"]))
        self.assertAlmostEqual(rms.timestamp, time.time(), delta=5.0)
        wait_for(lambda: self.get("image").shape == (512, 512), what="an image")
        image, phase = self.get("image"), self.get("phase")
        self.assertEqual((image.dtype, phase.shape, image.raw.getID()), (np.uint8, (128, 128), "epics:nt/NTNDArray:1.0"))
        self.assertGreater(image.max(), 20)
        self.context.put("OVWS:exposure_us", 1500.0)
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], 1500.0)
        limits = self.get("exposure_us").raw.control
        self.assertEqual((limits.limitLow, limits.limitHigh), tuple(self.schema("camera.set")["properties"]["exposure_us"][key] for key in ("minimum", "maximum")))

    def test_refusals_and_alarms(self):
        self.assertIn("exposure_us: must be a number from 0.1", self.refused_with("exposure_us", 1e9))
        self.assertIn("outside the camera's range", self.refused_with("gain_db", 90.0))
        self.refused_with("rms_waves", 1.0)
        self.call("reference.clear")
        wait_for(lambda: self.get("rms_waves").severity == 3, what="the alarm of a frame that is not valid")
        self.assertFalse(self.get("valid"))
        self.assertEqual(self.get("frame_id").severity, 0)

    def test_it_outlives_the_daemon(self):
        self.bench.stop("ovwsd")
        for name in ("frame_id", "rms_waves", "image", "exposure_us"):
            alarm = wait_for(lambda name=name: (value := self.get(name)).severity == 3 and value.raw.alarm, what=f"the alarm of {name}")
            self.assertIn("does not answer", alarm.message)
        self.assertIn("no answer", self.refused_with("exposure_us", 700.0))
        self.restart_daemon()
        wait_for(lambda: self.get("rms_waves").severity == 0, what="valid frames")
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], 2000.0)

    def test_every_frame_is_monitored(self):
        seen = []
        monitor = self.context.monitor("OVWS:seq", lambda value: seen.append(int(value)), request="record[queueSize=100]")
        wait_for(lambda: len(seen) > 150, what="150 frames")
        monitor.close()
        self.assertEqual(set(np.diff(seen)), {1})


if __name__ == "__main__":
    main()
