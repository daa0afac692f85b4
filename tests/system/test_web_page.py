"""The live page in a real browser: its views, its controls, and protection against other sites."""
import http.server
import re
import signal
import threading
import time

from case import wait_for
from web_case import BrowserCase, browser_main

HOSTILE = b"""<!doctype html><title>hostile</title><script>
const server = "http://127.0.0.1:7704", results = {};
async function attempt(name, path, options) {
  try { const reply = await fetch(server + path, options); results[name] = reply.type === "opaque" ? "opaque" : await reply.text(); }
  catch { results[name] = "refused"; }
}
const token = location.hash.slice(1), body = '{"method": "camera.set", "params": {"gain_db": 9}}';
Promise.all([
  attempt("read", "/stream", { headers: { Authorization: "Bearer " + token } }),
  attempt("command", "/rpc", { method: "POST", body, headers: { Authorization: "Bearer " + token } }),
  attempt("blind", "/rpc", { method: "POST", body, mode: "no-cors" }),
]).then(() => {
  const frame = document.createElement("iframe");
  frame.src = server + "/";
  frame.onload = () => { try { results.frame = frame.contentDocument ? "open" : "refused"; } catch { results.frame = "refused"; } window.results = results; };
  document.body.append(frame);
});
</script>"""


CANVASES = ("#camera-canvas", "#map-canvas", "#strip-canvas")


class Hostile(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(HOSTILE)

    def log_message(self, *_):
        pass


class Page(BrowserCase):
    daemon_config = {"record": {"directory": "recordings"}, "tracking": {"tracker": "fit"}}

    def setUp(self):
        super().setUp()
        self.take_reference()

    def start_browser(self):
        browser = self.new_browser(1000)
        browser.ask("colours", scheme="light")
        browser.open(self.links["control"])
        return browser

    def open(self):
        self.browser = self.start_browser()
        self.browser.wait_text("#bar-now .value", lambda text: re.match(r"\d", text))
        wait_for(lambda: self.browser.text("#bar-why") == "", what="controls")
        wait_for(lambda: self.colours("#camera-canvas") > 10, what="the first picture")

    def colours(self, selector):
        """Number of distinct colours on the canvas."""
        return self.browser.run("""const c = document.querySelector(arguments[0]);
            return new Set(new Uint32Array(c.getContext("2d").getImageData(0, 0, c.width, c.height).data.buffer)).size""", selector)

    def resize(self, width):
        """Resizes the page and waits until every canvas was drawn at its new size."""
        self.browser.resize(width, 1000)
        drawn = """return innerWidth === arguments[0] && arguments[1].map((name) => document.querySelector(name)).every((canvas) =>
            canvas.width === Math.round(canvas.clientWidth * devicePixelRatio) && canvas.height === Math.round(canvas.clientHeight * devicePixelRatio))"""
        wait_for(lambda: self.browser.run(drawn, width, CANVASES), what=f"canvases drawn at a width of {width} px")

    def map_peak(self):
        return float(self.browser.wait_text("#map-caption", lambda text: "valley" in text).split()[3])

    def slide(self, name, value):
        """Moves a slider through its input event, like a user."""
        self.browser.run("""const slider = document.querySelector(`input[type=range][aria-label^="${arguments[0]}"]`);
            slider.value = arguments[1]; slider.dispatchEvent(new Event("input", {bubbles: true}));""", name, str(value))

    def test_it_shows_what_the_stream_says_at_every_width(self):
        self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.3}, {"j": 8, "waves": -0.1}]})
        self.open()
        shown = float(self.browser.wait_text("#figures dd .value", lambda text: text.startswith("0.31")))
        self.browser.wait_text("#mode-table", lambda text: "Z3oblique astigmatism" in text)
        self.browser.wait_text("#modes-error", lambda text: "standard error 0.000" in text)
        true = self.settled_frames(self.stream("wavefront"), 1)[0]
        self.assertAlmostEqual(shown, true["rms_waves"], delta=0.01)
        rows = self.browser.run("return [...document.querySelectorAll('#mode-table tbody tr')].map((r) => [...r.cells].map((c) => c.textContent))")
        self.assertEqual(len(rows), len(true["j"]))
        for row, waves in zip(rows, true["coefficients"]):
            self.assertAlmostEqual(float(row[1].replace("\u2212", "-")), waves, delta=0.01)
        self.assertIn("19\u2009/\u200919", self.browser.text("#figures"))
        wait_for(lambda: self.browser.run("return document.querySelector('#hologram').naturalWidth") == 1280, what="the hologram's picture")
        for width in (400, 1024, 1440, 3840):
            with self.subTest(width=width):
                self.resize(width)
                self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
                for canvas in CANVASES:
                    wait_for(lambda canvas=canvas: self.colours(canvas) > (10 if canvas != "#strip-canvas" else 2), what=f"a drawn {canvas}")
        # Other programs may delay each frame, or all for so long that no age is shown; messages that queue up in a connection are seconds old.
        age = "return parseFloat(document.querySelector('#figures div:last-child .value').textContent)"
        wait_for(lambda: (ms := self.browser.run(age)) is not None and ms < 500, what="an age on screen below 500 ms")
        self.check_console()

    def test_nothing_keeps_anybody_out(self):
        self.open()
        self.check_axe(("light", 400), ("dark", 1440))
        # On a busy machine the page may believe for a moment that the daemon is silent, and disable what it controls.
        wait_for(lambda: {"theme", "menu-button", "show-marks", "Take 100 frames"} <= self.reached_by_tab(), what="all that can be clicked, by keyboard")

    def reached_by_tab(self):
        """Identifiers and texts of what the keyboard reaches next."""
        reached = set()
        for _ in range(60):
            self.browser.press("Tab")
            reached.update(self.browser.run("const e = document.activeElement; return [e.id, e.textContent]"))
        return reached

    def test_controls_and_their_refusals(self):
        self.open()
        self.browser.wait_text("#aberration .sliders", lambda text: "oblique astigmatism" in text)
        self.assertLess(self.map_peak(), 0.1)
        self.slide("Z3 oblique", 0.4)
        wait_for(lambda: self.call("aberration.get")["modes"] == [{"j": 3, "n": 2, "m": -2, "name": "oblique astigmatism", "waves": 0.4}], what="the slider's aberration")
        wait_for(lambda: self.map_peak() > 1.5, what="the map")
        self.slide("Exposure", 3.3)  # the slider is logarithmic
        wait_for(lambda: self.call("camera.get")["settings"]["exposure_us"] == 1995.0, what="the slider's exposure")
        self.browser.click("#slm button >> text=Compare with the output")
        self.browser.wait_text("#slm .controls", lambda text: "identical" in text)
        self.browser.click("#bar .fields button >> text=Clear aberration and take")
        self.browser.wait_text("#bench .controls", lambda text: "Active: 100 frames" in text)
        self.assertEqual(self.call("aberration.get")["modes"], [])
        wait_for(lambda: self.map_peak() < 0.1, what="the map against the new reference")
        self.check_console()
        self.browser.open("about:blank")
        self.browser.open(self.links["look"])
        self.browser.wait_text("#bench .controls", lambda text: "Exposure" in text)
        self.assertEqual(self.browser.run("return document.querySelectorAll('#bench .controls :is(input, button), #aberration input, #slm .controls button').length"), 0)
        self.assertEqual(self.browser.text("#role"), "view only")

    def error_of(self, name):
        """The error text of the control with this label."""
        return self.browser.run("""const label = [...document.querySelectorAll(".field > label")].find((l) => l.textContent.startsWith(arguments[0]));
            return label.parentElement.querySelector(".error").textContent""", name)

    def type(self, name, text):
        """Types into the number field with this label, like a user."""
        self.browser.run("""const label = [...document.querySelectorAll(".field > label")].find((l) => l.textContent.startsWith(arguments[0]));
            const input = document.getElementById(label.htmlFor);
            input.value = arguments[1]; input.dispatchEvent(new Event("change", {bubbles: true}));""", name, text)

    def test_an_error_ends_with_its_cause_and_names_the_range_that_is_shown(self):
        self.open()
        helps = "return [...document.querySelectorAll('#bar .help')].map((e) => e.textContent).join(' ')"
        shown = wait_for(lambda: "dB" in (text := self.browser.run(helps)) and text, what="the ranges")
        self.assertIn("10.0 to 33\u202f333 \u00b5s, at 30.0 frames/s", shown)
        self.assertIn("0 to 48.0 dB", shown)
        self.type("Exposure", "41620")
        self.assertEqual(self.error_of("Exposure"), "41620 \u00b5s is outside 10.0 to 33333 \u00b5s")
        self.type("Gain", "1000")
        self.assertEqual(self.error_of("Gain"), "1000 dB is outside 0 to 48.0 dB")
        self.type("Gain", "1")
        wait_for(lambda: self.call("camera.get")["settings"]["gain_db"] == 1.0, what="the gain")
        self.assertEqual(self.error_of("Gain"), "")
        wait_for(lambda: self.error_of("Exposure") == "", what="the end of an error whose bench has changed")
        self.call("camera.set", {"exposure_us": 9000.0})
        self.browser.click("#bar .fields button >> text=Take 100")
        wait_for(lambda: "exposure" in self.error_of("Reference"), what="the refusal of a reference of saturated spots")
        time.sleep(4.0)
        self.assertIn("exposure", self.error_of("Reference"), "what the job's own end changed is no reason to forget why")
        self.call("camera.set", {"exposure_us": 300.0})
        wait_for(lambda: self.error_of("Reference") == "", what="the end of the refusal with its cause")
        self.check_console()

    def test_a_value_that_was_changed_elsewhere_is_shown_when_the_field_is_left(self):
        self.open()
        field = "const i = document.querySelector('#bar input[type=number]');"

        def shown_while_focused():  # a page without news for three seconds disables its fields, which then lose the focus
            self.call("camera.set", {"exposure_us": 2000.0})
            wait_for(lambda: self.browser.run(field + "if (i.value === '2000') i.focus(); return document.activeElement === i"), what="the exposure")
            self.call("camera.set", {"exposure_us": 300.0})
            time.sleep(2.0)
            return self.browser.run(field + "return document.activeElement === i && i.value")
        self.assertEqual(wait_for(shown_while_focused, what="a field that keeps the focus"), "2000", "the user may be typing")
        wait_for(lambda: self.browser.run(field + "i.blur(); return i.value") == "300", what="the exposure in use")

    def test_the_sliders_reach_as_far_as_chosen_again(self):
        self.open()
        reach = "return [document.querySelector('#aberration-range').value, document.querySelector('#aberration input[type=range]').max]"
        self.browser.wait_text("#aberration .sliders", lambda text: "oblique astigmatism" in text)
        self.call("aberration.set", {"modes": [{"j": 3, "waves": 12.0}]})
        wait_for(lambda: self.browser.run(reach) == ["20", "20"], what="sliders that reach as far as what is introduced")
        self.call("aberration.clear")
        wait_for(lambda: self.browser.run(reach) == ["0.5", "0.5"], what="sliders that reach as far as chosen")

    def test_no_number_of_a_spot_is_cut_off(self):
        self.open()
        self.browser.click("#spots summary")
        for width in (400, 1024, 1440, 1920):
            self.browser.resize(width, 1000)
            sizes = "const e = document.querySelector('#camera .scroll'); return [document.querySelector('#spot-table').rows.length, e.scrollWidth - e.clientWidth]"
            wait_for(lambda: self.browser.run(sizes) == [20, 0], what=f"the whole table at {width} px")

    def test_the_pattern_is_shown_whichever_message_comes_first(self):
        self.open()
        bench, status = self.message("ovws.web.bench/1")[0], self.message("ovws.status/1")[0]
        show = """const slm = await import("/slm.js");
            slm.build(true);
            slm.takeBench(arguments[0]);
            slm.takeStatus(arguments[1]);
            return [document.querySelector("#slm select").value, document.querySelector("#slm select").disabled]"""
        wait_for(lambda: self.browser.run(show, bench, status) == ["sensor", False], what="the pattern, which can be chosen")

    def test_no_state_is_cut_off_and_the_bar_shows_the_rms_and_the_verdict(self):
        self.open()
        cut = """return [...document.querySelectorAll("#bar :is(.help, .why), #bar-now, .head .sub")]
            .filter((e) => e.offsetParent && e.scrollWidth > e.clientWidth).map((e) => e.textContent)"""
        tall = "return document.querySelector('#bar').offsetHeight"
        self.browser.wait_text("#bar .field:nth-child(2) .help", lambda text: "dB" in text)
        wait_for(lambda: self.browser.text("#bar-why") == "", what="controls")
        height = self.browser.run(tall)

        def check(selector, pattern):
            self.browser.wait_text(selector, lambda text: re.fullmatch(pattern, text))
            self.assertEqual(self.browser.run(cut), [], pattern)
            # A busy machine may delay the status for so long that the bar has one more line for a moment.
            wait_for(lambda: self.browser.run(tall) == height, what=f"one line: {pattern}")

        check("#bar .field:nth-child(5) .help", "off")
        check("#procedure-settle .state", "not measured")
        self.close_loop()
        self.call("record.start", {"name": "long"})
        check("#bar .field:nth-child(4) .help", r"closed, 0\.000\d wave")
        check("#bar .field:nth-child(5) .help", r"\d+ s")
        check("#bar .field:nth-child(3) .why", "Open the loop first.")
        self.call("loop.open")
        self.call("record.stop")
        check("#bar .field:nth-child(4) .help", "open")
        self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.3}]})
        check("#bar .field:nth-child(6) .help", r"0\.3000 wave")
        check("#bar-now .value", r"0\.(29|30)\d\d wave")
        self.call("aberration.clear")
        check("#bar-now .value", r"0\.00\d\d wave")
        wellness = "return ['#verdict', '#bar-now'].map((name) => document.querySelector(name).dataset.wellness)"
        self.assertEqual(*self.browser.run(wellness))
        self.browser.run("window.scrollTo(0, document.body.scrollHeight)")
        left, top, wide, high = self.browser.box("#bar-now")
        self.assertTrue(left > 0.0 and top >= 0.0 and left + wide <= 1440.0 and top + high < 100.0, "in view at the end of the page")
        keys = "return [...document.querySelectorAll('#trends .value')].map((e) => [...e.querySelectorAll('i')].map((key) => getComputedStyle(key).borderTopColor))"
        orange, blue = "rgb(224, 154, 62)", "rgb(11, 92, 173)"
        meant = "return [...document.querySelectorAll('#figures > div')].map((e) => e.title)"
        self.assertEqual([text for text in self.browser.run(meant) if len(text) < 20], [], "each figure says what it is")
        self.assertEqual(self.browser.run(keys), [[blue, orange], [], [blue, orange], [], [], []], "two curves differ in their colours")
        self.check_console()

    def test_nothing_can_be_changed_while_the_daemon_is_silent(self):
        self.open()
        enabled = "return [...document.querySelectorAll('#bar .fields :is(button, input)')].filter((e) => e.offsetParent && !e.disabled).length"
        usual = wait_for(lambda: (count := self.browser.run(enabled)) > 7 and count, what="controls")
        daemon = self.bench.process("ovwsd").popen
        daemon.send_signal(signal.SIGSTOP)
        try:
            self.browser.wait_text("#bar-why", lambda text: text == "The daemon is silent.")
            self.assertEqual(self.browser.run(enabled), 0)
        finally:
            daemon.send_signal(signal.SIGCONT)
        wait_for(lambda: (self.browser.run(enabled), self.browser.text("#bar-why")) == (usual, ""), what="controls again")

    def test_a_recording_begins_and_ends_there(self):
        self.open()
        self.browser.fill("#record input[type=text]", "../elsewhere")
        self.browser.click("#bar .fields button >> text=/^Record$/")
        wait_for(lambda: self.error_of("Recording"), what="the refusal of the name")
        self.browser.fill("#record input[type=text]", "from-the-page")
        self.browser.click("#bar .fields button >> text=/^Record$/")
        self.browser.wait_text("#record-sub", lambda text: text == "recording")
        self.browser.wait_text("#record-facts dd:nth-of-type(3)", lambda frames: int(frames) > 2)
        self.browser.click("#bar .fields button >> text=Stop")
        self.browser.wait_text("#record-sub", lambda text: text == "ended: stopped by record.stop")
        self.assertTrue((self.bench.directory / "recordings" / "from-the-page.h5").exists())
        self.assertEqual(self.error_of("Recording"), "")
        self.check_console()

    def test_what_is_old_does_not_look_new(self):
        self.open()
        self.twin.call("twin.fault", {"kind": "unplug", "seconds": 60.0})
        self.browser.wait_text("#camera .veil", lambda text: text.startswith("No new data for"))
        wait_for(lambda: self.browser.run("return document.querySelector('#figures').classList.contains('stale')"), what="the figures to look old")
        self.browser.wait_text("#verdict p", lambda text: "amera" in text)
        self.twin.call("twin.fault", {"kind": "none"})
        wait_for(lambda: self.browser.run("return document.querySelector('#verdict').dataset.wellness") != "bad", what="the end of the fault")
        self.bench.stop("ovws-web")
        self.browser.wait_text("#verdict p", lambda text: "No connection" in text)

    def test_another_sites_page_gets_nothing(self):
        self.browser = self.start_browser()
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 8099), Hostile)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        self.browser.open(f"http://127.0.0.1:8099/#{self.tokens['control']}")
        results = wait_for(lambda: self.browser.run("return window.results"), what="the hostile page")
        self.assertEqual(results["read"], "refused")
        self.assertEqual(results["command"], "refused")
        self.assertIn(results["blind"], ("opaque", "refused"))
        self.assertEqual(results["frame"], "refused")
        self.assertEqual(self.call("camera.get")["settings"]["gain_db"], 0.0)
        self.health(lambda m: m["refused"]["origin"] >= 2)


if __name__ == "__main__":
    browser_main()
