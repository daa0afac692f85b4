"""ovws watch on a terminal: the screen agrees with the stream, and the terminal is restored on exit."""
import os
import re
import shlex
import signal
import time

from case import PROGRAM_PATIENCE_S, BenchCase, main, wait_for
from terminal import Terminal

DRAWINGS = 40
LEFT_BY_THE_PAGE = b"\x1b[?1049l"  # xterm: leave the alternate screen


class Watch(BenchCase):
    def open(self, *arguments, **more):
        terminal = Terminal(self.ovws_command("watch", *arguments), **more)
        self.addCleanup(terminal.close)
        return terminal

    def wait_for_text(self, terminal, pattern):
        try:
            return wait_for(lambda: re.search(pattern, terminal.text()))
        except AssertionError:
            self.fail(f"no {pattern} on\n{terminal.text()}")

    def test_the_numbers_are_those_of_the_stream(self):
        self.take_reference(30)
        self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.25}, {"j": 7, "waves": -0.1}]})
        stream = self.stream("wavefront")
        self.settled_frames(stream, 5)
        terminal = self.open()
        self.wait_for_text(terminal, r"\bvalid\b.*")
        self.wait_for_text(terminal, r"published +\d+")
        shown = wait_for(lambda: self.paused(terminal), what="a pause at a valid frame")
        frame_id = self.frame_on(terminal)
        message = wait_for(lambda: (m := stream.next(1.0)) and m["frame_id"] == frame_id and m, what=f"frame {frame_id} in the stream")
        self.assertIn(f"spots {message['tracked']}/{message['subapertures']}", shown[1])
        self.assertIn(f"latency {message['latency_us']:.0f} us", shown[1])
        self.assertIn(f"RMS {message['rms_waves']:.4f} wave", shown[2])
        self.assertIn(f"residual {message['fit_residual_px']:.3f} px", shown[2])
        self.check_modes(terminal, message)
        self.check_map(shown, message)
        status = self.call("system.status")
        self.assertIn(f"hologram {status['slm']['hologram_id']}", shown[0])
        self.assertIn("running", shown[0])
        terminal.press("p")
        wait_for(lambda: self.frame_on(terminal) > frame_id + 5, what="frames after the pause")
        self.check_pace(terminal)

    @staticmethod
    def frame_on(terminal):
        """Number of the frame on the screen, 0 without a frame."""
        found = re.match(r"frame (\d+) ", terminal.rows()[1])
        return int(found[1]) if found else 0

    def paused(self, terminal):
        """The rows, paused at a valid frame; none if the newest frame was not valid: on a busy machine some are late."""
        terminal.press("p")
        self.wait_for_text(terminal, "PAUSED")
        if (rows := terminal.rows())[2].startswith("RMS "):
            return rows
        terminal.press("p")
        self.wait_for_text(terminal, "q quit  p pause")
        return None

    def check_modes(self, terminal, message):
        """Scrolls the paused screen, and waits each time until it shows the modes that it should, with their values and bars."""
        wanted = list(zip(message["j"], message["coefficients"]))
        rows = int(self.wait_for_text(terminal, rf"modes 1-(\d+) of {len(wanted)}")[1])
        last = len(wanted) - rows
        self.assertGreater(last, 0, "there is something to scroll")
        for key, pages in (("\x1b[B", range(1, last + 1)), ("\x1b[A", range(last - 1, -1, -1))):
            for first in pages:
                terminal.press(key)
                self.wait_for_modes(terminal, wanted[first:first + rows])
            terminal.press(2 * key)  # there is no further mode
            for text in ("scroll the modes", f"of {len(wanted)}"):  # each `?` is seen once the keys before it have been read
                terminal.press("?")
                self.wait_for_text(terminal, text)
            self.wait_for_modes(terminal, wanted[first:first + rows])

    def wait_for_modes(self, terminal, modes):
        try:
            wait_for(lambda: self.shows(terminal, modes))
        except AssertionError:
            self.fail(f"not {modes} on\n{terminal.text()}")

    @staticmethod
    def shows(terminal, modes):
        """Whether the screen shows exactly these modes (j, waves), each with its bar on the side of its sign."""
        found = [re.match(r" *(\d+) (\S.*?) +([-+]?\d\.\d{4})(.*?)│(.{0,8})", row) for row in terminal.rows()[4:19]]
        seen = [(int(row[1]), float(row[3]), "█" in row[4] or "▐" in row[4], "█" in row[5][:6] or "▌" in row[5][:6]) for row in found if row]
        signs_fit = all((row[3][0] in "+-") == (float(row[3]) != 0.0) for row in found if row)  # a zero has none
        return signs_fit and [j for j, *_ in seen] == [j for j, _ in modes] and all(
            abs(value - waves) <= 0.0000501 and (left, right) == (waves < -0.04, waves > 0.04) for (_, value, left, right), (_, waves) in zip(seen, modes))

    def check_map(self, rows, message):
        signs = "".join(row[45:] for row in rows[4:12])
        found = sum(sign in "●→↘↓↙←↖↑↗" for sign in signs)
        self.assertGreaterEqual(found, message["tracked"] - 2, rows)  # two may share a character
        self.assertIn("↓", signs)
        self.assertNotIn("✕", signs)

    def check_pace(self, terminal):
        """Checks that drawings follow each other at 20 a second at most, however many frames there are: each shows another frame."""
        self.call("camera.set", {"frame_rate_hz": 200})
        begin, drawn = time.monotonic(), set()
        terminal.press("?")
        self.wait_for_text(terminal, "scroll the modes")  # what is drawn from now on was drawn after `begin`
        wait_for(lambda: drawn.add(self.frame_on(terminal)) or len(drawn) > DRAWINGS, what=f"{DRAWINGS} drawings")
        rate_hz = (len(drawn) - 1) / (time.monotonic() - begin)
        print(f"\n  drawn {rate_hz:.0f} times a second")
        self.assertLessEqual(rate_hz, 20)

    def test_lost_spots_and_losses_are_shown(self):
        self.take_reference(30)
        terminal = self.open(columns=120, lines=40)
        self.wait_for_text(terminal, r"\bvalid\b")
        self.twin.call("twin.set", {"read_noise_e": 500.0})
        self.call("camera.set", {"exposure_us": 100})
        self.wait_for_text(terminal, r"NOT VALID: \d+ of 19 spots are found")
        self.wait_for_text(terminal, r"✕.*\n(.*\n)*.*✕(.*\n)*.*latency")
        self.wait_for_text(terminal, r"spots lost +\d+ +\+\d+")
        self.wait_for_text(terminal, r"reference stale")
        self.call("slm.show", {"pattern": "grating"})
        self.wait_for_text(terminal, r"NOT VALID: the SLM shows a grating")

    def test_keys_act_after_a_confirmation(self):
        terminal = self.open()
        self.wait_for_text(terminal, r"running (.*\n)+.* r reference  \+/- exposure  l loop  c clear")
        terminal.press("+")
        self.wait_for_text(terminal, r"set the exposure to 2\.5 ms\? y: yes")
        terminal.press("n")
        self.wait_for_text(terminal, r"q quit")
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], 2000.0)
        terminal.press("-")
        self.wait_for_text(terminal, r"set the exposure to 1\.6 ms\?")
        terminal.press("y")
        self.wait_for_text(terminal, r"exposure 1\.6 ms, gain 0 dB")
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], 1600.0)
        terminal.press("r")
        self.wait_for_text(terminal, r"take a reference of 100 frames\?")
        terminal.press("y")
        wait_for(lambda: self.call("reference.get")["taken"], what="the reference")
        self.wait_until("running")
        terminal.press("l")
        self.wait_for_text(terminal, r"close the loop\?")
        terminal.press("y")
        wait_for(lambda: self.call("loop.get")["closed"], what="the closed loop")
        self.wait_for_text(terminal, r"loop closed  ")
        terminal.press("l")
        self.wait_for_text(terminal, r"open the loop\?")
        terminal.press("y")
        wait_for(lambda: not self.call("loop.get")["closed"], what="the open loop")
        self.call("aberration.set", {"modes": [{"j": 4, "waves": 0.1}]})
        terminal.press("c")
        self.wait_for_text(terminal, r"remove the aberration\?")
        terminal.press("y")
        self.wait_for_text(terminal, r"no aberration is introduced")
        self.assertEqual(self.call("aberration.get")["modes"], [])

    def test_events_are_lines_on_a_terminal(self):
        terminal = self.open("event")
        line = r"(?m)^\d\d:\d\d:\d\d job: .+"
        wait_for(lambda: self.take_reference(5) and re.search(line, terminal.text()), what="an event as a line")

    def test_it_follows_the_size(self):
        self.take_reference(10)
        terminal = self.open()
        self.wait_for_text(terminal, r"modes 1-1\d of 18")
        terminal.resize(140, 50)
        self.wait_for_text(terminal, r"modes 1-18 of 18")
        self.assertTrue(wait_for(lambda: len(terminal.rows()[-1].rstrip()) > 0 and "q quit" in terminal.rows()[-1]))
        terminal.resize(40, 10)
        self.wait_for_text(terminal, r"40 x 10 is too small")
        terminal.resize(80, 24)
        self.wait_for_text(terminal, r"modes 1-1\d of 18")
        terminal.press("?")
        self.wait_for_text(terminal, r"scroll the modes")
        terminal.press("?")
        self.wait_for_text(terminal, r"oblique astigmatism")

    def test_it_outlives_the_daemon(self):
        self.take_reference(10)
        terminal = self.open()
        self.wait_for_text(terminal, r"\bvalid\b")
        os.kill(self.bench.process("ovwsd").pid, signal.SIGKILL)
        self.wait_for_text(terminal, r"no message for \d+ s: waiting for the daemon")
        # a drawing may arrive in pieces, its first line before the numbers of the last one are gone
        wait_for(lambda: not re.search(r"RMS \d|\d\.\d{4}", terminal.text()), what="a screen without old numbers")
        self.bench.stop("ovwsd")
        self.start_daemon()
        self.wait_for_text(terminal, r"running .*frames/s")
        self.wait_for_text(terminal, r"frame \d+ ")
        self.wait_for_text(terminal, r"NOT VALID: no reference")
        self.take_reference(10)  # the events of the start may come before the subscription
        self.wait_for_text(terminal, r"events[\s\S]*\d\d:\d\d:\d\d  \S+")

    def test_the_terminal_is_given_back(self):
        ways = [("q", None, 0)] + [(None, s, 0) for s in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)]
        for key, sent, code in ways:
            with self.subTest(key or sent):
                terminal = self.open(TERM="xterm-256color")
                wait_for(lambda: b"quit" in terminal.raw, what="the page")
                self.assertNotEqual(terminal.modes(), terminal.modes_before)
                terminal.press(key) if key else terminal.process.send_signal(sent)
                self.assertEqual(terminal.wait(), code)
                self.assertEqual(terminal.modes(), terminal.modes_before)
                self.assertIn(b"\x1b[?25h", terminal.raw[terminal.raw.rindex(LEFT_BY_THE_PAGE) - 60:], "the cursor is seen again")

    def test_ctrl_z_and_back(self):
        shell = Terminal(["bash", "--norc", "-i"], TERM="xterm-256color", PS1="$ ")
        self.addCleanup(shell.close)
        shell.press(shlex.join(map(str, self.ovws_command("watch"))) + "\n")
        wait_for(lambda: b"q quit" in shell.raw, what="the page")
        before = len(shell.raw)
        shell.press("\x1a")
        wait_for(lambda: re.search(rb"1049l(.|\n)*Stopped", shell.raw[before:]), what="the shell, and the old page")
        before = len(shell.raw)
        shell.press("fg\n")
        wait_for(lambda: b"\x1b[?1049h" in shell.raw[before:] and b"q quit" in shell.raw[before:], what="the page again")
        before = len(shell.raw)
        shell.press("q")
        wait_for(lambda: LEFT_BY_THE_PAGE in shell.raw[before:], what="the old page")
        shell.press("exit\n")
        shell.process.wait(PROGRAM_PATIENCE_S)

    def test_colours_only_where_they_are_wanted(self):
        self.take_reference(10)
        terminal = self.open()
        self.wait_for_text(terminal, r"\bvalid\b")
        wait_for(lambda: {"cyan"} <= terminal.colours(), what="colours")
        self.assertLessEqual(terminal.colours(), {"default", "cyan", "brown"})
        plain = self.open(NO_COLOR="1")
        self.wait_for_text(plain, r"\bvalid\b")
        self.assertEqual(plain.colours(), {"default"})
        ascii_only = self.open(LC_ALL="C")
        self.wait_for_text(ascii_only, r"\bvalid\b")
        self.assertTrue(ascii_only.text().isascii(), ascii_only.text())

    def test_plain_where_no_page_can_or_shall_be(self):
        for arguments, environment in ((("--plain",), {}), ((), {"TERM": "dumb"}), (("-n", "3"), {})):
            with self.subTest(arguments or environment):
                terminal = self.open(*arguments, **environment)
                self.wait_for_text(terminal, r"frame \d+  hologram \d+")
                self.assertEqual(terminal.modes(), terminal.modes_before)
        self.bench.stop("ovwsd")
        terminal = self.open("--timeout", "0.3", TERM="xterm-256color")
        self.assertEqual(terminal.wait(), 3)
        self.assertNotIn(b"\x1b[?1049h", terminal.raw, "it never took the terminal")


if __name__ == "__main__":
    main()
