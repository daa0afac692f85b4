"""A dark subaperture, before and after the reference: it costs information but causes no error."""
import time

from case import BenchCase, main, message_since, wait_for

MODES = {4: 0.1, 5: -0.08, 8: 0.06}
PITCH_PX = 768 / 5


class Shade(BenchCase):
    daemon_config = {"stream": {"image_rate_hz": 0}}

    def shade(self, *discs):
        keys = ("x_px", "y_px", "radius_px", "transmission")
        self.twin.call("twin.set", {"shades": [dict(zip(keys, disc)) for disc in discs]})

    def error(self, found):
        return sum((waves - MODES.get(j, 0.0)) ** 2 for j, waves in found.items() if j > 2) ** 0.5

    def test_dark_before_the_reference_and_after_it(self):
        middle = (639.5, 383.5, 0.52 * PITCH_PX, 0.0)
        right = (639.5 + PITCH_PX, 383.5, 0.52 * PITCH_PX, 0.0)
        stream = self.stream("wavefront")
        for name, before, after in (("dark before", [middle], [middle]), ("dark after", [], [middle]), ("another one dark after", [middle], [middle, right]),
                                    ("half dark after", [], [(639.5 + 0.5 * PITCH_PX, 383.5, 0.5 * PITCH_PX, 0.0)])):
            with self.subTest(name):
                self.shade(*before)
                self.twin.call("twin.set", {"aberration": []})
                message_since(stream, time.time_ns())
                taken = self.take_reference()
                self.assertEqual(taken["result"]["lost_spots"], [9] if before else [])
                self.shade(*after)
                self.twin.call("twin.set", {"aberration": [{"j": j, "waves": waves} for j, waves in MODES.items()]})
                self.modes_when(stream, lambda modes: self.error(modes) < 0.02, name)
                wait_for(lambda: self.call("system.status")["sensor"]["invalid"] is None, what="valid frames")


if __name__ == "__main__":
    main()
