"""Faults of the SLM's display on a desktop: reported as a fault, no valid frames meanwhile, and full recovery afterwards."""
import ctypes
import os
import signal
import subprocess
import time

from case import PATIENCE_S, BenchCase, main, message_since, next_message, wait_for

MODE, WAVES = 3, 0.2


class WindowOnTop:
    """A plain window of another X client over the SLM's output."""

    def __init__(self, display):
        self._x = ctypes.CDLL("libX11.so.6")
        self._x.XOpenDisplay.restype = ctypes.c_void_p
        self._server = ctypes.c_void_p(self._x.XOpenDisplay(display.encode()))
        x = self._x
        x.XDefaultRootWindow.restype = x.XCreateSimpleWindow.restype = ctypes.c_ulong
        self._window = x.XCreateSimpleWindow(self._server, ctypes.c_ulong(x.XDefaultRootWindow(self._server)), 2000, 100, 400, 300, 0,
                                             ctypes.c_ulong(0), ctypes.c_ulong(0xFFFFFF))
        x.XStoreName(self._server, ctypes.c_ulong(self._window), b"letter")
        x.XMapRaised(self._server, ctypes.c_ulong(self._window))
        x.XSync(self._server, 0)

    def close(self):
        self._x.XCloseDisplay(self._server)


class DisplayFaults(BenchCase):
    def setUp(self):
        super().setUp()
        self.take_reference()
        self.call("aberration.set", {"modes": [{"j": MODE, "waves": WAVES}]})
        self.frames = self.stream("wavefront")
        self.events = self.stream("event")
        self.check_measures()
        self.pid = self.bench.process("ovwsd").pid

    def xrandr(self, *arguments):
        subprocess.run(["xrandr", "-display", self.bench.display, *arguments], check=True, capture_output=True)

    def check_measures(self):
        """Checks that new frames measure the introduced aberration."""
        found = self.frames_from_now(self.frames, 10)
        read = [frame["coefficients"][frame["j"].index(MODE)] for frame in found]
        self.assertLess(abs(sum(read) / len(read) - WAVES), 0.02)

    def check_fault(self, *words):
        """Checks that status and an event report the fault, that no frame is valid, and that the daemon runs."""
        status = wait_for(lambda: (now := self.call("system.status"))["slm"]["fault"] and now, what="the fault")
        print("\n ", status["slm"]["fault"])
        for word in words:
            self.assertIn(word, status["slm"]["fault"])
        event = wait_for(lambda: (event := self.events.next(1.0)) and event["kind"] == "slm" and event["severity"] == "error" and event, what="the event")
        for frame in [message_since(self.frames, event["t_ns"]), *(next_message(self.frames) for _ in range(19))]:
            self.assertFalse(frame["valid"] or frame["settled"])

    def check_over(self):
        wait_for(lambda: (now := self.call("system.status"))["state"] == "running" and not now["slm"]["fault"], what="the end of the fault")
        self.check_measures()
        self.assertEqual(self.bench.process("ovwsd").pid, self.pid)
        self.assertTrue(self.bench.process("ovwsd").alive())
        self.assertEqual(self.call("slm.verify")["differing_pixels"], 0)

    def test_the_x_server_is_killed_and_started_again(self):
        number = int(self.bench.display[1:])
        self.bench.process("xorg").popen.send_signal(signal.SIGKILL)
        self.bench.stop("xorg")
        self.check_fault("X server")
        self.bench.start_display(number)
        self.check_over()

    def test_the_output_is_switched_off_and_on(self):
        self.xrandr("--output", "DUMMY1", "--off")
        self.check_fault("switched off")
        self.xrandr("--output", "DUMMY1", "--mode", "1280x768", "--pos", "1920x0")
        self.check_over()

    def test_the_mode_is_changed_and_put_back(self):
        self.xrandr("--output", "DUMMY1", "--mode", "1024x768")
        self.check_fault("1024x768", "1280x768")
        self.xrandr("--output", "DUMMY1", "--mode", "1280x768")
        self.check_over()

    def test_it_ends_though_the_server_stops_answering_just_then(self):
        server = self.bench.process("xorg").pid
        self.addCleanup(os.kill, server, signal.SIGCONT)
        for delay_s in (0.0, 0.005, 0.02):
            daemon = self.bench.process("ovwsd").popen
            os.kill(server, signal.SIGSTOP)
            time.sleep(delay_s)
            daemon.terminate()
            self.assertEqual(daemon.wait(PATIENCE_S), 0)  # how soon: tests/bench/service
            os.kill(server, signal.SIGCONT)
            self.bench.stop("ovwsd")
            self.client.close()
            self.start_daemon()
            self.wait_until("running")

    def test_a_window_on_top_is_reported_and_covered(self):
        before = self.call("system.status")["counters"]["display_faults"]
        window = WindowOnTop(self.bench.display)
        event = wait_for(lambda: (found := self.events.next(1.0)) and "letter" in found["text"] and found, what="the event")
        print("\n ", event["text"])
        self.assertEqual((event["kind"], event["severity"]), ("slm", "error"))
        self.check_over()  # now the SLM's window is on top
        window.close()
        self.check_over()
        self.assertGreater(self.call("system.status")["counters"]["display_faults"], before)


if __name__ == "__main__":
    main()
