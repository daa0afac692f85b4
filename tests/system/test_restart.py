"""State that survives a restart, such as the reference with its conditions; killing the daemon never corrupts it.

    OVWS_KILLS=200   number of times to kill the daemon while it writes
"""
import collections
import json
import os
import random
import re
import statistics
import subprocess
import threading

from case import PATIENCE_S, BenchCase, Client, ClientError, main, wait_for

KILLS = int(os.environ.get("OVWS_KILLS", "4"))
BY_DEFECT = re.compile(r"damaged|cut off|not written by the daemon|is empty")


class Restart(BenchCase):
    small = True
    daemon_config = {"state": {"directory": "state"}}  # in the bench's own folder
    twin_config = {"aberration": [{"n": 2, "m": 2, "waves": 0.2}]}

    def files(self):
        """The stored files except the saved settings."""
        return sorted(path for path in (self.bench.directory / "state").iterdir() if path.name != "config.json")

    def kill(self):
        self.bench.process("ovwsd").popen.kill()
        self.ended()

    def ended(self):
        """Waits for the killed daemon's end, and frees its camera, which otherwise waits 3 s for its heartbeat (test_daemon_killed)."""
        self.bench.stop("ovwsd")
        self.twin.call("twin.fault", {"kind": "unplug", "seconds": 60.0})
        wait_for(lambda: not self.twin.call("twin.get")["camera"]["plugged"], what="the end of the connection")
        self.twin.call("twin.fault", {"kind": "none"})

    def start_again(self, **more):
        """Restarts the daemon with its configuration, changed by these sections; returns its log."""
        self.start_daemon(**more)
        self.wait_until("running")
        return self.bench.log("ovwsd")

    def reference_state(self):
        return self.call("system.status")["sensor"]["reference"]

    def means(self, hologram_id=None, count=30):
        frames = self.settled_frames(self.stream("wavefront"), count, hologram_id)
        return dict(zip(frames[0]["j"], map(statistics.fmean, zip(*(frame["coefficients"] for frame in frames)))))

    def test_the_reference_is_in_force_again_after_a_kill(self):
        self.call("camera.set", {"gain_db": 3.0, "exposure_us": 1400.0})
        saved = self.call("config.save")
        self.assertEqual(saved["saved"], ["camera.exposure_us", "camera.gain_db"])
        self.take_reference(50)
        before = self.call("reference.get")
        self.assertEqual(before["source"], "measured")
        self.assertEqual(before["origin"]["camera"]["serial"], "TWIN0001")
        self.assertEqual(before["origin"]["settings"], {"gain_db": 3.0, "exposure_us": 1400.0, "pixel_format": "Mono8"})
        self.assertEqual(len(self.files()), 1)
        kept = json.loads(self.files()[0].read_text())
        self.assertEqual((kept["schema"], kept["sha256"]), ("ovws.state.reference/1", before["sha256"]))
        self.assertEqual(kept["content"]["origin"], before["origin"])
        self.kill()
        log = self.start_again()
        self.assertIn(f"saved values active: camera.exposure_us, camera.gain_db ({saved['path']})", log)
        self.assertIn(before["sha256"], log)
        self.assertIn(before["t_taken"], log)
        self.assertEqual(self.call("reference.get"), before)
        self.assertEqual(self.reference_state(), "in_force")
        rest = self.means()
        hologram_id = self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.1}]})["hologram_id"]
        shown = self.means(hologram_id)
        print(f"\n  without a new reference: at most {max(map(abs, rest.values())):.4f} waves; 0.1 of j = 3 reads {shown[3]:.4f}")
        self.assertLess(max(map(abs, rest.values())), 0.01)
        self.assertAlmostEqual(shown[3], 0.1, delta=0.02)

    def test_the_registration_is_in_force_again_after_a_kill(self):
        self.twin.call("twin.set", {"geometry": {"rotation_deg": 5.0}})
        self.run_job("registration.run", {})
        before = self.call("registration.get")
        self.take_reference(20)
        self.kill()
        self.start_again()
        self.assertEqual(self.call("registration.get"), before)
        self.assertEqual(self.reference_state(), "in_force")
        self.assertEqual({frame["tracked"] for frame in self.settled_frames(self.stream("wavefront"), 10)}, {19})
        self.call("registration.clear")
        self.kill()
        self.start_again()
        self.assertFalse(self.call("registration.get")["registered"])
        self.assertEqual(self.reference_state(), "none")

    def test_what_only_makes_it_stale_is_reported_and_what_makes_it_another_ones_too(self):
        self.take_reference(20)
        before = self.call("reference.get")
        self.call("camera.set", {"gain_db": 6.0})
        self.assertEqual(self.call("reference.get")["stale"], [{"field": "gain_db", "then": 0.0, "now": 6.0}])
        self.assertEqual(self.reference_state(), "stale")
        self.assertTrue(self.settled_frames(self.stream("wavefront"), 1))
        wait_for(lambda: "gain_db was 0.0, and is 6.0" in self.bench.log("ovwsd"), what="the event")
        self.call("camera.set", {"gain_db": 0.0})
        self.assertEqual(self.reference_state(), "in_force")
        self.kill()
        log = self.start_again(optics={"wavelength_nm": 633.0})
        self.assertIn("is not used: optics.wavelength_nm was 632.0, and is 633.0; undo what has changed, or run reference.take", log)
        self.assertEqual((self.reference_state(), self.call("reference.get")["taken"]), ("none", False))
        self.kill()
        self.start_again()
        self.assertEqual(self.call("reference.get"), before)

    def test_a_cleared_one_is_gone_and_the_model_can_take_its_place(self):
        self.take_reference(20)
        self.call("reference.clear")
        self.kill()
        self.start_again()
        self.assertEqual((self.files(), self.reference_state()), ([], "none"))
        model = self.call("reference.set", {"source": "model"})
        self.assertEqual((model["source"], model["frames"], model["stale"]), ("model", 0, []))
        self.assertEqual(model["positions_px"][9], [255.5, 255.5])  # the base subaperture is in the middle of 19
        self.call("camera.set", {"gain_db": 6.0})
        self.assertEqual(self.reference_state(), "in_force")
        self.call("camera.set", {"gain_db": 0.0})
        absolute = self.means()
        print(f"\n  against the model the hidden 0.2 waves of j = 5 read {absolute[5]:.4f}")
        self.assertAlmostEqual(absolute[5], 0.2, delta=0.03)
        self.kill()
        self.start_again()
        self.assertEqual(self.call("reference.get"), model)
        self.take_reference(20)
        self.assertEqual(self.call("reference.get")["source"], "measured")
        self.assertEqual(len(self.files()), 1)

    def test_one_of_a_camera_that_stands_askew_waits_for_its_registration(self):
        self.twin.call("twin.set", {"geometry": {"rotation_deg": 33.0, "centre_px": [275.5, 245.5]}})
        self.run_job("registration.run", {})
        self.take_reference(20)
        before = self.call("reference.get")
        self.assertEqual(before["origin"]["registration"]["t_taken_ns"], self.call("registration.get")["t_taken_ns"])
        self.kill()
        for file in self.files():
            if "registration" in file.name:
                file.unlink()
        self.assertIn(before["sha256"], self.start_again())
        self.assertEqual(self.reference_state(), "none")
        self.run_job("registration.run", {})
        self.assertEqual(self.call("reference.get"), before)

    def test_a_store_that_is_damaged_or_cannot_be_written_stops_nothing(self):
        self.take_reference(20)
        file = self.files()[0]
        self.kill()
        whole = file.read_bytes()
        file.write_bytes(whole[:len(whole) // 2])
        log = self.start_again()
        self.assertRegex(log, re.escape(file.name) + " is not used, and left as it is: it is cut off")
        self.assertEqual(self.reference_state(), "none")
        self.assertEqual(file.read_bytes(), whole[:len(whole) // 2])
        self.kill()
        self.start_again(state={"directory": "/proc/nowhere"})
        store = self.call("system.status")["store"]
        self.assertIsNone(store["directory"])
        self.assertIn("/proc/nowhere", store["reason"])
        self.take_reference(20)
        self.assertIsNone(self.call("reference.get")["sha256"])

    def test_saved_settings_are_laid_over_the_file(self):
        config, overlay = self.bench.directory / "ovwsd.json", self.bench.directory / "state" / "config.json"
        file = config.read_bytes()
        self.call("camera.set", {"gain_db": 3.0, "exposure_us": 1400.0})
        self.assertEqual(self.call("config.save"), {"path": str(self.bench.directory / "state" / "config.json"), "saved": ["camera.exposure_us", "camera.gain_db"]})
        self.assertEqual(config.read_bytes(), file)
        # A key edited in the file afterwards overrides its saved value; all others stay saved.
        self.kill()
        log = self.start_again(camera={"gain_db": 6.0})
        self.assertIn("saved values active: camera.exposure_us (", log)
        self.assertIn("the file's values are used: camera.gain_db", log)
        settings = self.call("camera.get")["settings"]
        self.assertEqual((settings["gain_db"], settings["exposure_us"]), (6.0, 1400.0))
        checked = subprocess.run([self.bench.programs / "ovwsd", "--check-config", "--config", config], cwd=self.bench.directory, capture_output=True, text=True)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        self.assertIn("saved values active: camera.exposure_us (", checked.stderr)
        self.assertEqual(json.loads(checked.stdout)["camera"]["exposure_us"], 1400.0)
        # A damaged overlay does not prevent the start.
        for bad, number in ((overlay.read_text()[:40], ""), (overlay.read_text().replace("1400.0", "-1.0"), ".2")):
            self.kill()
            overlay.write_text(bad)
            self.assertRegex(self.start_again(), f"warning.*{overlay} are not used: .*renamed to {overlay}.rejected{number}")
            self.assertEqual(overlay.with_name(f"config.json.rejected{number}").read_text(), bad)
            self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], 2000.0)
        # Saving the file's own values leaves no overlay.
        self.call("camera.set", {"exposure_us": 1400.0})
        self.call("config.save")
        self.assertTrue(overlay.exists())
        self.call("camera.set", {"exposure_us": 2000.0})
        self.assertEqual(self.call("config.save")["saved"], [])
        self.assertFalse(overlay.exists())
        self.kill()
        self.start_again(state={"directory": None})
        refused = self.refused("config.save")
        self.assertEqual(refused.data["field"], "state.directory")
        self.assertIn("set state.directory", refused.data["reason"])

    def kept(self):
        """The stored state: checksums of reference and calibration (None: none), and the gain in the saved configuration."""
        return {"reference": self.call("reference.get")["sha256"], "calibration": self.call("calibration.get")["sha256"],
                "gain_db": self.call("config.get")["camera"]["gain_db"]}

    def step(self, action):
        if action == "reference":
            self.take_reference(3)
        elif action == "no reference":
            self.call("reference.clear")
        elif action == "calibration":
            self.run_job("calibration.run", {"frames": 2, "modes": [1, 2, 3]})
        elif action == "no calibration":
            self.call("calibration.clear")
        else:
            self.call("camera.set", {"gain_db": action})
            self.call("config.save")

    def churn(self, end, kept):
        """Takes, clears and saves until the daemon is killed; returns the state after the last finished step, and the interrupted step."""
        self.client.close()
        self.client = Client(timeout_s=2.0)  # soon knows that the daemon was killed
        self.addCleanup(self.client.close)
        while True:
            action = random.choice(["reference", "calibration", "no reference", "no calibration", float(random.randrange(10))])
            try:
                self.step(action)
                kept = self.kept()
            except ClientError as error:
                self.assertIsNone(error.code, error)  # no reply; not an error reply
                self.assertTrue(end.wait(PATIENCE_S))
                return kept, action

    def check_found(self, old, now, action, log):
        """Checks that only the interrupted item may have changed, to its new value."""
        changed = [key for key in now if now[key] != old[key]]
        by = "gain_db" if isinstance(action, float) else action.split()[-1]
        self.assertIn(changed, ([], [by]), (old, now, action))
        if changed:
            self.assertTrue(now[by] == action if by == "gain_db" else (now[by] is None) == action.startswith("no "), (old, now, action))
        for key in ("reference", "calibration"):
            if now[key]:
                self.assertIn(now[key], log)
        self.assertEqual(len(self.files()), sum(now[key] is not None for key in ("reference", "calibration")))
        return bool(changed)

    def test_kills_at_any_moment_leave_the_old_or_the_new(self):
        random.seed(11)
        self.call("camera.set", {"exposure_us": 500.0})  # no saturation at any of these gains
        self.call("config.save")
        old, found_new, interrupted = self.kept(), 0, collections.Counter()
        for _ in range(KILLS):
            end = threading.Event()
            killer = threading.Timer(random.uniform(0.05, 3.0), lambda: (self.bench.process("ovwsd").popen.kill(), end.set()))
            killer.start()
            old, action = self.churn(end, old)
            killer.join()
            self.ended()
            self.client.close()  # pending requests must not reach the next daemon
            log = self.start_again()
            self.assertNotRegex(log, BY_DEFECT)
            now = self.kept()
            found_new += self.check_found(old, now, action, log)
            interrupted["configuration" if isinstance(action, float) else action] += 1
            if now["reference"]:
                self.assertTrue(self.settled_frames(self.stream("wavefront"), 1))
            old = now
        self.assertEqual([p.name for p in self.bench.directory.glob("**/*.ovws-tmp")], [])
        print(f"\n  {KILLS} kills, {found_new} of them found the new one of what was interrupted: {dict(interrupted)}")


if __name__ == "__main__":
    main()
