"""Half a wave of hidden high orders splits spots: fit measures it all the same, and other trackers say that they cannot."""
import itertools
import random
import statistics
import time

from case import PATIENCE_S, PROGRAM_PATIENCE_S, BenchCase, main, wait_for
from losses import Account

RMS_WAVES = 0.5
FRAMES = 20


def random_modes(seed):
    drawn = random.Random(seed)
    modes = {j: drawn.gauss(0.0, 1.0) for j in range(3, 19)}
    scale = RMS_WAVES / sum(v * v for v in modes.values()) ** 0.5
    return {j: scale * v for j, v in modes.items()}


class Split(BenchCase):
    daemon_config = {"stream": {"image_rate_hz": 0}}
    hidden_at_ns = 0

    def hide(self, modes):
        self.twin.call("twin.set", {"aberration": [{"j": j, "waves": waves} for j, waves in modes.items()]})
        self.hidden_at_ns = time.time_ns()

    def settled(self, stream):
        """Settled frames exposed after the last change of the hidden aberration; frames in transit are skipped."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            message = stream.next(0.5)
            if message is not None and message["settled"] and message["t_device_ns"] > self.hidden_at_ns:
                yield message
        self.fail(f"no such frame within {PATIENCE_S} s: {self.call('system.status')['sensor']['invalid']}")

    def newest(self, stream, count=FRAMES):
        stream.drain()
        return list(itertools.islice(self.settled(stream), count))

    def error(self, frames, modes):
        self.assertTrue(all(frame["valid"] for frame in frames))
        found = [statistics.fmean(values) for values in zip(*(frame["coefficients"] for frame in frames))]
        return sum((value - modes.get(j, 0.0)) ** 2 for j, value in zip(frames[0]["j"], found)) ** 0.5

    def frames_right(self, stream, modes, within):
        """The newest frames, once they are all valid, fitted, and right within that error: templates of the wavefront before may measure
        the first ones."""
        def right():
            frames = self.newest(stream)
            fitted = all(frame["valid"] and frame["sigma"][0] is not None for frame in frames)
            return fitted and self.error(frames, modes) < within and frames
        return wait_for(right, what=f"frames right within {within} wave")

    def test_split_spots_are_measured_and_round_ones_again(self):
        self.take_reference()
        stream = self.stream("wavefront")
        account = Account(self.client, self.twin, self.stream("wavefront"))
        for modes in (*map(random_modes, (1, 2, 3)), {}):
            self.hide(modes)
            took_s, _ = self.frames_until_valid(stream)
            frames = self.frames_right(stream, modes, 0.005)
            print(f"\n  {len(modes)} modes: valid after {took_s:.2f} s, {min(f['tracked'] for f in frames)} of 19 spots, "
                  f"error of all modes {self.error(frames, modes):.4f} wave")
            account.hear()
        account.check(self)

    def test_bright_spots_found_in_their_wrong_half_are_refused_and_fit_sees_through(self):
        self.call("sensor.set", {"charge": 0, "tracker": "thresholded"})
        self.call("camera.set", {"exposure_us": 500.0})
        self.take_reference()
        stream = self.stream("wavefront")
        modes = random_modes(2)
        self.hide(modes)
        frames = self.newest(stream, 3)
        residuals = [frame["fit_residual_px"] for frame in frames]
        self.assertEqual([frame["valid"] for frame in frames], [False] * 3)
        self.assertEqual({value for frame in frames for value in [*frame["coefficients"], frame["rms_waves"]]}, {None})
        self.assertGreater(min(residuals), 0.045 * 12.55)
        said = wait_for(lambda: self.call("system.status")["sensor"]["invalid"])
        self.assertIn("fit", said["action"])
        self.hide({})
        self.call("sensor.set", {"tracker": "fit"})
        self.newest(stream, 1)  # none of the wavefront before is in transit
        self.take_reference()
        self.hide(modes)
        took_s, _ = self.frames_until_valid(stream)
        error = self.error(self.frames_right(stream, modes, 0.01), modes)
        print(f"\n  thresholded, wavefront 2: residual {max(residuals):.2f} px; {said['action']}: valid after {took_s:.2f} s, error of all modes {error:.4f} wave")

    def frames_until_valid(self, stream):
        """Seconds from the change of the hidden aberration to the first valid frame, by camera time stamps."""
        message = next(message for message in self.settled(stream) if message["valid"])
        return 1e-9 * (message["t_device_ns"] - self.hidden_at_ns), message

    def test_sudden_wavefronts_do_not_make_the_search_slower(self):
        """Twelve wavefronts, each as soon as a single search may have ended; then one stays for a while and is removed."""
        self.take_reference()
        stream = self.stream("wavefront")
        # All twelve on a quiet machine; again if it has become busier since the single searches.
        wait_for(lambda: self.measured_of_twelve(stream) >= 3, PROGRAM_PATIENCE_S, what="searches that end before the next wavefront")
        self.hide(random_modes(32))
        took_s, _ = self.frames_until_valid(stream)
        error = self.error(self.frames_right(stream, random_modes(32), 0.06), random_modes(32))
        self.newest(stream, 400)
        self.hide({})
        gone_s, frame = self.frames_until_valid(stream)
        print(f"  the next is after {took_s:.2f} s, error {error:.3f} wave; when it has gone after {gone_s:.2f} s")
        self.assertLess(self.error([frame], {}), 0.05)

    def measured_of_twelve(self, stream):
        alone_s = 0.0
        for seed in (17, 18, 19):
            self.hide(random_modes(seed))
            alone_s = max(alone_s, self.frames_until_valid(stream)[0])
        stay = max(70, int(150 * alone_s))  # frames, 100 a second
        seen, valid = 0, 0
        for seed in range(20, 32):
            self.hide(random_modes(seed))
            frames = self.newest(stream, stay)
            seen += any(frame["valid"] for frame in frames)
            valid += sum(frame["valid"] for frame in frames)
        print(f"\n  one search takes {alone_s:.2f} s; twelve wavefronts: {seen} measured, {valid} of {12 * stay} frames valid")
        return seen

    def test_why_no_frame_is_valid_is_said(self):
        self.take_reference()
        events = self.stream("event")
        invalid = lambda: self.call("system.status")["sensor"]["invalid"]  # noqa: E731
        wait_for(lambda: invalid() is None)
        self.twin.call("twin.set", {"peak_electrons": 0})
        said = wait_for(lambda: (now := invalid()) is not None and now["searches"] > 0 and now)
        self.assertEqual(said["reason"], "0 of 19 spots are found")
        self.assertIn("searched", said["action"])
        event = self.event(events, False)
        self.assertEqual((event["severity"], event["data"]["tracked"]), ("warning", 0))
        self.twin.call("twin.set", {"peak_electrons": 6000})
        self.assertEqual(self.event(events, True)["severity"], "info")
        wait_for(lambda: invalid() is None)

    def event(self, events, valid):
        return wait_for(lambda: (event := events.next(1.0)) and event["kind"] == "spots" and event["data"].get("valid") is valid and event,
                        what=f"an event that says valid: {valid}")


if __name__ == "__main__":
    main()
