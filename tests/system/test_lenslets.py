"""A fixed array of lenslets: found in one image, referenced, known modes read back, without a display."""
import contextlib
import json
import math
import signal
import struct
import time

from case import BenchCase, ClientError, Stream, main, merged, message_since, wait_for

# A small part of a usual array: 13 x 11 lenslets of 150 um and 5.2 mm focal length on pixels of 5.3 um.
OPTICS = {"wavelength_nm": 632.0, "focal_length_mm": 5.2, "camera_pitch_um": 5.3}
TWIN = {"modulator": "fixed", "noise": "pool", "camera": {"sensor_width": 480, "sensor_height": 400, "rotation_deg": 0.8},
        "optics": OPTICS | {"centre_px": [241.3, 203.8]}, "sensor": {"charge": 0},
        "array": {"pitch_um": 150.0, "columns": 13, "rows": 11, "pupil_mm": 1.65}, "light": {"peak_electrons": 6000}}  # saturates bright spots at 2000 us, which registration.run must bear
DAEMON = {"modulator": "fixed", "camera": {"exposure_us": 2000.0, "roi": {"width": 480, "height": 400}}, "optics": OPTICS,
          "sensor": {"charge": 0, "grid": "square"}, "array": {"pitch_um": 150.0, "pupil_mm": 1.65}, "tracking": {"tracker": "lg"}, "state": {"directory": "state"}}


def turned(modes, degrees):
    """The twin's modes turn with its array, the daemon's are along the camera's axes: pairs (n, -m), (n, m) turn by m times the angle."""
    seen = dict(modes)
    for minus, plus, m in ((3, 5, 2), (7, 8, 1)):
        angle = math.radians(m * degrees)
        sine, cosine = modes.get(minus, 0.0), modes.get(plus, 0.0)
        seen[minus] = sine * math.cos(angle) + cosine * math.sin(angle)
        seen[plus] = cosine * math.cos(angle) - sine * math.sin(angle)
    return seen


class Array(BenchCase):
    twin_config = TWIN
    daemon_config = DAEMON
    exposure_us = 500.0
    turn_deg = 0.8  # of the lattice, as the daemon's modes see it

    def start(self):
        self.start_twin()
        self.start_daemon()
        self.wait_until("running")

    def hide(self, *modes):
        self.light(aberration=list(modes), norm="rms")

    def light(self, **settings):
        """Returns when frames show these settings: no job shows a hologram of its own, which would tell later frames from earlier ones."""
        self.twin.call("twin.set", settings)
        with contextlib.closing(Stream(["wavefront"])) as frames:
            message_since(frames, time.time_ns())

    def read_back(self):
        """Finds the array, takes a reference, and compares known modes with what is measured, within 2 %."""
        found = self.run_job("registration.run", {"frames": 10})["result"]
        array = found["array"]
        self.assertAlmostEqual(array["magnification"], 1.0, delta=0.002)
        self.assertAlmostEqual(array["lenslets"]["rotation_deg"], self.turn_deg, delta=0.05)
        self.assertAlmostEqual(found["base_px"][0], 241.3, delta=1.0)
        self.assertAlmostEqual(found["base_px"][1], 203.8, delta=1.0)
        self.assertEqual(array["lit"], 13 * 11)
        self.call("camera.set", {"exposure_us": self.exposure_us})
        self.take_reference(30)
        stream = self.stream("wavefront")
        known = {4: 0.25, 5: -0.15, 3: 0.1, 8: 0.05}
        self.hide(*({"j": j, "waves": waves} for j, waves in known.items()))
        seen = turned(known, self.turn_deg)

        def are_known(modes):
            rest = {j: waves for j, waves in modes.items() if j not in seen}
            return (all(abs(modes[j] - waves) <= 0.02 * abs(waves) + 0.001 for j, waves in seen.items())
                    and all(abs(waves) < (0.01 if j <= 2 else 0.003) for j, waves in rest.items()))  # coma inside a lenslet moves its spot, too
        self.modes_when(stream, are_known, "the known modes")
        self.hide()
        self.modes_when(stream, lambda modes: math.sqrt(sum(waves * waves for waves in modes.values())) < 0.004, "no modes")

    def test_bright_spots_read_known_modes_back(self):
        self.read_back()
        sensor = self.call("sensor.get")
        self.assertEqual(sensor["subapertures"], 81)
        self.refused("sensor.set", {"charge": 1})
        for method, params in (("aberration.set", {"modes": [{"j": 4, "waves": 0.1}]}), ("loop.close", {}), ("lut.run", {}),
                               ("slm.show", {"pattern": "flat"}), ("calibration.run", {})):
            self.assertIn("lenslets", str(self.refused(method, params)), method)

    def test_known_tilts_give_a_reference(self):
        from ovws_client import reference_from_tilts
        self.run_job("registration.run", {"frames": 10})
        self.call("camera.set", {"exposure_us": self.exposure_us})
        self.take_reference(30)
        at_rest = self.call("reference.get")["positions_px"]
        tilts = [(0.3, 0.0), (-0.3, 0.1), (0.0, -0.3), (0.2, 0.3)]  # waves of j = 2 and j = 1, as the array stands
        found = reference_from_tilts(self.client, lambda x, y: self.hide({"j": 2, "waves": x}, {"j": 1, "waves": y}), tilts, settle_s=0.1)
        self.assertEqual((found.known["source"], found.known["frames"]), ("measured", 80))
        off = [math.dist(a, b) for a, b in zip(found.known["positions_px"], at_rest)]
        self.assertLess(math.sqrt(sum(d * d for d in off) / len(off)), 0.02)
        self.assertLess(found.residual_px, 0.03)
        scale = 4 * 117.04 / 311.32  # px per wave RMS: lambda f / pixel^2, four waves across a pupil of so many pixels
        self.assertAlmostEqual(found.px_per_tilt[0][0], scale * math.cos(math.radians(0.8)), delta=0.02 * scale)
        self.hide({"j": 4, "waves": 0.25})
        self.assertAlmostEqual(self.mean_modes(self.frames_from_now(self.stream("wavefront"), 20))[4], 0.25, delta=0.006)
        positions = found.zeros_px.astype("<f4")

        def given(field, binary, **params):
            with self.assertRaises(ClientError) as caught:
                self.client.call("reference.give", params, binary)
            self.assertEqual(caught.exception.data["field"], field, caught.exception)

        both = [positions, 0.01 + 0 * positions]
        given("positions", None)
        given("positions", positions.tobytes())  # half of it
        given("positions", both[0][:-1].tobytes() + both[1][:-1].tobytes())
        given("positions", both[0].tobytes() + (-both[1]).tobytes())
        given("positions", (both[0] + 500.0).tobytes() + both[1].tobytes())
        given("positions", both[0][::-1].tobytes() + both[1].tobytes())
        given("positions", (0 * both[0] + 200.0).tobytes() + both[1].tobytes())
        given("positions", (both[0] * float("nan")).tobytes() + both[1].tobytes())
        given("positions", both[0].tobytes() + (1e30 * both[1]).tobytes())
        given("frames", both[0].tobytes() + both[1].tobytes(), frames=0)
        self.call("sensor.set", {"tracker": "fit"})
        given("tracker", both[0].tobytes() + both[1].tobytes())

    def test_an_array_that_was_not_found_gets_no_reference(self):
        """Nothing tells then how far it is turned, and modes would be valid and wrong."""
        places = [(x + 239.5, y + 199.5) for x, y in self.call("sensor.get")["lenslets"]["centres_px"]]
        given = struct.pack(f"<{4 * len(places)}f", *(v for place in places for v in place), *[0.01] * (2 * len(places)))

        def is_refused(method, params, binary=None, field="registration"):
            with self.assertRaises(ClientError) as caught:
                self.client.call(method, params, binary)
            self.assertEqual(caught.exception.data["field"], field, caught.exception)
            self.assertIn("the array has not been found yet, and modes would be wrong if it is turned: call registration.run", str(caught.exception))
            self.assertFalse(self.call("reference.get")["taken"])

        def all_are_refused():
            is_refused("reference.take", {})
            is_refused("reference.set", {"source": "model"})
            is_refused("reference.give", {}, given)

        all_are_refused()
        self.run_job("registration.run", {"frames": 10})
        self.assertEqual(self.call("reference.set", {"source": "model"})["source"], "model")
        self.call("reference.save", {"name": "found"})
        self.call("registration.clear")
        all_are_refused()
        is_refused("reference.load", {"name": "found"}, field="name")
        (saved,) = self.call("reference.list")["references"]
        self.assertIn("registration.run", saved["reason"])

    def test_stays_over_a_restart(self):
        self.read_back()
        before = self.call("registration.get")
        reference = self.call("reference.get")
        self.restart()
        self.call("camera.set", {"exposure_us": self.exposure_us})
        self.assertEqual(self.call("registration.get"), before)
        self.assertEqual(self.call("reference.get")["positions_px"], reference["positions_px"])
        self.settled_frames(self.stream("wavefront"), 5)
        config = merged(self.daemon_config, {"array": {"pupil_mm": 1.0}})
        (self.bench.directory / "ovwsd.json").write_text(json.dumps(config))
        events = self.stream("event")
        self.bench.process("ovwsd").popen.send_signal(signal.SIGHUP)
        told = wait_for(lambda: (event := events.next(1.0)) and event["kind"] == "config" and event["data"], what="the reload")
        self.assertEqual((told["applied"], told["restart"][0]), (["camera.exposure_us"], "array.pupil_mm"))
        self.assertEqual([key for key in self.call("config.save")["saved"] if key.startswith("sensor")], [])
        self.bench.stop("ovwsd")
        self.assertNotIn("was measured with other settings", self.bench.log("ovwsd"))
        changed = "array.pitch_um was 150.0, and is "
        self.start_daemon(array={"pitch_um": 152.0})  # lambda/d of fewer pixels than a tracker needs
        self.wait_until("running")
        self.bench.stop("ovwsd")
        log = self.bench.log("ovwsd")
        self.assertIn("registration is not used: ", log)
        self.assertIn(changed + "152.0; restore", log)
        self.start_daemon(array={"pitch_um": 148.0})
        self.wait_until("running")
        self.assertTrue(self.call("registration.get")["registered"])
        self.assertIn("was measured with other settings: " + changed + "148.0; it is used", self.bench.log("ovwsd"))
        self.call("registration.clear")
        self.assertFalse(self.call("reference.get")["taken"])

    def restart(self, **changed):
        self.bench.stop("ovwsd")
        self.start_daemon(**changed)
        self.wait_until("running")

    def test_what_was_corrected_is_measured_as_if_nothing_was_stored(self):
        """A square lattice looks the same after a half or quarter turn, and few lenslets may lie between two pupils."""
        def found():
            result = self.run_job("registration.run", {"frames": 10})["result"]
            array = result["array"]
            return result["px_per_cycle"] + [array["pupil_diameter_px"], array["lit"], result["sights"], len(array["lenslets"]["centres_px"])]

        found()
        for changed in ({"optics": {"px_per_cycle": [0, -100, 100, 0]}}, {"optics": {"px_per_cycle": [-100, 0, 0, -100]}}, {"array": {"pupil_mm": 1.7}},
                        {"array": {"pupil_mm": 1.75}}):
            with self.subTest(changed):
                self.restart(**changed)
                corrected = found()
                self.call("registration.clear")
                for value, fresh in zip(corrected, found()):
                    self.assertAlmostEqual(value, fresh, delta=0.1)
        self.renew_twin(array={"beam_diameter_mm": 1.75})
        dimmer = found()
        self.assertEqual(dimmer[-3], dimmer[-2])
        self.assertAlmostEqual(dimmer[-3], 101, delta=3)  # of 143

    def test_a_registration_in_other_light_says_that_the_reference_is_not_used(self):
        self.run_job("registration.run", {"frames": 10})
        self.call("camera.set", {"exposure_us": self.exposure_us})
        self.take_reference(30)
        taken = self.call("reference.get")["sha256"]
        self.run_job("registration.run", {"frames": 10})
        self.assertEqual(self.call("reference.get")["sha256"], taken, "of the same light")
        events = self.stream("event")
        self.hide({"j": 4, "waves": 0.1})
        self.run_job("registration.run", {"frames": 10})
        self.assertFalse(self.call("reference.get")["taken"])
        event = wait_for(lambda: (event := events.next(0.5)) and event["kind"] == "reference" and not event["data"]["used"] and event, what="the event")
        self.assertIn("lenslets have been measured elsewhere", event["text"])
        invalid = self.call("system.status")["sensor"]["invalid"]
        self.assertIn("lenslets have been measured elsewhere", invalid["reason"])
        self.assertIn("reference", invalid["action"])
        self.take_reference(30)
        self.assertIsNone(self.call("system.status")["sensor"]["invalid"])

    def ovws(self, *arguments):
        """Runs ovws on this bench; returns its exit code and all that it printed."""
        config = [] if arguments[0] == "check" else ["--config", "ovwsd.json"]
        ended = self.run_ovws(*arguments, *config, cwd=self.bench.directory)
        return ended.returncode, ended.stdout + ended.stderr

    def test_commands_know_that_there_is_no_slm(self):
        _, text = self.ovws("doctor")
        self.assertIn("a fixed array of lenslets needs no display", text)
        self.assertNotIn("X server", text)
        self.assertNotIn(" 0 MiB", text)
        # Without `doctor` and `camera`, which judge this machine.
        code, text = self.ovws("setup", "--yes", "exposure", "registration", "reference", "save")
        self.assertEqual(code, 0, text)
        self.assertIn("143 lenslets are lit", text)
        self.assertNotIn("flatness", text)
        steps = json.loads(self.ovws("--json", "setup", "--list")[1])["steps"]
        self.assertEqual([one["name"] for one in steps if one["state"] == "skipped"],
                         ["output", "spot", "lut", "settle", "clear", "flatness", "brightness", "calibration", "loop"])
        for arguments in (("check",), ("advise", "--modes", "20", "--photons", "1e8"), ("hologram", "-o", "h.png"), ("farfield", "-o", "f.png")):
            code, text = self.ovws(*arguments)
            self.assertEqual(code, 1, text)
            self.assertIn("fixed array", text)
        self.assertEqual(list(self.bench.directory.glob("*.png")), [])

    def test_wrong_arrays_are_refused(self):
        self.light(peak_electrons=1.0)
        self.fails("registration.run", "camera")
        self.light(peak_electrons=6000.0)
        self.restart(array={"pitch_um": 130.0})
        self.fails("registration.run", "array.pitch_um")
        self.restart(sensor={"grid": "hexagonal"})
        self.fails("registration.run", "sensor.grid")

    def fails(self, method, field):
        job = self.call(method, {})["job"]
        ended = self.job_ended(job)
        self.assertEqual((ended["state"], ended["error"]["data"]["field"]), ("failed", field), ended)


class Mirrored(Array):
    """The camera sees the array mirrored, and turned by 90.8 degrees; the configuration says so but for the 0.8 degrees."""
    twin_config = merged(TWIN, {"camera": {"mirror": "x", "rotation_deg": 90.8}, "optics": {"centre_px": [241.3, 203.8]},
                                "array": {"columns": 11, "rows": 13}})
    daemon_config = merged(DAEMON, {"optics": {"px_per_cycle": [0.0, -117.0, -117.0, 0.0]}, "tracking": {"tracker": "fit", "mode_count": 18}})
    turn_deg = -0.8
    test_bright_spots_read_known_modes_back = None
    test_known_tilts_give_a_reference = None
    test_an_array_that_was_not_found_gets_no_reference = None
    test_stays_over_a_restart = None
    test_what_was_corrected_is_measured_as_if_nothing_was_stored = None
    test_wrong_arrays_are_refused = None
    test_commands_know_that_there_is_no_slm = None

    def test_modes_are_those_of_the_array(self):
        self.read_back()
        before = self.call("registration.get")
        self.assertTrue(before["mirrored"])
        self.assertAlmostEqual(before["px_per_cycle"][1] / before["scale_px_per_cycle"], -1.0)
        self.restart()
        self.assertEqual(self.call("registration.get"), before)


class Vortices(Array):
    """The same with spiral plates of 16 steps, 5 % too deep and 3 um beside the lenslets' centres."""
    twin_config = merged(TWIN, {"sensor": {"charge": 1}, "array": {"plate": {"levels": 16, "depth": 1.05, "shift_um": [3.0, 0.0]}}})
    daemon_config = merged(DAEMON, {"sensor": {"charge": 1}, "array": {"plate": {"levels": 16}}})
    exposure_us = 1400.0
    test_bright_spots_read_known_modes_back = None
    test_known_tilts_give_a_reference = None
    test_an_array_that_was_not_found_gets_no_reference = None
    test_stays_over_a_restart = None
    test_what_was_corrected_is_measured_as_if_nothing_was_stored = None
    test_a_registration_in_other_light_says_that_the_reference_is_not_used = None
    test_wrong_arrays_are_refused = None
    test_commands_know_that_there_is_no_slm = None

    def test_vortices_read_known_modes_back(self):
        self.read_back()

    def test_plates_are_measured(self):
        self.renew_twin(array={"reach_pitches": 3.4})  # all of a spot's light: vortices reach far
        self.assertEqual(self.refused("array.fit").data["field"], "registration")
        self.run_job("registration.run", {"frames": 10})
        self.call("camera.set", {"exposure_us": self.exposure_us})
        self.hide({"j": 4, "waves": 0.2}, {"j": 3, "waves": -0.1})
        fit = self.run_job("array.fit", {})["result"]
        self.assertAlmostEqual(fit["depth"], 1.05, delta=0.004)
        self.assertAlmostEqual(fit["shift_um"][0], 3.0, delta=0.4)
        self.assertAlmostEqual(fit["shift_um"][1], 0.0, delta=0.4)
        self.assertGreaterEqual(fit["spots"], 9)
        before = self.call("registration.get")
        self.assertTrue(before["array"]["plate_fitted"])
        self.run_job("registration.run", {"frames": 10})
        self.restart()
        plate = self.call("registration.get")["array"]["lenslets"]["plate"]
        self.assertEqual(plate, before["array"]["lenslets"]["plate"])
        self.assertEqual(self.call("sensor.get")["lenslets"]["plate"], plate)
        self.restart(array={"plate": {"levels": 12}})
        self.assertEqual({**self.call("sensor.get")["lenslets"]["plate"], "shift_px": None}, {"levels": 12, "depth": 1.0, "shift_px": None})
        self.assertIn("the plates that array.fit measured are not used: array.plate.levels was 16, and is 12", self.bench.log("ovwsd"))
        self.restart()
        self.call("registration.clear")
        self.assertEqual(self.call("sensor.get")["lenslets"]["plate"]["depth"], 1.0)

    def test_plates_that_the_camera_sees_mirrored_are_doubted(self):
        self.renew_twin(camera={"mirror": "x", "rotation_deg": 0.0})
        self.run_job("registration.run", {"frames": 10})
        self.call("camera.set", {"exposure_us": self.exposure_us})
        events = self.stream("event")
        fit = self.run_job("array.fit", {})["result"]
        print("\n ", fit)
        event = wait_for(lambda: (event := events.next(0.5)) and event["kind"] == "array" and event, what="the warning")
        self.assertEqual(event["severity"], "warning")
        self.assertIn("mirrored or turned against optics.px_per_cycle", event["text"])


if __name__ == "__main__":
    main()
