"""The EPICS PV Access server with a real PV Access client, where p4p can be imported (it is not in Debian); otherwise its PVs by a stand-in."""
import io
import signal
import sys
import time
import unittest
from contextlib import redirect_stderr
from unittest.mock import patch

from bridge_case import BridgeCase, environment, has
from case import main, wait_for

import numpy as np

WITHOUT = "p4p cannot be imported: it is not in Debian 12, and this test needs its server and client; a stand-in shows what is posted"


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
        wait_for(lambda: not self.get("valid"), what="the value of a frame that is not valid")
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


@unittest.skipIf(has("p4p"), "p4p can be imported: the real server is tested instead")
class Posted(BridgeCase):
    """What the bridge posts to its PVs. Not shown without p4p: types, display and transport on the wire."""

    def start(self):
        super().start()
        import p4p_stand_in
        p4p_stand_in.install()
        from ovws_bridges.epics import Bridge
        self.operation = p4p_stand_in.Operation
        self.bridge = Bridge("TEST:")
        self.addCleanup(self.bridge.close)
        self.expect("rms_waves", 0)

    def pv(self, name):
        return self.bridge.pvs[f"TEST:{name}"]

    def expect(self, name, severity):
        return wait_for(lambda: self.pv(name).severity == severity and self.pv(name), what=f"{name} with severity {severity}")

    def put(self, name, value):
        operation = self.operation(value)
        self.pv(name).handler.put(self.pv(name), operation)
        self.assertTrue(operation.ended)
        return operation.error

    def test_a_wrong_endpoint_is_named(self):
        from ovws_bridges import epics
        self.addCleanup(signal.pthread_sigmask, signal.SIG_SETMASK, signal.pthread_sigmask(signal.SIG_BLOCK, ()))
        said = io.StringIO()
        with patch.object(sys, "argv", ["epics", "--control", "127.0.0.1:7702"]), redirect_stderr(said), self.assertRaises(SystemExit):
            epics.main()
        self.assertIn("scheme tcp:// is missing", said.getvalue())

    def test_values_alarms_and_a_lost_daemon(self):
        self.assertIsNone(self.put("aberration", np.array([0.0, 0.0, 0.0, 0.1])))
        wait_for(lambda: abs(self.pv("coefficients").value[3] - 0.1) < 0.005, what="the aberration")
        wait_for(lambda: self.pv("aberration").value[3:4] == [0.1], what="the setting in use")
        wait_for(lambda: self.pv("image").value.shape == (512, 512) and self.pv("phase").value.shape == (128, 128), what="an image and a wavefront map")
        self.assertAlmostEqual(self.pv("frame_id").stamp, time.time(), delta=5.0)
        self.assertIn("outside the camera's range", self.put("gain_db", 90.0))
        self.assertIsNone(self.pv("rms_waves").handler)
        self.call("reference.clear")
        self.assertIn("not valid", self.expect("rms_waves", 3).message)
        wait_for(lambda: not self.pv("valid").value, what="the value of a frame that is not valid")
        self.assertEqual(self.pv("frame_id").severity, 0)
        self.bench.stop("ovwsd")
        for name in ("frame_id", "image", "exposure_us", "aberration"):
            self.assertIn("does not answer", self.expect(name, 3).message)
        self.assertIn("no answer", self.put("exposure_us", 700.0))
        self.restart_daemon()
        self.expect("frame_id", 0)


if __name__ == "__main__":
    main()
