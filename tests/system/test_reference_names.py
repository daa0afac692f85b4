"""References saved by name, the list of recordings, and the preview of config.save."""

from case import BenchCase, main

NAMES = [f"r{k}" for k in range(31)]


class ReferenceNames(BenchCase):
    small = True
    daemon_config = {"state": {"directory": "state"}, "record": {"directory": "recordings"}}

    def names(self):
        return {one["name"]: one for one in self.call("reference.list")["references"]}

    def refusal(self, method, params):
        error = self.refused(method, params)
        return error.data["field"], str(error)

    def test_a_saved_reference_is_the_same_again(self):
        self.assertEqual(self.call("reference.list"), {"references": []})
        self.assertIn("reference.take", self.refusal("reference.save", {"name": "none"})[1])
        self.take_reference(20)
        first = self.call("reference.get")
        saved = self.call("reference.save", {"name": "first"})["references"]
        self.assertEqual([(one["name"], one["t_taken_ns"], one["usable"], one["reason"]) for one in saved], [("first", first["t_taken_ns"], True, None)])
        self.take_reference(21)  # not the mean of the same frames of the twin's pool
        second = self.call("reference.get")
        self.assertNotEqual(second["positions_px"], first["positions_px"])
        self.assertEqual(self.call("reference.load", {"name": "first"}), first | {"sha256": self.call("reference.get")["sha256"]})
        self.assertEqual(self.call("reference.get")["origin"], first["origin"])
        self.check_misfits()
        self.check_restart(first)
        self.check_bounds()
        self.check_verbs()

    def check_misfits(self):
        self.call("sensor.set", {"charge": 0, "tracker": "lg"})
        self.assertEqual((self.names()["first"]["usable"], self.names()["first"]["reason"]), (False, "sensor.charge was 1, and is 0"))
        field, reason = self.refusal("reference.load", {"name": "first"})
        self.assertEqual(field, "name")
        self.assertIn("sensor.charge was 1, and is 0", reason)
        self.call("sensor.set", {"charge": 1})
        self.call("camera.set", {"roi": {"x": 16, "width": 480}})
        self.assertIn("camera.roi", self.names()["first"]["reason"])
        self.call("camera.set", {"roi": {"x": 0, "width": 512}})
        self.assertTrue(self.names()["first"]["usable"])

    def check_restart(self, first):
        self.bench.stop("ovwsd")
        self.start_daemon()
        self.wait_until("running")
        self.call("reference.clear")
        loaded = self.call("reference.load", {"name": "first"})
        self.assertEqual((loaded["positions_px"], loaded["origin"]), (first["positions_px"], first["origin"]))
        self.settled_frames(self.stream("wavefront"), 5)

    def check_bounds(self):
        for name in ("", "A", "a b", "../x", "x" * 65):
            self.assertEqual(self.refusal("reference.save", {"name": name})[0], "name")
        self.assertIn("saved already", self.refusal("reference.save", {"name": "first"})[1])
        for method in ("reference.load", "reference.delete"):
            self.assertIn("no saved reference", self.refusal(method, {"name": "other"})[1])
        for name in NAMES:
            self.call("reference.save", {"name": name})
        self.assertIn("32 saved references", self.refusal("reference.save", {"name": "too-many"})[1])
        for name in NAMES:
            self.call("reference.delete", {"name": name})
        self.assertEqual(list(self.names()), ["first"])
        self.assertEqual([path.name for path in (self.bench.directory / "state").glob("saved-reference.*")], ["saved-reference.first.json"])

    def check_verbs(self):
        def ovws(*words):
            done = self.run_ovws(*words)
            return done.returncode, done.stdout + done.stderr

        self.assertEqual(ovws("reference", "save", "second")[0], 0)
        self.assertIn("first: taken", ovws("reference", "list")[1])
        self.assertIn("measured", ovws("reference", "load", "second")[1])
        self.assertNotIn("second", ovws("reference", "delete", "second")[1])
        self.assertEqual(ovws("reference", "load")[0], 2)
        self.assertEqual(ovws("reference", "grab", "x")[0], 2)

    def test_recordings_and_what_would_be_saved(self):
        self.assertEqual(self.call("record.list")["recordings"], [])
        for name in ("one", "two"):
            self.call("record.start", {"name": name})
            self.recorded_frames(3)
            self.call("record.stop")
        (self.bench.directory / "recordings" / "note.txt").write_text("no recording")
        listed = self.call("record.list")
        self.assertEqual(([one["name"] for one in listed["recordings"]], listed["left_off"]), (["two", "one"], 0))
        for one in listed["recordings"]:
            path = self.bench.directory / "recordings" / f"{one['name']}.h5"
            self.assertEqual((one["file"], one["bytes"], one["t_modified_ns"]), (str(path), path.stat().st_size, path.stat().st_mtime_ns))
        self.call("camera.set", {"exposure_us": 1234.0})
        overlay = self.bench.directory / "state" / "config.json"
        self.assertEqual(self.call("config.save", {"preview": True}), {"path": str(self.bench.directory / "state" / "config.json"), "saved": ["camera.exposure_us"]})
        self.assertFalse(overlay.exists())
        self.assertEqual(self.call("config.save")["saved"], ["camera.exposure_us"])
        self.assertTrue(overlay.exists())


if __name__ == "__main__":
    main()
