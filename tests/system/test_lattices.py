"""Prepared lattices: measured once, used by name, right against the twin's truth, and there again after a restart."""
import itertools
import os
import random
import statistics
import subprocess
import threading
import time
from pathlib import Path

import thread_holder
from case import PATIENCE_S, ROOT, BenchCase, Client, ClientError, bench_module, main, next_message, wait_for

HIDDEN = {3: 0.06, 4: -0.05, 5: 0.03}  # waves: modes that every lattice here determines
CORRECTION = {"modes": [{"j": 4, "waves": 0.02}]}
BOUND_WAVES = 0.012
STEEP, STEEP_WAVES = {"spacing": 0.7}, 1.7  # together too steep for the SLM; each alone is not
SWITCHES = int(os.environ.get("OVWS_SWITCHES", "60"))
COARSE, FINE = {"subapertures_across": 3}, {"subapertures_across": 5}
EXAMPLE = ROOT / "proto" / "python" / "examples" / "adapt_lattice.py"
PYTHON = bench_module.find_programs().parent / "python"


class Lattices(BenchCase):
    small = True
    daemon_config = {"camera": {"exposure_us": 700.0}, "state": {"directory": "state"}}

    def hide(self, modes):
        self.twin.call("twin.set", {"aberration": [{"j": j, "waves": waves} for j, waves in modes.items()]})

    def scintillate(self, seed):
        self.twin.call("twin.set", {"scintillation": seed and {"variance": 0.8, "scale_pupils": 0.2, "seed": seed}})

    def prepare(self, *lattices, **more):
        return self.run_job("lattice.prepare", {"lattices": list(lattices), "frames": 20} | more)["result"]["lattices"]

    def prepare_both(self):
        return self.prepare({"name": "fine"}, {"name": "coarse", "sensor": COARSE})

    def listed(self):
        return {one["name"]: one for one in self.call("lattice.list")["lattices"]}

    def sensor(self):
        """All that a job must leave as it was."""
        sensor = {key: value for key, value in self.call("sensor.get").items() if key != "hologram_id"}
        camera = self.call("camera.get")["settings"]
        return sensor, camera["exposure_us"], camera["gain_db"], self.call("aberration.get")["modes"], self.call("correction.get")["modes"]

    def switch(self, name, stream):
        """Uses a lattice; returns its first valid frame, and the number of frames before it that were not valid."""
        stream.drain()
        lost = 0
        used = self.call("lattice.use", {"name": name})
        for message in iter(lambda: stream.next(PATIENCE_S), None):
            if message["hologram_id"] == used["hologram_id"] and message["valid"]:
                return message, lost
            lost += not message["valid"]
        self.fail("no valid frame")

    def check_truth(self, stream, name, hidden):
        def is_true():
            frames = self.settled_frames(stream, 20, self.call("sensor.get")["hologram_id"])
            error = statistics.median(sum((value - hidden.get(j, 0.0)) ** 2 for j, value in zip(frame["j"], frame["coefficients"]) if j > 2) ** 0.5 for frame in frames)
            print(f"\n  {name}: {frames[-1]['tracked']} spots, {len(frames[-1]['j'])} modes, error {error:.5f} wave")
            return error < BOUND_WAVES
        wait_for(is_true, what=f"the hidden modes by the lattice {name}")

    def test_two_lattices_are_prepared_and_switched_between(self):
        self.call("correction.set", CORRECTION)
        before = self.sensor()
        prepared = self.prepare_both()
        self.assertEqual(self.sensor(), before)
        self.assertEqual([(one["name"], one["subapertures"], one["calibrated"]) for one in prepared], [("fine", 19, False), ("coarse", 7, False)])
        self.assertLess(prepared[1]["exposure_us"], 0.5 * prepared[0]["exposure_us"])  # larger subapertures give brighter spots
        self.assertEqual({name: (one["in_use"], one["usable"], one["reason"]) for name, one in self.listed().items()},
                         {"fine": (True, True, None), "coarse": (False, True, None)})
        stream = self.stream("wavefront")
        self.hide(HIDDEN)
        losts = []
        for name in ("coarse", "fine") * 3:
            frame, lost = self.switch(name, stream)
            losts.append(lost)
            self.assertEqual(frame["tracked"], self.listed()[name]["subapertures"])
            self.assertTrue(self.listed()[name]["in_use"])
            self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], self.listed()[name]["exposure_us"])
            self.assertEqual(self.sensor()[4], before[4])
        print(f"\n  switch: {statistics.median(losts)} frames not valid")
        for name in ("coarse", "fine"):
            self.switch(name, stream)
            self.check_truth(stream, name, HIDDEN)
        self.check_restart(stream)
        self.check_removal()

    def check_restart(self, stream):
        listed = self.listed()
        self.bench.stop("ovwsd")
        self.client.close()
        self.start_daemon()
        self.wait_until("running")
        self.assertEqual({name: one | {"in_use": None} for name, one in self.listed().items()}, {name: one | {"in_use": None} for name, one in listed.items()})
        self.call("correction.set", CORRECTION)  # it was part of the references, and does not survive a restart
        self.switch("coarse", stream)
        self.check_truth(stream, "coarse, after a restart", HIDDEN)

    def check_removal(self):
        self.call("reference.clear")  # that of the coarse lattice, which is in use
        self.assertEqual((self.listed()["coarse"]["usable"], "lattice.prepare" in self.listed()["coarse"]["reason"]), (False, True))
        self.call("lattice.use", {"name": "fine"})
        before = self.sensor()
        self.assertEqual(self.refused("lattice.use", {"name": "coarse"}).data["field"], "name")
        self.assertEqual(self.sensor(), before)
        self.assertEqual([one["name"] for one in self.call("lattice.remove", {"name": "coarse"})["lattices"]], ["fine"])
        for method in ("lattice.use", "lattice.remove"):
            self.assertIn("no prepared lattice", str(self.refused(method, {"name": "coarse"})))
        self.assertEqual(self.sensor(), before)

    def test_bad_input_changes_nothing(self):
        before = self.sensor()
        fine = {"name": "fine"}
        for lattices, field in (([], "lattices"), ([fine, fine], "lattices"), ([{"name": "Fine"}], "lattices[0].name"), ([{"sensor": COARSE}], "lattices[0].name"),
                                ([fine, {"name": "b", "sensor": {"subapertures_across": 0}}], "lattices[1].sensor.subapertures_across"),
                                ([fine, {"name": "b", "sensor": {"chargee": 1}}], "lattices[1].sensor.chargee"),
                                ([fine, {"name": "b", "sensor": {"spacing": 0.05}}], "lattices[1].sensor.spacing"),
                                ([{"name": f"n{k}"} for k in range(9)], "lattices")):
            with self.subTest(lattices=lattices):
                self.assertEqual(self.refused("lattice.prepare", {"lattices": lattices}).data["field"], field)
        self.assertEqual((self.sensor(), self.listed()), (before, {}))
        self.take_reference(20)
        self.prepare_both()
        self.close_loop()
        self.assertIn("loop", str(self.refused("lattice.use", {"name": "coarse"})))
        self.assertIn("loop", str(self.refused("lattice.prepare", {"lattices": [fine]})))
        self.assertTrue(self.call("loop.get")["closed"])
        self.call("loop.open", {"keep": False})
        self.assertIn("8", str(self.refused("lattice.prepare", {"lattices": [{"name": f"n{k}"} for k in range(7)]})))

    def test_a_switch_is_no_stale_reference(self):
        self.prepare_both()
        events = self.stream("event")
        for name in ("fine", "coarse", "fine", "coarse"):
            self.call("lattice.use", {"name": name})
        self.call("camera.set", {"gain_db": 1.0})
        told = []
        while not told or told[-1]["data"]["stale"] != ["gain_db"]:
            event = events.next(PATIENCE_S)
            self.assertIsNotNone(event, told)
            if event["topic"] == "event" and "stale" in (event["data"] or {}):
                told.append(event)
        # The fine lattice was in use, with another exposure than that of its new reference.
        self.assertEqual([event["data"]["stale"] for event in told], [[], ["gain_db"]])

    def test_a_refused_switch_changes_no_exposure(self):
        self.prepare_both()
        self.call("lattice.use", {"name": "coarse"})
        self.call("reference.clear")
        exposure_us = {name: one["exposure_us"] for name, one in self.listed().items()}
        stream = self.stream("wavefront")
        self.switch("fine", stream)
        for _ in range(5):
            self.assertIn("lattice.prepare", str(self.refused("lattice.use", {"name": "coarse"})))
        frames = [stream.next(PATIENCE_S) for _ in range(30)]
        self.assertEqual({frame["exposure_us"] for frame in frames}, {exposure_us["fine"]})

    def test_until_it_is_shown_nobody_else_changes_the_bench(self):
        self.prepare_both()
        other, used = Client(), []
        self.addCleanup(other.close)
        use = threading.Thread(target=lambda: used.append(other.call("lattice.use", {"name": "coarse"})))
        refusal = "being taken into use"

        def busy():
            try:
                self.call("aberration.set", {"modes": []})
            except ClientError as error:
                return refusal in str(error)
        with thread_holder.held(self.bench.process("ovwsd").pid, "camera"):  # the switch waits for it
            use.start()
            self.addCleanup(use.join)
            wait_for(busy, what="the switch")
            for method, params in (("camera.set", {"exposure_us": 900.0}), ("camera.select", {"id": "other"}), ("sensor.set", {"charge": 1}),
                                   ("config.save", {}), ("lattice.use", {"name": "fine"}), ("reference.clear", {}), ("loop.close", {})):
                self.assertIn(refusal, str(self.refused(method, params)), method)
        use.join()
        coarse = self.listed()["coarse"]
        self.assertTrue(coarse["in_use"])
        self.assertEqual(used[0]["exposure_us"], coarse["exposure_us"])
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], coarse["exposure_us"])
        self.call("camera.set", {"exposure_us": 900.0})

    def test_switches_undo_no_change_that_was_accepted(self):
        """Clients set what a lattice has and what it leaves, at random moments of each switch."""
        self.prepare_both()
        other, choose = Client(), random.Random(6)
        self.addCleanup(other.close)
        exposure_us = {name: one["exposure_us"] for name, one in self.listed().items()}
        duration_s, accepted, busy = 0.02, 0, 0
        for k in itertools.count():
            if k >= SWITCHES and accepted and busy or k >= 10 * SWITCHES:
                break
            name = ("fine", "coarse")[k % 2]
            exposed_us, tilted = 1000.0 + k, {"modes": [{"j": 2, "waves": 0.001 * (1 + k % 9)}]}
            changes = {"camera.set": {"exposure_us": exposed_us}, "aberration.set": tilted, "correction.set": tilted,
                       "slm.set": {"settle_ms": 10.0 + k % 7}, "refine.set": {"rate_hz": 1.0 + k % 5}}
            method, params = choose.choice(list(changes.items()))
            ended_s = []
            begun_s = time.monotonic()
            switch = threading.Thread(target=lambda name=name: ended_s.append(other.call("lattice.use", {"name": name}) and time.monotonic()))
            switch.start()
            time.sleep(choose.uniform(0.0, 1.5 * duration_s))
            asked_s = time.monotonic()
            try:
                self.call(method, params)
                accepted += 1
            except ClientError as error:
                self.assertIn("being taken into use", str(error))
                busy, method = busy + 1, None
            switch.join()
            self.assertTrue(ended_s, name)
            duration_s = ended_s[0] - begun_s
            used_us = self.call("camera.get")["settings"]["exposure_us"]
            expected_us = {exposure_us[name]}
            if method == "camera.set":
                expected_us = {exposed_us} if asked_s > ended_s[0] else {exposed_us, exposure_us[name]}
            self.assertIn(used_us, expected_us)
            self.assertTrue(self.listed()[name]["in_use"])
            if method in ("aberration.set", "correction.set"):
                self.assertEqual(self.call(method.replace("set", "get"))["modes"][0]["waves"], tilted["modes"][0]["waves"])
            elif method in ("slm.set", "refine.set"):
                (key, value), = params.items()
                self.assertEqual(self.call("config.get")[method.partition(".")[0]][key], value)
        print(f"\n  {k} switches: {accepted} changes accepted, {busy} refused, none undone")
        self.assertGreater(accepted, 0)
        self.assertGreater(busy, 0)

    def test_a_mode_count_is_checked_once(self):
        """The check renders spots in the thread that shows the loop's holograms. What the thread computes, in CPU time, tells it apart:
        sensor.set checks."""
        thread = thread_holder.thread_id(self.bench.process("ovwsd").pid, "prepare")
        schedstat = Path(f"/proc/{thread}/schedstat")

        def cpu_ms(method, params=None):
            before = int(schedstat.read_text().split()[0])
            self.call(method, params)
            return 1e-6 * (int(schedstat.read_text().split()[0]) - before)

        checked_ms = cpu_ms("sensor.set", {"mode_count": 30})
        self.prepare({"name": "fine"}, {"name": "more", "sensor": {"mode_count": 40}}, {"name": "coarse", "sensor": COARSE | {"mode_count": None}})
        listed_ms = [cpu_ms("lattice.list") for _ in range(5)]
        used_ms = [cpu_ms("lattice.use", {"name": name}) for _ in range(3) for name in ("fine", "more")]
        print(f"\n  CPU time: checked {checked_ms:.1f} ms, listed {listed_ms}, used {used_ms}")
        self.assertLess(max(min(listed_ms), min(used_ms)), 0.3 * checked_ms)

    def test_an_aberration_or_an_operator_that_the_job_replaces_does_not_hinder_it(self):
        self.call("sensor.set", {"tracker": "lg"})
        self.call("aberration.set", {"modes": [{"j": 4, "waves": STEEP_WAVES}]})
        steep = {"name": "steep", "sensor": COARSE | STEEP | {"operator": "measured"}}
        self.assertEqual([one["calibrated"] for one in self.prepare(steep, calibrate=True, frames=8)], [True])
        self.assertIn("too steep", self.listed()["steep"]["reason"])
        self.call("aberration.clear")
        self.call("lattice.use", {"name": "steep"})

    def test_a_cancelled_job_leaves_the_sensor_and_what_it_has_finished(self):
        self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.05}]})
        before = self.sensor()
        job = self.call("lattice.prepare", {"lattices": [{"name": "coarse", "sensor": COARSE}, {"name": "slow"}], "frames": 300})["job"]
        wait_for(lambda: "coarse" in self.listed(), what="the first lattice")
        self.assertEqual(self.call("job.cancel", {"job": job})["state"], "cancelled")
        wait_for(lambda: self.call("system.status")["state"] == "running", what="the end of the job")
        self.assertEqual(self.sensor(), before)
        self.assertEqual({name: one["usable"] for name, one in self.listed().items()}, {"coarse": True})

    def test_a_fault_in_the_job_leaves_the_sensor(self):
        before = self.sensor()
        self.twin.call("twin.set", {"peak_electrons": 1e-3})
        job = self.call("lattice.prepare", {"lattices": [{"name": "dark", "sensor": COARSE}]})["job"]
        ended = self.job_ended(job)
        print(f"\n  {ended['error']}")
        self.assertEqual(ended["state"], "failed")
        self.assertIn("lattice dark", ended["error"]["message"])
        self.assertEqual((self.sensor(), self.listed()), (before, {}))

    def test_each_lattice_has_its_calibration(self):
        self.call("sensor.set", {"tracker": "lg"})
        before = self.sensor()
        self.prepare({"name": "fine"}, {"name": "coarse", "sensor": COARSE}, calibrate=True, frames=8)
        self.assertEqual(self.sensor()[1:], before[1:])
        stream = self.stream("wavefront")
        self.hide({3: 0.02, 4: -0.015})
        for name in ("coarse", "fine"):
            self.switch(name, stream)
            self.assertEqual(self.call("sensor.get")["operator_in_force"], "measured")
            self.assertTrue(self.listed()[name]["calibrated"])
            self.check_truth(stream, name + ", calibrated", {3: 0.02, 4: -0.015})
        self.call("calibration.clear")  # of the lattice in use
        self.call("lattice.use", {"name": "coarse"})
        error = self.refused("lattice.use", {"name": "fine"})
        self.assertEqual(error.data["field"], "name")
        for reason in (str(error), self.listed()["fine"]["reason"]):
            self.assertRegex(reason, 'calibration.*lattice.prepare and "calibrate": true')
            self.assertNotIn("calibration.run", reason)
        self.hide({})
        self.prepare({"name": "fine", "sensor": {"subapertures_across": 5}}, calibrate=True, frames=8)
        self.call("lattice.use", {"name": "fine"})

    def test_the_example_goes_to_the_coarse_lattice_and_back(self):
        environment = os.environ | {"PYTHONPATH": f"{PYTHON}:{os.environ.get('PYTHONPATH', '')}"}
        example = subprocess.Popen(["/usr/bin/python3", EXAMPLE, "--window", "60", "--hold", "0.5"], env=environment,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(example.stdout.close)
        self.addCleanup(example.wait)
        self.addCleanup(example.kill)
        wait_for(lambda: self.listed().get("coarse"), 2 * PATIENCE_S, "the prepared lattices")
        seeds, stream = iter(range(1, 10**6)), self.stream("wavefront")

        def flicker():
            """Ten frames of a new screen. The twin sends none while it renders one, so that there must be a pause."""
            self.scintillate(next(seeds))
            begun_ns, seen = time.time_ns(), 0
            while seen < 10:
                message = next_message(stream)
                seen += message["t_device_ns"] > begun_ns
            self.assertIsNone(example.poll(), "the example has ended")
            return self.listed()["coarse"]["in_use"]
        wait_for(flicker, 2 * PATIENCE_S, "the coarse lattice")
        self.scintillate(None)
        wait_for(lambda: self.listed()["fine"]["in_use"], 2 * PATIENCE_S, "the fine lattice")
        lines = [example.stdout.readline() for _ in range(2)]
        print("\n ", *lines)
        self.assertRegex("".join(lines), "lattice coarse\n.*lattice fine\n")


if __name__ == "__main__":
    main()
