"""The Bluesky device: the protocol's methods in the order of a scan, and the real RunEngine where Bluesky can be imported (it is not in Debian)."""
import asyncio
import subprocess
import sys
import time
import unittest

from bridge_case import BridgeCase, environment, has
from case import PATIENCE_S, PROGRAM_PATIENCE_S, ROOT, main, wait_for

import numpy as np

from ovws_bridges.bluesky import WavefrontSensor
from ovws_client import NoAnswer, Refused, Wavefront

WITHOUT = "bluesky cannot be imported: it is not in Debian 12; its protocol's methods are called in order instead"


class Device(BridgeCase):
    def setUp(self):
        super().setUp()
        self.sensor = WavefrontSensor("ovws", timeout_s=PATIENCE_S / 2)
        self.addCleanup(self.sensor.close)

    def reading(self):
        return {name.removeprefix("ovws-"): reading["value"] for name, reading in self.sensor.read().items()}

    def test_a_scan_by_the_methods_in_order(self):
        axis, found = self.sensor.mode("defocus"), {}
        self.sensor.frames = 5
        self.assertEqual((self.sensor.stage(), axis.stage()), ([self.sensor], [axis]))
        keys = self.sensor.describe() | axis.describe()
        for waves in (-0.1, 0.0, 0.1):
            axis.set(waves).wait(PATIENCE_S)
            self.sensor.trigger().wait(PATIENCE_S)
            readings = self.sensor.read() | axis.read()
            self.assertEqual(set(readings), set(keys))
            self.assertEqual(len(readings["ovws-coefficients"]["value"]), *keys["ovws-coefficients"]["shape"])
            self.assertEqual((readings["ovws-frames"]["value"], readings["ovws-aberration-defocus"]["value"]), (5, waves))
            found[waves] = readings["ovws-coefficients"]["value"][3]
            self.assertAlmostEqual(readings["ovws-rms_waves"]["timestamp"], time.time(), delta=60.0)
        for waves, measured in found.items():
            self.assertAlmostEqual(measured, waves, delta=0.005)
        self.assertEqual(axis.locate(), {"setpoint": 0.1, "readback": 0.1})
        self.sensor.unstage()

    def test_units_and_ranges_are_the_daemons(self):
        keys = self.sensor.describe() | self.sensor.exposure_us.describe() | self.sensor.gain_db.describe() | self.sensor.describe_configuration()
        wire, camera = self.schema("wavefront")["properties"], self.schema("camera.set")["properties"]
        for name, unit in (("coefficients", "wave"), ("sigma", "wave"), ("rms_waves", "wave"), ("t_arrival_ns", "ns"), ("wavelength_nm", "nm")):
            self.assertEqual(keys[f"ovws-{name}"]["units"], unit)
            self.assertIn(name, wire)
        for name in ("exposure_us", "gain_db"):
            limits = {"low": camera[name]["minimum"], "high": camera[name]["maximum"]}
            self.assertEqual(keys[f"ovws-{name}"]["limits"]["control"], limits)
            with self.assertRaisesRegex(ValueError, f"{name}: must be from"):
                getattr(self.sensor, name).check_value(2 * limits["high"])
        self.assertEqual([keys[f"ovws-{name}"]["dtype"] for name in ("coefficients", "valid", "frame_id")], ["array", "boolean", "integer"])
        self.assertEqual(self.sensor.read_configuration()["ovws-j"]["value"].tolist(), self.call("sensor.get")["modes_j"])

    def test_set_is_done_when_a_frame_was_exposed_with_the_value(self):
        frames = []
        self.sensor.link.add_listener(lambda message: isinstance(message, Wavefront) and frames.append(message))
        for value in (900.0, 1500.0):
            called_ns = time.time_ns()
            self.sensor.exposure_us.set(value).wait(PATIENCE_S)
            self.assertEqual(frames[-1].exposure_us, value)
            self.assertGreater(frames[-1].t_arrival_ns - 1e3 * value, called_ns, "its exposure began after the call")
        self.sensor.aberration.set({"horizontal coma": 0.1, "defocus": 0.05}).wait(PATIENCE_S)
        heard, shown = frames.copy(), self.call("aberration.get")
        self.assertTrue(any(frame.settled and frame.hologram_id == shown["hologram_id"] for frame in heard))
        self.assertEqual(self.sensor.aberration.position[[3, 7]].tolist(), [0.05, 0.1])
        self.assertEqual(self.sensor.aberration.describe()["ovws-aberration"]["shape"], [18])

    def test_refusals_pass_on_the_reason(self):
        for setting, value, reason in ((self.sensor.exposure_us, 1e9, "exposure_us: must be a number from 0.1"), (self.sensor.gain_db, 90.0, "outside the camera's range"),
                                       (self.sensor.aberration, [1e6], "must be a number from -1000"), (self.sensor.exposure_us, "long", "exposure_us")):
            action = setting.set(value)
            error = action.exception(PATIENCE_S)
            self.assertIsInstance(error, Refused)
            self.assertRegex(str(error), reason)
            self.assertEqual((action.done, action.success), (True, False))
        self.call("reference.clear")
        self.sensor.timeout_s = 5.0
        self.assertRegex(str(self.sensor.trigger().exception(PATIENCE_S)), r"0 of 1 valid frames .* is there a reference\?")
        self.assertFalse(self.reading()["valid"])
        self.assertTrue(np.isnan(self.reading()["rms_waves"]))

    def test_actions_can_be_awaited_and_call_back(self):
        async def both():
            await self.sensor.exposure_us.set(1200.0)
            with self.assertRaises(Refused):
                await self.sensor.gain_db.set(1e6)

        asyncio.run(both())
        called = []
        action = self.sensor.trigger()
        action.add_callback(called.append)
        action.wait(PATIENCE_S)
        wait_for(lambda: called == [action], what="the callback")

    def test_it_outlives_the_daemon(self):
        seen = []
        self.sensor.subscribe(seen.append)
        self.sensor.trigger().wait(PATIENCE_S)
        self.bench.stop("ovwsd")
        impatient = WavefrontSensor("ovws", timeout_s=2.0)
        self.addCleanup(impatient.close)
        self.assertIsInstance(impatient.exposure_us.set(700.0).exception(PATIENCE_S), NoAnswer)
        self.assertIsInstance(impatient.trigger().exception(PATIENCE_S), NoAnswer)
        wait_for(lambda: self.sensor.link.newest(Wavefront) is None, what="that the daemon is lost")
        self.restart_daemon()
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], 2000.0, "what was given up is not carried out later")
        self.sensor.stage()
        self.sensor.trigger().wait(PATIENCE_S)
        before = len(seen)
        wait_for(lambda: len(seen) > before, what="frames of the new daemon")

    def test_two_at_once_and_a_killed_one(self):
        code = f"from ovws_bridges.bluesky import WavefrontSensor\ns = WavefrontSensor()\ns.subscribe(lambda r: None)\ns.trigger().wait({PATIENCE_S})\nprint('ready', flush=True)\nimport time\ntime.sleep(600)"
        self.sensor.trigger().wait(PATIENCE_S)
        seen = []
        other = self.bench.start("other", [sys.executable, "-c", code], env=environment())
        other.wait_for_line("ready")
        self.sensor.describe()
        self.sensor.subscribe(lambda readings: seen.append(readings["ovws-seq"]["value"]))
        others = self.connections(other.popen.pid)
        self.assertTrue(self.daemon_has(others), others)
        wait_for(lambda: len(seen) > 25, what="frames")
        other.popen.kill()
        wait_for(lambda: not self.daemon_has(others), what="the end of its connections")
        wait_for(lambda: len(seen) > 75, what="frames")
        self.assertEqual(set(np.diff(seen)), {1})
        self.sensor.gain_db.set(1.0).wait(PATIENCE_S)


@unittest.skipUnless(has("bluesky"), WITHOUT)
class Engine(BridgeCase):
    def setUp(self):
        super().setUp()
        import bluesky

        self.sensor = WavefrontSensor("ovws", frames=3, timeout_s=PATIENCE_S / 2)
        self.addCleanup(self.sensor.close)
        self.engine, self.documents = bluesky.RunEngine({}), []

    def run_plan(self, plan):
        self.documents.clear()
        return self.engine(plan, lambda name, document: self.documents.append((name, document)))

    def of(self, kind):
        return [document for name, document in self.documents if name == kind]

    def test_a_real_scan(self):
        from bluesky import plans
        self.run_plan(plans.scan([self.sensor], self.sensor.mode("defocus"), -0.1, 0.1, 5))
        (descriptor,), events = self.of("descriptor"), self.of("event")
        self.assertEqual(len(events), 5)
        for event, waves in zip(events, np.linspace(-0.1, 0.1, 5)):
            self.assertAlmostEqual(event["data"]["ovws-aberration-defocus"], waves, places=9)
            self.assertAlmostEqual(event["data"]["ovws-coefficients"][3], waves, delta=0.005)
        self.assertEqual(descriptor["data_keys"]["ovws-coefficients"]["units"], "wave")
        self.assertEqual(descriptor["configuration"]["ovws"]["data"]["ovws-charge"], 1)
        self.assertEqual(self.of("stop")[0]["exit_status"], "success")

    def test_the_code_of_the_guide(self):
        guide = (ROOT / "daemon" / "guide" / "bridges.md").read_text()
        code = next(block for block in guide.split("```python") if "RunEngine" in block).split("```")[0]
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, env=environment())
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.count("event {"), 11)

    def test_a_refused_value_fails_the_plan_with_its_reason(self):
        from bluesky import plan_stubs
        from bluesky.utils import FailedStatus
        with self.assertRaisesRegex(FailedStatus, "gain_db: 90 is outside the camera's range of 0 to"):
            self.run_plan(plan_stubs.mv(self.sensor.gain_db, 90.0))


if __name__ == "__main__":
    main()
