"""The live page in a real browser: procedures, the loop's settings, what is saved, and recordings with their download."""
import os
import re
import socket
from pathlib import Path

from case import PROGRAM_PATIENCE_S, wait_for
from web_case import ADDRESS, HOST, PORT, BrowserCase, WebCase, browser_main


class PanelCase(BrowserCase):
    small = True
    daemon_config = {"record": {"directory": "recordings"}, "state": {"directory": "state"}}

    def setUp(self):
        super().setUp()
        self.take_reference()
        self.browser = self.new_browser()
        self.browser.open(self.links["control"])
        self.browser.wait_text("#camera-sub", lambda text: "frame" in text)
        self.browser.run("document.querySelectorAll('#procedures details, #loop, #recordings').forEach((fold) => { fold.open = true; })")

    def press(self, text, within):
        self.browser.click(f"{within} button:visible >> text=/^{text}/")

    def fill(self, title, text, within):
        self.browser.fill(f"{within} .field:has(> label:text-is('{title}')) input", text)


class Procedures(PanelCase):
    daemon_config = PanelCase.daemon_config | {"slm": {"settle_ms": 60}}  # on a busy machine the twin sees a hologram later than usual

    def result(self, name, condition):
        return self.browser.wait_text(f"#procedure-{name} .result", condition, PROGRAM_PATIENCE_S)

    def run_it(self, name, **params):
        for title, value in params.items():
            self.fill(title.replace("_", " "), value, f"#procedure-{name}")
        self.press("Run", f"#procedure-{name}")

    def run_again(self, name, question, **params):
        """Runs what a reference or a calibration depends on, after a change of mind."""
        within = f"#procedure-{name}"
        self.run_it(name, **params)
        asked = "return document.querySelector(`${arguments[0]} .confirm:not([hidden]) .question`)?.textContent"
        wait_for(lambda: question in (self.browser.run(asked, within) or ""), what="the question")
        self.browser.press("Escape")
        self.run_it(name)
        self.press("Run", f"{within} .confirm")

    def clear(self, name, known):
        """Clears what was measured, after a change of mind."""
        within = f"#procedure-{name}"
        self.press("Clear", within)
        self.browser.press("Escape")
        self.assertTrue(self.call(f"{name}.get")[known])
        self.press("Clear", within)
        self.press("Delete", within)
        wait_for(lambda: not self.call(f"{name}.get")[known], what=f"no {name}")
        self.result(name, lambda text: text.startswith("None"))
        self.assertFalse(self.browser.run("return document.querySelector(`${arguments[0]} button.absent`) === null", within))

    def check_look_page(self, text):
        """A page that may not control shows what is active, without controls."""
        self.browser.open("about:blank")
        self.browser.open(self.links["look"])
        self.result("registration", lambda shown: shown == text)
        self.assertEqual(self.browser.run("return document.querySelectorAll('#procedures button:not(.fold)').length"), 0)

    def test_each_is_run_cancelled_and_cleared(self):
        none = "return [...document.querySelectorAll('.procedure .result')].filter((p) => p.textContent.startsWith('None')).length"
        wait_for(lambda: self.browser.run(none) == 4, what="four procedures without results")
        self.run_again("registration", "reference and calibration", Frames_per_image="2")
        text = self.result("registration", lambda text: text.startswith("The camera sees"))
        known = self.call("registration.get")
        self.assertIn(f"{known['scale_px_per_cycle']:.0f} px for a cycle", text)
        self.assertIn(f"over {known['sights']} gratings", text)
        self.browser.wait_text("#procedure-registration .state", lambda text: re.fullmatch(r"measured \d\d:\d\d:\d\d", text))
        self.run_it("calibration", Frames_per_poke="150")
        self.browser.wait_text("#procedure-calibration .left", lambda text: text.endswith(" left"))
        self.browser.wait_text("#procedure-flatness .field:last-child .why", lambda text: text == "A job is running.")
        self.check_reload()
        self.press("Cancel", "#procedure-calibration")
        self.browser.wait_text("#procedure-calibration .field:last-child .help", lambda text: text == "Cancelled.")
        self.assertFalse(self.call("calibration.get")["calibrated"])
        self.fill("Poke amplitude", "7", "#procedure-calibration")
        self.press("Run", "#procedure-calibration")
        self.browser.wait_text("#procedure-calibration .field:last-child .error", lambda text: "0.2" in text)
        self.run_it("calibration", Poke_amplitude="0.1", Frames_per_poke="2")
        text = self.result("calibration", lambda text: "condition number" in text)
        known = self.call("calibration.get")
        self.assertEqual((known["amplitude_waves"], known["frames"]), (0.1, 2))
        self.assertTrue(text.startswith(f"{len(known['modes'])} modes"), text)
        self.check_registration_again()
        self.run_it("settle", Image_changes="3")
        text = self.result("settle", lambda text: text.startswith("Settled after"))
        self.press("Use", "#procedure-settle")
        wait_for(lambda: f"Use {self.call('config.get')['slm']['settle_ms']:.0f} ms" in self.browser.text("#procedure-settle .params"), what="the proposed settle time")
        self.check_axe(("dark", 1440), ("light", 390), parts="#procedures")
        self.clear("calibration", "calibrated")
        text = self.browser.text("#procedure-registration .result")
        self.check_look_page(text)
        self.check_console()

    def check_registration_again(self):
        """On an unchanged bench a registration leaves reference and calibration in use, and frames valid."""
        def measured():
            return [self.call(f"{name}.get")["sha256"] for name in ("reference", "calibration")]
        self.take_reference()
        before = measured()
        self.run_again("registration", "reference and calibration")
        self.browser.wait_text("#procedure-registration .field:last-child .help", lambda text: text.startswith("Confirmed"))
        self.assertEqual(measured(), before)
        self.assertTrue(self.call("calibration.get")["in_force"])
        stream = self.stream("wavefront")
        wait_for(lambda: (frame := stream.next(0.5)) and frame["valid"], what="a valid frame")

    def check_reload(self):
        """A job that was started before the page was loaded is shown with its progress."""
        self.browser.ask("reload")
        self.browser.wait_text("#camera-sub", lambda text: "frame" in text)
        wait_for(lambda: self.browser.run("return !document.querySelector('#procedure-calibration progress').hidden"), what="the job that runs")

    def test_look_up_table_and_flatness(self):
        self.run_it("lut", Grey_levels="9", Frames_per_image="1")
        text = self.result("lut", lambda text: "\u03c0 deep" in text)
        known = self.call("lut.get")
        self.assertTrue(text.startswith(f"{known['depth_rad'] / 3.14159265:.2f} \u03c0 deep"), text)
        self.assertIn(f"{known['levels']} grey levels", text)
        self.clear("lut", "measured")
        self.run_again("registration", "reference and calibration", Frames_per_image="1")
        self.result("registration", lambda text: text.startswith("The camera sees"))
        self.run_it("flatness", Frames_per_position="1")
        text = self.result("flatness", lambda text: "wave RMS" in text)
        known = self.call("flatness.get")
        self.assertTrue(text.startswith(f"{len(known['modes'])} modes, {known['rms_waves']:.3f} wave RMS"), text)
        self.clear("flatness", "measured")
        self.clear("registration", "registered")
        self.check_console()


class LoopSettings(PanelCase):
    daemon_config = PanelCase.daemon_config | {"camera": {"frame_rate_hz": 100.0}}

    def test_the_loop_closes_with_its_settings(self):
        browser = self.browser
        browser.choose("#loop select", "integrator")
        self.fill("Gain", "0.4", "#loop")
        self.fill("Leak", "0.02", "#loop")
        self.fill("Limit of each mode", "1.5", "#loop")
        self.fill("Open by itself after", "40", "#loop")
        browser.click("#loop label >> text=all measured modes")
        for box in browser.run("return [...document.querySelectorAll('#loop .list input')].map((b) => b.value)"):
            if box not in ("3", "4", "5"):
                browser.click(f"#loop .list input[value='{box}']")
        self.press("Close", "#bar")
        loop = wait_for(lambda: (now := self.call("loop.get"))["closed"] and now, what="a closed loop")
        wanted = {"gain": 0.4, "leak": 0.02, "limit_waves": 1.5, "patience_s": 40.0, "modes": [3, 4, 5], "law": "integrator"}
        self.assertEqual({key: loop[key] for key in wanted}, wanted)
        browser.wait_text("#loop-state", lambda text: text == "closed with integrator, gain 0.400, leak 0.020, limit 1.50 wave, 3 modes (Z3, Z4, Z5)")
        self.fill("Gain", "0.2", "#loop")
        browser.click("#loop label >> text=all measured modes")
        self.press("Use these", "#loop")
        wait_for(lambda: (now := self.call("loop.get"))["closed"] and now["gain"] == 0.2 and now["modes"] is None, what="the new settings")
        browser.wait_text("#loop-state", lambda text: text.startswith("closed with integrator, gain 0.200"))
        self.press("Open", "#bar")
        wait_for(lambda: not self.call("loop.get")["closed"], what="an open loop")
        self.assertIsNone(self.call("loop.model")["model"])
        browser.fill("#loop input[aria-label^=Seconds]", "4")
        self.press("Identify", "#loop")
        browser.wait_text("#loop-model", lambda text: re.search(r"over \d s; expected residual: integrator 0\.\d+, optimised 0\.\d+, predictor 0\.\d+ wave RMS", text))
        self.assertAlmostEqual(self.call("loop.model")["model"]["seconds"], 4.0, delta=2.0)  # the default is 30 s
        self.check_axe(("dark", 1440), ("light", 390), parts="#bench")
        self.check_console()


class Saved(PanelCase):
    def test_settings_and_references_are_kept(self):
        browser = self.browser
        self.call("camera.set", {"gain_db": 0.5})
        browser.wait_text("#saved .help", lambda text: "camera.gain_db" in text)
        self.assertNotIn("Saved ", browser.text("#saved .params"))
        self.press("Save settings", "#saved")
        path = re.search(r"Saved [\d:]+ in (\S+)\.$", browser.wait_text("#saved .help", lambda text: "Saved" in text))[1]
        self.assertIn("gain_db", (self.bench.directory / path).read_text())
        self.press("Save", "#saved .field:nth-of-type(2)")
        browser.wait_text("#saved .field:nth-of-type(2) .error", lambda text: text.startswith("must have 1 to 64"))
        browser.fill("#saved input[type=text]", "morning")
        browser.press("Enter")
        wait_for(lambda: [r["name"] for r in self.call("reference.list")["references"]] == ["morning"], what="the saved reference")
        taken = self.call("reference.get")["t_taken_ns"]
        self.take_reference()
        self.assertNotEqual(self.call("reference.get")["t_taken_ns"], taken)
        self.press("Load", "#references")
        wait_for(lambda: self.call("reference.get")["t_taken_ns"] == taken, what="the loaded reference")
        self.call("sensor.set", {"charge": 2})
        reason = wait_for(lambda: self.call("reference.list")["references"][0]["reason"], what="a reference that does not fit")
        browser.wait_text("#references", lambda text: reason in text)
        self.assertTrue(browser.run("return document.querySelector('#references .load').disabled"))
        self.check_axe(("dark", 1440), ("light", 390), parts="#saved")
        self.press("Delete", "#references")
        self.press("Delete", "#references .confirm")
        wait_for(lambda: self.call("reference.list")["references"] == [], what="no saved reference")
        wait_for(lambda: browser.run("return document.querySelector('#references').hidden"), what="no list")
        self.check_console()


class Recordings(PanelCase):
    def record(self, name=None):
        self.call("record.start", {"name": name, "pictures_every": 0})
        self.recorded_frames(21)
        return Path(self.call("record.stop")["file"])

    def test_a_recording_is_estimated_made_and_downloaded(self):
        browser = self.browser
        size = self.call("record.estimate")
        text = browser.wait_text("#record .controls", lambda text: "an hour; space for" in text)
        self.assertIn(f"At most {size['bytes_per_hour'] / 1e9:.1f} GB", text)
        self.fill("Images of every n-th frame, 0: none", "0", "#record")
        browser.wait_text("#record .controls", lambda text: "MB an hour" in text)
        self.press("Record", "#bar")
        file = Path(wait_for(lambda: (now := self.call("record.get"))["frames"] > 20 and now["file"], what="a recording"))
        self.assertRegex(file.name, r"^run-[\w-]+\.h5$")
        self.press("Stop", "#bar")
        wait_for(lambda: self.call("record.get")["state"] == "ended", what="its end")
        self.assertEqual(self.call("record.get")["pictures"], 0)
        browser.wait_text("#record-sub", lambda text: text.startswith("ended"))  # from here on the list is not read by itself
        browser.wait_text("#recordings-table tbody", lambda text: file.stem in text)
        name, data = browser.download(f"#recordings-table button[aria-label='Download {file.stem}']")
        self.assertEqual((name, data), (file.name, file.read_bytes()))
        self.check_axe(("dark", 1440), ("light", 390), parts="#record")
        file.unlink()
        browser.click(f"#recordings-table button[aria-label='Download {file.stem}']")
        browser.wait_text("#recordings-error", lambda text: f"no recording {file.stem}" in text)
        self.press("Refresh", "#recordings")
        browser.wait_text("#recordings-sub", lambda text: text.startswith("No recordings in"))
        self.record("second")
        browser.wait_text("#recordings-table tbody", lambda text: text.startswith("second"))
        self.check_console()


class Downloads(WebCase):
    small = True
    daemon_config = {"record": {"directory": "recordings"}}

    def start(self):
        super().start()
        self.call("record.start", {"name": "run-1", "pictures_every": 1})
        wait_for(lambda: self.call("record.get")["pictures"] > 20, what="recorded images")
        self.file = Path(self.call("record.stop")["file"])

    def ticket(self, name="run-1", right="look"):
        status, _, body = self.ask("POST", "/ticket", ('{"name": "%s"}' % name).encode(), self.tokens[right])
        return status, body.decode()

    def path(self):
        return re.search(r'"path":\s*"([^"]+)"', self.ticket()[1])[1]

    def refusal(self, path, token=None):
        status, _, body = self.ask("GET", path, token=token)
        return status, re.search(r'"refused":\s*"(\w+)"', body.decode())[1]

    def test_a_download_needs_a_token_or_a_fresh_ticket_for_its_name(self):
        path = self.path()
        status, headers, data = self.ask("GET", path)
        self.assertEqual((status, data), (200, self.file.read_bytes()))
        self.assertEqual(headers["Content-Disposition"], 'attachment; filename="run-1.h5"')
        self.assertEqual(self.refusal(path), (403, "ticket"), "used")
        self.assertEqual(self.refusal(self.path().replace("run-1", "run-2")), (403, "ticket"), "of another recording")
        self.assertEqual(self.refusal("/recording?name=run-1"), (401, "token"))
        self.assertEqual(self.refusal("/recording?name=run-1&ticket=" + 32 * "0"), (403, "ticket"))
        self.assertEqual(self.ask("GET", "/recording?name=run-1", token=self.tokens["look"])[2], self.file.read_bytes())
        self.assertEqual(self.ask("GET", self.path(), headers={"Sec-Fetch-Site": "cross-site"})[0], 403)
        self.assertEqual(self.ask("POST", "/ticket", b'{"name": "run-1"}')[0], 401)
        self.assertEqual(self.ask("GET", "/recordings")[0], 401)

    def test_a_ticket_outlives_the_refusal_of_a_third_download(self):
        os.truncate(self.file, 64 << 20)  # more than the kernel keeps for browsers that do not read
        path, direct = self.path(), "/recording?name=run-1"
        request = f"GET {direct} HTTP/1.1\r\nHost: {ADDRESS}\r\nAuthorization: Bearer {self.tokens['look']}\r\n\r\n"
        browsers = [socket.create_connection((HOST, PORT)) for _ in range(2)]
        for browser in browsers:
            self.addCleanup(browser.close)
            browser.sendall(request.encode())
            browser.recv(1)
        self.assertEqual(self.refusal(direct, self.tokens["look"]), (503, "downloads"))
        self.assertEqual(self.refusal(path), (503, "downloads"))
        browsers[0].close()
        wait_for(lambda: self.ask("GET", direct, token=self.tokens["look"])[0] == 200, what="the end of a download")
        self.assertEqual(self.ask("GET", path)[0], 200)

    def test_only_what_the_daemon_lists_is_served(self):
        token = self.tokens["look"]
        (self.file.parent.parent / "secret.h5").write_text("treasure")
        (self.file.parent / "link.h5").symlink_to(self.file.parent.parent / "secret.h5")
        for name in ("../secret", "%2e%2e%2fsecret", "..", ".", "", "/etc/passwd", "run-1.h5/../run-1"):
            self.assertEqual(self.refusal(f"/recording?name={name}", token), (400, "malformed"), name)
        for name in ("secret", "link", "run-1.h5", "run-2"):
            status, _, body = self.ask("GET", f"/recording?name={name}", token=token)
            self.assertEqual((status, b"treasure" in body), (404, False), name)
            self.assertIn("record.list has no recording", self.ticket(name)[1])
        self.assertEqual(self.ticket("../secret")[0], 400)

    def test_where_the_file_cannot_be_read_it_says_what_to_do(self):
        os.chmod(self.bench.directory, 0o711)
        os.chmod(self.file.parent, 0o700)
        self.web.stop()
        program = self.bench.programs / "ovws-web"
        as_other = ["setpriv", "--reuid=54321", "--regid=54321", "--clear-groups"]
        self.web = self.bench.start("ovws-web", [*as_other, program, "--control"])
        self.web.wait_for_line("ready")
        self.tokens = dict(line.split() for line in (self.bench.directory / "ovws-web.out").read_text().splitlines())
        self.tokens = {name: link.partition("#")[2] for name, link in self.tokens.items()}
        for path, method in (("/recordings", "GET"), ("/ticket", "POST")):
            body = self.ask(method, path, b'{"name": "run-1"}' if method == "POST" else None, self.tokens["look"])[2].decode()
            self.assertIn("may not read", body)
            self.assertIn("ovws-data", body)


if __name__ == "__main__":
    browser_main()
