"""An unplugged camera reconnects automatically; test_camera_killed counts the frames that it did not send."""
import time

from case import BenchCase, ClientError, main, message_since, wait_for


class Unplug(BenchCase):
    def incomplete(self):
        return self.call("system.status")["counters"]["frames_incomplete"]

    def test_frames_come_again_however_shortly_the_camera_was_unplugged(self):
        stream = self.stream("wavefront")
        for seconds in (0.1, 0.3, 0.6, 3.0):
            with self.subTest(seconds=seconds):
                incomplete = self.incomplete()
                self.twin.call("twin.fault", {"kind": "incomplete", "seconds": 9})  # the camera's properties change while it disconnects
                wait_for(lambda: self.incomplete() > incomplete, what="an incomplete frame")
                self.twin.call("twin.fault", {"kind": "unplug", "seconds": seconds})
                plugged_ns = time.time_ns() + seconds * 1e9
                frame = wait_for(lambda: (m := stream.next(1.0)) and m["t_arrival_ns"] > plugged_ns and m, what="frames")
                print(f"\n  {seconds} s: frames again after {seconds + 1e-9 * (frame['t_arrival_ns'] - plugged_ns):.1f} s")
                self.assertTrue(self.twin.call("twin.get")["camera"]["plugged"])

    def test_the_closed_loop_waits_for_a_camera_that_was_unplugged_shortly(self):
        self.take_reference(10)
        self.close_loop()
        wait_for(lambda: self.call("loop.get")["steps"] > 3, what="steps")
        reconnects = self.call("system.status")["counters"]["camera_reconnects"]
        self.twin.call("twin.fault", {"kind": "unplug", "seconds": 0.5})
        wait_for(lambda: self.call("system.status")["counters"]["camera_reconnects"] > reconnects, what="the reconnection")
        steps = self.call("loop.get")["steps"]
        wait_for(lambda: not self.call("loop.get")["closed"] or self.call("loop.get")["steps"] > steps + 3, what="steps again")
        report = self.call("loop.get")
        self.call("loop.open")
        self.assertTrue(report["closed"], report)

    def test_a_set_while_the_camera_loses_power_keeps_the_settings(self):
        mine = {"exposure_us": 300.0, "frame_rate_hz": 60.0, "pixel_format": "Mono12", "gain_db": 3.0, "roi": {"x": 0, "y": 16, "width": 512, "height": 480}}
        mine = self.call("camera.set", mine)["applied"]
        stream = self.stream("wavefront")
        for gain_db in (5.0, 6.0):
            with self.subTest(gain_db=gain_db):
                self.twin.call("twin.fault", {"kind": "unplug", "seconds": 2.2})
                while stream.next(0.25) is not None:  # by then the last write attempt reaches the camera again
                    pass
                try:
                    mine = {**mine, "gain_db": self.call("camera.set", {"gain_db": gain_db})["applied"]["gain_db"]}
                except ClientError as error:  # still disconnected: nothing was set
                    print(f"\n  {error}")
                wait_for(lambda: self.twin.call("twin.get")["camera"]["plugged"], what="a camera that is back")
                message_since(stream, time.time_ns())
                settings = self.call("camera.get")["settings"]
                self.assertEqual({key: settings[key] for key in mine}, mine)
                camera = self.twin.call("twin.get")["camera"]
                self.assertEqual({key: camera[key] for key in ("exposure_us", "pixel_format", "roi")}, {key: mine[key] for key in ("exposure_us", "pixel_format", "roi")})


if __name__ == "__main__":
    main()
