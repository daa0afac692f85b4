"""The tracker `fit`: frames are measured from all pixels of their spots, also after changes, in jobs and in replays."""
import itertools
import json
import math
import random
import statistics
import time

from case import PATIENCE_S, BenchCase, main, message_since, wait_for
from ovws_client.recording import Recording


def draw(rng, rms, last=18):
    """Random modes of this RMS together, j = 3 to `last`: {j: waves}."""
    modes = {j: rng.gauss(0.0, 1.0) for j in range(3, last + 1)}
    scale = rms / sum(waves * waves for waves in modes.values()) ** 0.5
    return {j: scale * waves for j, waves in modes.items()}


def error(frame, modes):
    return sum((value - modes.get(j, 0.0)) ** 2 for j, value in zip(frame["j"], frame["coefficients"])) ** 0.5


def is_fitted(frame):
    return frame["sigma"][0] is not None


class Fit(BenchCase):
    small = True
    daemon_config = {"tracking": {"tracker": "fit"}, "record": {"directory": "recordings"}}

    def show(self, modes):
        return self.call("aberration.set", {"modes": [{"j": j, "waves": waves} for j, waves in modes.items()]})["hologram_id"]

    def fitted(self, stream, count, hologram_id, timeout_s=PATIENCE_S):
        """The next `count` fitted frames in a row of this hologram, and the valid ones of it that came before."""
        end, before, found = time.monotonic() + timeout_s, [], []
        while len(found) < count:
            self.assertLess(time.monotonic(), end, f"{len(found)} fitted frames after {len(before)} other valid ones")
            for frame in self.settled_frames(stream, 1, hologram_id, timeout_s):
                if is_fitted(frame):
                    found.append(frame)
                else:
                    before += [*found, frame]
                    found.clear()
        return found, before

    def well_fitted(self, stream, modes, most):
        """Shows these modes; returns the first 20 fitted frames in a row with a median error below `most` and a small standard error, and
        all valid frames before: templates are rendered again until they leave no more than noise."""
        hologram_id, end, before = self.show(modes), time.monotonic() + PATIENCE_S, []
        while True:
            frames, others = self.fitted(stream, 20, hologram_id)
            before += others
            median = statistics.median(error(frame, modes) for frame in frames)
            sigma = statistics.median(math.hypot(*frame["sigma"]) for frame in frames)
            if median < most and sigma < 0.005:
                print(f"\n  error {median:.5f} wave, standard error {sigma:.5f}; {len(before)} frames before")
                return frames, before
            self.assertLess(time.monotonic(), end, f"the error is {median:.5f} wave, the standard error {sigma:.5f}")
            before += frames

    def test_every_wavefront_is_measured_from_all_pixels(self):
        self.take_reference(50)
        stream, rng = self.stream("wavefront"), random.Random(3)
        for rms in (0.0, 0.05, 0.3, 0.3, 0.6, 0.0):
            with self.subTest(rms=rms):
                modes = draw(rng, rms)
                frames, before = self.well_fitted(stream, modes, 0.01)  # the SLM shows 256 levels
                self.assertEqual({frame["tracked"] for frame in frames}, {19})
                self.assertLess(max(error(frame, modes) for frame in before + frames), 0.15)

    def test_spots_determine_more_modes_than_their_positions(self):
        refusal = self.refused("sensor.set", {"mode_count": 65}).data
        print(f"\n  {refusal['reason']}")
        self.assertEqual(refusal["field"], "mode_count")
        self.assertEqual(self.call("sensor.set", {"mode_count": 44})["applied"]["mode_count"], 44)
        self.take_reference(50)
        stream, rng = self.stream("wavefront"), random.Random(6)
        self.assertEqual(self.call("sensor.get")["modes_j"], list(range(1, 45)))
        for rms in (0.0, 0.1, 0.3):
            with self.subTest(rms=rms):
                _, before = self.well_fitted(stream, draw(rng, rms, 44), 0.015)
                self.assertEqual([frame for frame in before if not is_fitted(frame)], [])  # positions do not determine them
        self.assert_replays_the_same("44", [draw(rng, 0.05, 44)])
        self.call("sensor.set", {"mode_count": None})

    def test_weak_air_is_measured_from_all_pixels(self):
        """Air has modes above the measured ones, too; the standard errors hold what those change. It stands still, so that a busy machine
        measures the same air."""
        self.call("sensor.set", {"mode_count": 44})
        self.take_reference(50)
        stream, hologram_id = self.stream("wavefront"), self.call("system.status")["slm"]["hologram_id"]
        squares, variances, valid = [], [], 0
        for seed in range(5, 17):
            self.twin.call("twin.set", {"turbulence": {"rms_waves": 0.02, "speed_pupils_per_s": 0, "outer_scale_pupils": 4, "seed": seed, "tilt": False}})
            message_since(stream, time.time_ns())
            self.fitted(stream, 1, hologram_id)
            for frame in [stream.next(PATIENCE_S) for _ in range(10)]:
                valid += frame["valid"]
                if not frame["valid"]:
                    continue
                air = self.twin.call("twin.get", {"at_ns": frame["t_device_ns"]})["turbulence"]["modes"]
                known = range(3, len(air))  # the twin tells the first modes of its air
                coefficients, sigma = (dict(zip(frame["j"], frame[name])) for name in ("coefficients", "sigma"))
                squares.append(sum((coefficients[j] - air[j]) ** 2 for j in known))
                variances.append(sum(sigma[j] ** 2 for j in known))
        off, sigma = statistics.mean(squares) ** 0.5, statistics.mean(variances) ** 0.5
        print(f"\n  0.02 wave RMS: {valid} of 120 frames valid, error {off:.4f} wave, standard error {sigma:.4f}")
        self.assertGreater(valid, 115)
        self.assertLess(off, 0.015)
        self.assertLess(abs(off / sigma - 1.0), 0.6)
        self.assert_replays_the_same("air", [])
        self.twin.call("twin.set", {"turbulence": None})
        self.call("sensor.set", {"mode_count": None})

    def test_after_a_sudden_wavefront_no_frame_is_valid_by_positions_only(self):
        self.take_reference(50)
        stream, rng = self.stream("wavefront"), random.Random(5)
        hologram_id = self.call("system.status")["slm"]["hologram_id"]
        self.fitted(stream, 5, hologram_id)
        for rms in (0.3, 0.6, 0.0):
            with self.subTest(rms=rms):
                modes = draw(rng, rms)
                self.twin.call("twin.set", {"aberration": [{"j": j, "waves": waves} for j, waves in modes.items()]})
                changed_ns = time.time_ns()
                frames = []
                while sum(map(is_fitted, frames)) < 20:
                    frame = self.settled_frames(stream, 1, hologram_id)[0]
                    if frame["valid"] and frame["t_device_ns"] > changed_ns:
                        frames.append(frame)
                errors = [error(frame, modes) for frame in frames]
                print(f"\n  {rms:.2f} wave: valid after {1e-9 * (frames[0]['t_device_ns'] - changed_ns):.2f} s; largest error {max(errors):.4f} wave")
                self.assertTrue(all(map(is_fitted, frames)))
                self.assertLess(max(errors), 0.03)

    def test_a_calibration_measures_the_templates(self):
        self.take_reference(50)
        found = self.run_job("calibration.run", {})["result"]
        self.assertTrue(found["in_force"])
        self.assertEqual(found["template_modes_j"], list(range(1, 19)))
        self.assertEqual((found["disagreement"], found["disagreement_reason"], found["dropped"], found["lost_spots"]), ("none", None, [], []))
        stream, rng = self.stream("wavefront"), random.Random(7)
        for rms, most in ((0.0, 0.003), (0.015, 0.004), (0.08, 0.004), (0.3, 0.01)):  # 0.08: rendered and corrected; 0.3: too far for that
            with self.subTest(rms=rms):
                self.well_fitted(stream, draw(rng, rms), most)
        names = map("measured-{}".format, itertools.count())
        def are_of_both_templates():
            self.show({})
            points = self.assert_replays_the_same(next(names), [draw(rng, 0.005), draw(rng, 0.08), {}])
            return {(point["measured"], len(point["corrected_at"])) for point in points} == {(True, 0), (False, 18)}
        wait_for(are_of_both_templates, what="a recording with the calibration's templates and those that it corrects")
        self.call("sensor.set", {"operator": "slopes"})

    def test_a_replay_gives_the_same_numbers(self):
        self.take_reference(50)
        rng = random.Random(4)
        self.assert_replays_the_same("18", [draw(rng, 0.05), draw(rng, 0.3)])

    def assert_replays_the_same(self, name, wavefronts):
        """Records frames of the hologram that is shown, and of each of the wavefronts; replays them."""
        stream, shown = self.stream("wavefront"), self.call("system.status")["slm"]["hologram_id"]
        self.fitted(stream, 5, shown)
        self.call("record.start", {"name": name})
        self.recorded_frames(20)
        for modes in wavefronts:
            self.fitted(stream, 40, self.show(modes))  # the first ones by the templates before
        self.call("record.stop")
        path = self.bench.directory / "recordings" / f"{name}.h5"
        done = self.run_ovws("--json", "replay", path)
        replayed = json.loads(done.stdout)
        print(f"\n  {replayed}")
        self.assertEqual(replayed["same"], replayed["replayed"], done.stderr)
        self.assertGreater(replayed["replayed"], 0.5 * replayed["frames"])
        with Recording(path) as run:
            return list(run.documents("operating_point"))


if __name__ == "__main__":
    main()
