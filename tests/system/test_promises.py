"""Promises to clients during changes: no wrong value is published as valid, and every request is answered."""
import json
import time

import zmq

from case import PATIENCE_S, BenchCase, main, message_since, next_message, wait_for

HALF = {"x": 128, "y": 128, "width": 256, "height": 256}
WHOLE = {"x": 0, "y": 0, "width": 512, "height": 512}


class Promises(BenchCase):
    def listen(self, frames):
        """Messages of frames exposed from now on."""
        stream = self.stream("wavefront")
        return [message_since(stream, time.time_ns()), *(next_message(stream) for _ in range(frames - 1))]

    def test_a_picture_that_is_no_sensor_is_never_settled(self):
        self.take_reference(20)
        self.call("slm.show", {"pattern": "flat"})
        for change in ({}, {"roi": HALF}, {"roi": WHOLE}):
            if change:
                self.call("camera.set", change)
            self.assertFalse(any(m["settled"] or m["valid"] for m in self.listen(100)), change)
        self.call("slm.show", {"pattern": "sensor"})
        self.settled_frames(self.stream("wavefront"), 10)

    def test_a_reference_holds_for_its_region_only(self):
        self.take_reference(20)
        self.call("camera.set", {"roi": {"x": 8, "y": 16, "width": 488, "height": 480}})
        self.assertFalse(self.call("system.status")["sensor"]["referenced"])
        self.assertFalse(any(m["valid"] for m in self.listen(50)))
        self.call("camera.set", {"roi": WHOLE})
        wait_for(lambda: self.call("system.status")["sensor"]["referenced"], what="the reference of before")
        self.settled_frames(self.stream("wavefront"), 10)

    def test_no_reference_of_saturated_spots(self):
        self.take_reference(20)
        before = self.call("reference.get")
        self.call("camera.set", {"exposure_us": 4000.0})
        wait_for(lambda: self.stream("spots").next(PATIENCE_S)["saturated"] == 1.0, what="saturated spots")
        job = self.call("reference.take", {"frames": 20})["job"]
        ended = self.job_ended(job)
        self.assertEqual((ended["state"], ended["error"]["data"]["field"]), ("failed", "camera.exposure_us"))
        self.assertRegex(ended["error"]["data"]["reason"], r"^\d+ % of the spots are saturated.*lower the exposure or the gain$")
        self.call("camera.set", {"exposure_us": 2000.0})
        self.assertEqual(self.call("reference.get"), before)

    def test_one_saturated_spot_is_accepted_and_reported(self):
        self.twin.call("twin.set", {"noise": "none"})
        self.call("camera.set", {"exposure_us": 2400.0})  # only the brightest spot saturates
        wait_for(lambda: 0.0 < self.stream("spots").next(PATIENCE_S)["saturated"] < 0.1, what="one saturated spot")
        events = self.stream("event")
        saturated = self.take_reference(20)["result"]["saturated_spots"]
        self.assertEqual(len(saturated), 1)
        event = wait_for(lambda: (message := events.next(1.0)) and message["kind"] == "reference" and message, what="the event")
        self.assertEqual((event["severity"], event["data"]["saturated_spots"]), ("warning", saturated))

    def test_no_reference_of_a_bench_that_moves_meanwhile(self):
        job = self.call("reference.take", {"frames": 400})["job"]
        wait_for(lambda: self.call("job.get", {"job": job})["progress"] > 0.2, what="the middle of the frames")
        self.twin.call("twin.set", {"aberration": [{"j": 3, "waves": 0.2}]})
        ended = self.job_ended(job)
        self.assertEqual(ended["state"], "failed")
        self.assertRegex(ended["error"]["data"]["reason"], r"moved by \d\.\d\d px RMS from the first to the second half of the reference")
        self.assertFalse(self.call("reference.get")["taken"])

    def test_a_reference_that_holds_an_introduced_aberration_is_asked_for_and_reported(self):
        wavefronts = self.stream("wavefront")
        self.call("aberration.set", {"modes": [{"j": 8, "waves": 0.3}]})
        error = self.refused("reference.take", {"frames": 20})
        self.assertIn("allow_aberration", str(error))
        self.assertIn("0.3000 wave RMS", str(error))
        self.assertEqual(self.take_reference(20, allow_aberration=True)["result"]["introduced_rms_waves"], 0.3)
        hologram = self.call("aberration.clear")["hologram_id"]
        for frame in self.settled_frames(wavefronts, 3, hologram):
            self.assertAlmostEqual(frame["rms_waves"], 0.3, delta=0.02)
            self.assertEqual(frame["reference_introduced_rms_waves"], 0.3)
        self.assertEqual(self.call("system.status")["sensor"]["reference_introduced_rms_waves"], 0.3)
        self.assertEqual(self.call("reference.get")["introduced_rms_waves"], 0.3)
        self.take_reference(20)
        self.assertEqual(self.call("system.status")["sensor"]["reference_introduced_rms_waves"], 0.0)
        self.assertEqual(self.call("reference.get")["introduced_rms_waves"], 0.0)

    def test_nothing_changes_under_a_job_and_a_cancelled_one_gives_all_free(self):
        self.take_reference(20)
        before = self.call("reference.get")
        job = self.call("reference.take", {"frames": 10000})["job"]
        for method, params in (("reference.clear", {}), ("reference.take", {}), ("camera.set", {"gain_db": 1.0}),
                               ("sensor.set", {"charge": 0}), ("aberration.clear", {}), ("slm.show", {"pattern": "flat"})):
            self.assertIn("job", str(self.refused(method, params)), method)
        self.assertEqual(self.call("job.cancel", {"job": job})["state"], "cancelled")
        self.wait_until("running")
        self.assertEqual(self.call("reference.get"), before)
        self.call("camera.set", {"gain_db": 1.0})
        self.call("reference.clear")
        self.assertIsNone(self.call("reference.get")["frames"])

    def test_every_lattice_has_as_many_modes_as_it_determines(self):
        self.call("camera.set", {"exposure_us": 700.0})  # with 4 across, subapertures are larger and spots 2.4 times as bright
        for grid, across in (("hexagonal", 4), ("hexagonal", 6), ("square", 4)):
            with self.subTest(grid=grid, across=across):
                self.call("sensor.set", {"grid": grid, "subapertures_across": across})
                self.take_reference(20)
                modes = self.call("system.status")["sensor"]["modes"]
                print(f"\n  {grid} {across}: {modes} modes")
                self.assertGreaterEqual(modes, 5)
                frames = self.settled_frames(self.stream("wavefront"), 10)
                self.assertEqual(len(frames[0]["coefficients"]), modes)

    def test_a_job_reports_its_quarters(self):
        stream = self.stream("event")
        self.run_job("reference.take", {"frames": 1000})  # a quarter takes seconds: the daemon may stand still meanwhile
        reported = []
        while not reported or reported[-1][0] == "running":
            message = next_message(stream)
            if message["kind"] == "job":
                reported.append((message["data"]["state"], message["data"]["progress"]))
        self.assertEqual(reported, [("running", 0.0), ("running", 0.25), ("running", 0.5), ("running", 0.75), ("done", 1.0)])

    def test_every_request_on_its_way_is_answered_when_the_daemon_ends(self):
        requests = 40
        socket = zmq.Context.instance().socket(zmq.DEALER)
        self.addCleanup(socket.close, 0)
        socket.connect("tcp://127.0.0.1:7702")
        for i in range(requests):
            params = {"modes": [{"j": 3, "waves": 0.01 * i}]}
            socket.send(json.dumps({"jsonrpc": "2.0", "id": i, "method": "aberration.set", "params": params}).encode())
        socket.send(json.dumps({"jsonrpc": "2.0", "id": requests, "method": "system.status"}).encode())
        replies = []
        while (reply := json.loads(socket.recv()))["id"] != requests:  # answered at once, when the daemon has all requests
            replies.append(reply)
        self.assertEqual(self.bench.stop("ovwsd"), 0)
        while len(replies) < requests and socket.poll(10_000):
            replies.append(json.loads(socket.recv()))
        done = sum("result" in reply for reply in replies)
        print(f"\n  {done} of {requests} carried out before the end, {len(replies) - done} refused with a reason")
        self.assertEqual(sorted(reply["id"] for reply in replies), list(range(requests)))
        for reply in replies:
            if "error" in reply:
                self.assertIn("stopping", reply["error"]["data"]["reason"])


if __name__ == "__main__":
    main()
