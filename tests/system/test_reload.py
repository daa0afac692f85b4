"""SIGHUP reloads the configuration file: live keys change, everything else continues."""
import itertools
import json
import random
import signal
import time

import thread_holder
from case import PATIENCE_S, BenchCase, ClientError, main, next_message, wait_for


RELOADS = 60  # at least, which are refused, with a change at a random moment of each


class Reload(BenchCase):
    daemon_config = {"camera": {"gain_db": 0.0}, "state": {"directory": "state"}}

    def setUp(self):
        super().setUp()
        self.events = self.stream("event")

    def signal(self, config):
        """Writes the configuration (text, or keys that differ from the defaults) and requests a reload."""
        text = config if isinstance(config, str) else json.dumps(config)
        (self.bench.directory / "ovwsd.json").write_text(text)
        self.bench.process("ovwsd").popen.send_signal(signal.SIGHUP)

    def held(self, thread):
        """Context in which this thread of the daemon stands still."""
        return thread_holder.held(self.bench.process("ovwsd").pid, thread)

    def ended(self):
        """The event at the end of a reload."""
        return wait_for(lambda: (event := self.events.next(0.5)) and event["kind"] == "config" and event, what="the reload's end")

    def reload(self, config):
        self.signal(config)
        return self.ended()

    def error_of(self, method, params):
        try:
            self.call(method, params)
        except ClientError as error:
            return error

    def assert_refused(self, config, field, *words):
        before = self.call("config.get")
        event = self.reload(config)
        self.assertEqual((event["severity"], event["data"]["reloaded"], event["data"]["field"]), ("error", False, field), event)
        for word in words:
            self.assertIn(word, event["text"])
        self.assertIn(event["text"], self.bench.log("ovwsd"))
        self.assertEqual(self.call("config.get"), before)
        return event

    def assert_frames(self, hologram):
        """Checks that settled frames of this hologram are published, with or without a reference."""
        stream = self.stream("wavefront")
        for _ in range(20):
            wait_for(lambda: (frame := stream.next(0.5)) and frame["settled"] and frame["hologram_id"] == hologram, what="a settled frame")

    def test_what_can_change_live_does_and_the_rest_is_named(self):
        self.take_reference(20)
        reference = self.call("reference.get")["sha256"]
        self.call("aberration.set", {"modes": [{"n": 2, "m": 0, "waves": 0.1}]})
        hologram = self.call("system.status")["slm"]["hologram_id"]
        event = self.reload({"camera": {"gain_db": 3.0, "exposure_us": 1500.0, "transfer_ms": 11.0}, "tracking": {"tracker": "lg"},
                             "refine": {"rate_hz": 0.5}, "stream": {"image_rate_hz": 2.0}, "log": {"level": "debug"},
                             "slm": {"settle_ms": 25.0}, "state": {"directory": "state"}})
        print("\n ", event["text"])
        self.assertEqual(set(event["data"]["applied"]),
                         {"camera.gain_db", "camera.exposure_us", "tracking.tracker", "refine.rate_hz", "stream.image_rate_hz", "log.level",
                          "slm.settle_ms"})
        self.assertEqual(set(event["data"]["restart"]), {"camera.transfer_ms"})
        self.assertEqual(self.call("camera.get")["settings"]["gain_db"], 3.0)
        used = self.call("config.get")
        self.assertEqual((used["tracking"]["tracker"], used["refine"]["rate_hz"], used["stream"]["image_rate_hz"], used["log"]["level"],
                          used["slm"]["settle_ms"]), ("lg", 0.5, 2.0, "debug", 25.0))
        status = self.wait_until("running")
        self.assertEqual(status["slm"]["hologram_id"], hologram, "the hologram stays, and the aberration with it")
        self.assertEqual(len(self.call("aberration.get")["modes"]), 1)
        self.assert_frames(hologram)
        images = wait_for(lambda: 0.0 < self.call("system.status")["rates"]["images_hz"] <= 4.0, what="the new image rate")
        self.assertTrue(images)
        back = self.reload({"camera": {"gain_db": 0.0}, "state": {"directory": "state"}})
        self.assertEqual(back["data"]["restart"], [])
        self.assertEqual(self.call("reference.get")["sha256"], reference, "of the first tracker, in force again")
        self.assertEqual(self.call("system.status")["sensor"]["reference"], "in_force")
        self.assertEqual(self.reload({"camera": {"gain_db": 0.0}, "state": {"directory": "state"}})["data"]["applied"], [])

    def test_what_is_wrong_is_refused_whole(self):
        hologram = self.call("system.status")["slm"]["hologram_id"]
        self.assert_refused('{"camera": {"gain_db": 2.0, "exposure_su": 1}}', "camera.exposure_su", "exposure_us")
        self.assert_refused("{", "", "ovwsd.json")
        self.assert_refused({"camera": {"gain_db": 2.0}, "slm": {"driver": "none"}}, "slm.driver")
        # First the camera's own limit; then a sensor error that no camera setting precedes.
        self.assert_refused({"camera": {"gain_db": 90.0}, "tracking": {"tracker": "lg"}}, "camera.gain_db")
        self.assert_refused({"camera": {"gain_db": 2.0}, "tracking": {"operator": "measured"}}, "tracking.operator", "calibration")
        (self.bench.directory / "ovwsd.json").unlink()
        self.assert_frames(hologram)

    def test_saved_settings_are_laid_over_the_file(self):
        overlay = self.bench.directory / "state" / "config.json"
        self.call("camera.set", {"exposure_us": 1500.0, "gain_db": 3.0})
        self.call("sensor.set", {"tracker": "lg"})
        self.assertEqual(self.call("config.save")["saved"], ["camera.exposure_us", "camera.gain_db", "tracking.tracker"])
        self.call("camera.set", {"exposure_us": 1600.0})
        file = {"camera": {"gain_db": 0.0}, "state": {"directory": "state"}}
        event = self.reload(file)
        print("\n ", event["text"])
        self.assertEqual(event["data"]["applied"], ["camera.exposure_us"])
        self.assertEqual((event["severity"], event["data"]["saved"], event["data"]["edited"]),
                         ("info", ["camera.exposure_us", "camera.gain_db", "tracking.tracker"], []))
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], 1500.0)
        event = self.reload(file | {"camera": {"gain_db": 1.0}, "slm": {"settle_ms": 25.0}})
        self.assertEqual((event["data"]["saved"], event["data"]["edited"]), (["camera.exposure_us", "tracking.tracker"], ["camera.gain_db"]))
        self.assertIn("the file's values are used: camera.gain_db", event["text"])
        self.assertEqual(self.call("camera.get")["settings"]["gain_db"], 1.0)
        self.call("config.save")  # keys that wait for a restart are not saved
        self.assertEqual(set(json.loads(overlay.read_text())["saved"]), {"camera.exposure_us", "tracking.tracker"})
        for bad in ("{", overlay.read_text().replace('"lg"', '"best"')):
            overlay.write_text(bad)
            event = self.reload(file)
            self.assertEqual((event["severity"], event["data"]["reloaded"], event["data"]["saved"]), ("warning", True, []), event)
            self.assertIn(f"renamed to {overlay}.rejected", event["text"])
            self.assertEqual(self.call("config.get")["tracking"]["tracker"], "fit")
        self.assertFalse(overlay.exists())
        # The camera refuses a saved value: the error says that it is a saved one.
        text = json.dumps({"file": str(self.bench.directory / "ovwsd.json"), "saved": {"camera.gain_db": {"value": 90.0, "instead_of": 0.0}}})
        overlay.write_text(text)
        self.assert_refused(file, "camera.gain_db", f"a saved value: remove {overlay}")
        self.assertEqual(overlay.read_text(), text)

    def test_a_job_and_the_closed_loop_refuse_it(self):
        self.take_reference(20)
        self.close_loop(gain=0.3)
        self.assert_refused({"camera": {"gain_db": 2.0}}, "", "loop.open")
        self.call("loop.open")
        job = self.call("reference.take", {"frames": 100000})["job"]
        self.assert_refused({"camera": {"gain_db": 2.0}}, "", "job")
        self.call("job.cancel", {"job": job})
        self.wait_until("running")
        self.assertIn("camera.gain_db", self.reload({"camera": {"gain_db": 2.0}})["data"]["applied"])

    def test_until_it_has_ended_no_job_begins_and_nobody_else_changes_the_bench(self):
        change = {"camera": {"gain_db": 2.0, "exposure_us": 1500.0, "roi": {"x": 16, "y": 16, "width": 480, "height": 480}}}
        with self.held("camera"):  # the reload waits for it
            self.signal(change)
            held = wait_for(lambda: self.error_of("aberration.set", {"modes": []}), what="the reload")
            self.assertIn("being reloaded", str(held))
            self.assert_all_refused()
        event = self.ended()
        self.assertTrue(event["data"]["reloaded"], event)
        self.assertIn("camera.roi.width", event["data"]["applied"])
        self.take_reference(20)

    def assert_all_refused(self):
        for method, params in (("reference.take", {"frames": 20}), ("calibration.run", {}), ("registration.run", {}), ("reference.clear", {}),
                               ("sensor.set", {"charge": 1}), ("slm.show", {"pattern": "flat"}), ("camera.set", {"exposure_us": 900.0}),
                               ("camera.select", {"id": "other"}), ("slm.set", {"settle_ms": 30.0}), ("refine.set", {"rate_hz": 2.0}),
                               ("config.save", {}), ("lattice.use", {"name": "none"})):
            refused = self.refused(method, params)
            self.assertEqual(refused.code, -32000, refused)
            self.assertIn("being reloaded", str(refused), method)

    def test_a_disk_that_stands_still_holds_up_the_reload_only(self):
        status = self.stream("status")
        with self.held("disk"):
            self.signal({"camera": {"gain_db": 2.0}})
            status.drain()
            for _ in range(2):  # the thread that publishes it begins the reload
                next_message(status)
            self.call("lattice.list")  # through the thread that holds the bench
            self.call("camera.set", {"exposure_us": 900.0})
            self.call("aberration.set", {"modes": []})
        self.assertIn("camera.gain_db", self.ended()["data"]["applied"])

    def test_a_refused_one_undoes_no_change_that_was_accepted(self):
        """The file is refused by its last part, when the others are applied. Clients meanwhile set what it changes."""
        refused = {"camera": {"exposure_us": 3000.0, "gain_db": 2.0}, "slm": {"settle_ms": 25.0}, "refine": {"rate_hz": 0.5},
                   "tracking": {"operator": "measured"}}
        choose = random.Random(5)
        accepted = busy = 0
        undone = []
        begun = time.monotonic()
        duration_s = 0.06  # of a reload, from the signal to its event
        for k in itertools.count():
            if k >= RELOADS and (accepted and busy or time.monotonic() > begun + PATIENCE_S):
                break
            changes = {"camera.set": {"exposure_us": 1000.0 + k}, "slm.set": {"settle_ms": 10.0 + k % 7}, "refine.set": {"rate_hz": 1.0 + k % 5}}
            method, params = choose.choice(list(changes.items()))
            (key, value), = params.items()
            signalled = time.monotonic()
            self.signal(refused)
            time.sleep(choose.uniform(0.0, duration_s))
            error = self.error_of(method, params)
            self.assertFalse(self.ended()["data"]["reloaded"])
            duration_s = time.monotonic() - signalled
            if error:
                self.assertIn("being reloaded", str(error))
                busy += 1
            else:
                accepted += 1
                section = method.partition(".")[0]
                used = self.call("config.get")[section][key]
                undone += [] if used == value else [(method, value, used)]
        print(f"\n  {accepted} changes accepted, {busy} refused, {len(undone)} undone")
        self.assertEqual(undone, [])
        self.assertGreater(accepted, 0)
        self.assertGreater(busy, 0)
        used = self.call("config.get")
        self.assertEqual((used["camera"]["gain_db"], used["tracking"]["operator"]), (0.0, "slopes"))

    def test_a_file_whose_values_the_camera_rounds_changes_nothing_when_it_is_read_again(self):
        rounded = {"camera": {"gain_db": 2.03, "exposure_us": 1500.4, "roi": {"x": 17, "y": 17, "width": 479, "height": 479}},
                   "state": {"directory": "state"}}
        self.assertIn("camera.exposure_us", self.reload(rounded)["data"]["applied"])
        used = self.call("camera.get")["settings"]
        self.assertEqual((used["gain_db"], used["exposure_us"], used["roi"]["x"]), (2.0, 1500.0, 16))
        self.assertEqual(self.reload(rounded)["data"]["applied"], [])
        self.assertEqual(self.call("config.save")["saved"], [], "rounding is no change of the file")
        as_used = json.dumps(rounded | {"camera": {key: used[key] for key in ("gain_db", "exposure_us", "roi")}})
        self.assertEqual(self.reload(as_used)["data"]["applied"], [])
        self.assertEqual(self.reload(rounded)["data"]["applied"], [])
        self.call("camera.set", {"exposure_us": 1600.2})
        self.assertEqual(self.call("config.save")["saved"], ["camera.exposure_us"])
        self.assertEqual(self.reload(rounded)["data"]["applied"], [])
        (self.bench.directory / "state" / "config.json").unlink()
        self.assertEqual(self.reload(rounded)["data"]["applied"], ["camera.exposure_us"])
        # If a later part of the file is refused, the requested values are rolled back too.
        self.assert_refused({"camera": {"exposure_us": 900.0}, "tracking": {"operator": "measured"}}, "tracking.operator")
        self.assertEqual(self.reload(rounded)["data"]["applied"], [])

    def test_without_a_camera_it_is_what_the_next_connection_uses(self):
        self.bench.stop("ovws-twin")
        self.wait_until("waiting_for_camera")
        event = self.reload({"camera": {"gain_db": 4.0}, "state": {"directory": "state"}})
        self.assertEqual(event["data"]["applied"], ["camera.gain_db"])
        self.start_twin()
        self.wait_until("running")
        self.assertEqual(self.call("camera.get")["settings"]["gain_db"], 4.0)


if __name__ == "__main__":
    main()
