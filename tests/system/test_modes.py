"""The stream measures an introduced aberration correctly: all modes, both signs, both kinds of sensor.

How soon the first settled frame comes is printed by tests/bench/settle.
"""
import statistics

from case import BenchCase, main

FRAMES = 10
OTHERS_WAVES = 0.02
LEAST_TRACKED = 19  # all


def within(wanted, measured):
    return abs(measured - wanted) <= 0.05 * abs(wanted) + 0.005


class Modes(BenchCase):
    daemon_config = {"stream": {"image_rate_hz": 0}}

    def measure(self, stream, j, waves):
        """Sets one mode; returns the mean coefficients."""
        stream.drain()
        answer = self.call("aberration.set", {"modes": [{"j": j, "waves": waves}]})
        frames = self.settled_frames(stream, FRAMES, answer["hologram_id"])
        for frame in frames:
            if frame["tracked"] < LEAST_TRACKED:
                print("lost spots:", {key: frame[key] for key in ("frame_id", "hologram_id", "tracked", "fit_residual_px", "latency_us")})
        self.tracked = min(frame["tracked"] for frame in frames)
        return {k: statistics.fmean(f["coefficients"][i] for f in frames) for i, k in enumerate(frames[0]["j"])}

    def check_all_modes(self, charge, tracker, others_waves=OTHERS_WAVES):
        self.call("aberration.clear")
        self.call("sensor.set", {"charge": charge, "tracker": tracker})
        self.call("camera.set", {"exposure_us": 2000.0 if charge else 500.0})  # a bright spot is four times as bright
        self.take_reference()
        stream = self.stream("wavefront")
        cases = [(j, sign * 0.2) for j in range(3, 15) for sign in (1, -1)] + [(3, 0.5)]
        print(f"\ncharge {charge}, {tracker}:   j  asked   found   largest other  spots")
        failures = []
        for j, waves in cases:
            found = self.measure(stream, j, waves)
            other_j, other = max(((k, v) for k, v in found.items() if k != j), key=lambda item: abs(item[1]))
            print(f"{'':>{len(tracker) + 11}} {j:4d} {waves:+6.2f} {found[j]:+8.4f}   {other:+8.4f} (j={other_j:2d})  {self.tracked:2d}/19")
            if not (within(waves, found[j]) and abs(other) < others_waves and self.tracked >= LEAST_TRACKED):
                failures.append((j, waves, found[j], other_j, other))
        self.assertEqual(failures, [])

    def test_vortices_with_lg(self):
        self.check_all_modes(1, "lg")

    def test_vortices_with_fit(self):
        self.check_all_modes(1, "fit")

    def test_shack_hartmann_with_fit(self):
        self.check_all_modes(0, "fit")

    def test_shack_hartmann_with_thresholded_centroid(self):
        self.check_all_modes(0, "thresholded")

    def test_shack_hartmann_with_weighted_centroid(self):
        self.check_all_modes(0, "weighted")

    def test_shack_hartmann_with_plain_centroid(self):
        # Noise and neighbours' light bias a centroid over a fixed region towards the region's centre.
        self.check_all_modes(0, "centroid", others_waves=0.03)


if __name__ == "__main__":
    main()
