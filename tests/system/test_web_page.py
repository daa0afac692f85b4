"""The page in a real browser: what it shows, what its controls do, and what another site's page cannot."""
import http.server
import pathlib
import os
import subprocess
import threading
import time

from case import Client, main, wait_for
from web_case import WebCase, open_browser, resize, text_of, wait_text

AXE_VERSION = "4.10.2"
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


def axe_script():
    """axe-core's own script from the npm registry, kept beside the build; none where there is no npm or no network."""
    folder = pathlib.Path(os.environ["OVWS_BUILD"]) / "axe"
    script = folder / "node_modules" / "axe-core" / "axe.min.js"
    if not script.exists():
        folder.mkdir(exist_ok=True)
        try:
            subprocess.run(["npm", "install", "--prefix", folder, "--ignore-scripts", "--no-audit", "--no-fund", f"axe-core@{AXE_VERSION}"],
                           check=True, capture_output=True, timeout=60)
        except (OSError, subprocess.SubprocessError):
            return None
    return script.read_text()


class Hostile(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(HOSTILE)

    def log_message(self, *_):
        pass


class Page(WebCase):
    def setUp(self):
        super().setUp()
        self.take_reference()

    def script(self, text, *arguments):
        return self.driver.execute_script(text, *arguments)

    def open(self, **more):
        self.driver = open_browser(self, **more)
        wait_text(self.driver, "#verdict p", lambda text: text == "The bench is well")

    def check_console(self):
        said = [line for line in self.driver.get_log("browser") if "127.0.0.1" in line["message"]]
        self.assertEqual(said, [])

    def colours(self, selector):
        """How many different colours the canvas has."""
        return self.script("""const c = document.querySelector(arguments[0]);
            return new Set(new Uint32Array(c.getContext("2d").getImageData(0, 0, c.width, c.height).data.buffer)).size""", selector)

    def map_peak(self):
        return float(wait_text(self.driver, "#map-caption", lambda text: "valley" in text).split()[3])

    def slide(self, name, value):
        """Moves a slider as a hand would, by its events."""
        self.script("""const slider = document.querySelector(`input[type=range][aria-label^="${arguments[0]}"]`);
            slider.value = arguments[1]; slider.dispatchEvent(new Event("input", {bubbles: true}));""", name, str(value))

    def test_it_shows_what_the_stream_says_at_every_width(self):
        self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.3}, {"j": 8, "waves": -0.1}]})
        self.open()
        shown = float(wait_text(self.driver, "#figures dd .value", lambda text: text.startswith("0.31")))
        wait_text(self.driver, "#mode-table", lambda text: "Z3oblique astigmatism" in text)
        true = self.settled_frames(self.stream("wavefront"), 1)[0]
        self.assertAlmostEqual(shown, true["rms_waves"], delta=0.01)
        rows = self.script("return [...document.querySelectorAll('#mode-table tbody tr')].map((r) => [...r.cells].map((c) => c.textContent))")
        self.assertEqual(len(rows), len(true["j"]))
        for row, waves in zip(rows, true["coefficients"]):
            self.assertAlmostEqual(float(row[1].replace("\u2212", "-")), waves, delta=0.01)
        self.assertIn("19\u2009/\u200919", text_of(self.driver, "#figures"))
        wait_for(lambda: self.script("return document.querySelector('#hologram').naturalWidth") == 1280, what="the hologram's picture")
        for width in (400, 1024, 1440, 3840):
            with self.subTest(width=width):
                resize(self.driver, width, 1000)
                time.sleep(0.4)
                self.assertLessEqual(self.script("return document.documentElement.scrollWidth"), width)
                for canvas in ("#camera-canvas", "#map-canvas", "#strip-canvas"):
                    self.assertGreater(self.colours(canvas), 10 if canvas != "#strip-canvas" else 2, canvas)
        ages = [wait_for(lambda: float(text_of(self.driver, "#figures div:last-child .value"))) for _ in range(8) if not time.sleep(0.25)]
        print(f"\n  age on screen: {sorted(ages)} ms")
        self.assertLess(sorted(ages)[len(ages) // 2], 100)
        self.check_console()

    def test_nothing_keeps_anybody_out(self):
        if not AXE:
            self.skipTest("no axe-core: npm and a network are needed once")
        self.open()
        self.driver.execute_cdp_cmd("Runtime.evaluate", {"expression": AXE})
        for theme, width in (("light", 400), ("dark", 1440)):
            self.script("document.documentElement.dataset.theme = arguments[0]", theme)
            resize(self.driver, width, 1000)
            time.sleep(0.3)
            found = self.driver.execute_async_script("axe.run().then((r) => arguments[0](r.violations))")
            grave = [(v["id"], v["impact"], v["nodes"][0]["html"]) for v in found if v["impact"] in ("serious", "critical")]
            self.assertEqual(grave, [], f"{theme}, {width} px")
        # Everything that can be clicked is reached by the keyboard, in the order that is seen.
        reached = []
        for _ in range(60):
            self.driver.switch_to.active_element.send_keys("\ue004")
            reached.append(self.script("const e = document.activeElement; return e.id || e.textContent || e.tagName"))
        for wanted in ("theme", "show-marks", "Take 100 frames"):
            self.assertIn(wanted, reached)

    def test_controls_and_their_refusals(self):
        self.open()
        wait_text(self.driver, "#aberration .sliders", lambda text: "oblique astigmatism" in text)
        flat = self.map_peak()
        self.assertLess(flat, 0.1)
        self.slide("Z3 oblique", 0.4)
        wait_for(lambda: self.call("aberration.get")["modes"] == [{"j": 3, "n": 2, "m": -2, "name": "oblique astigmatism", "waves": 0.4}], what="the slider's aberration")
        wait_for(lambda: self.map_peak() > 1.5, what="the map")
        self.slide("Exposure", 4.5)  # the slider is logarithmic: 31.6 ms, more than a frame's period
        text = wait_text(self.driver, "#bench .controls", lambda text: "frame rate" in text)
        self.assertIn("31620 us", text)
        wait_for(lambda: self.script("return document.querySelector('#bench input[type=number]').value") == "2000", what="the exposure in force")
        self.script("[...document.querySelectorAll('button')].find((b) => b.textContent === 'Compare with the output').click()")
        wait_text(self.driver, "#slm .controls", lambda text: "pixel for pixel" in text)
        self.script("[...document.querySelectorAll('button')].find((b) => b.textContent.startsWith('Take')).click()")
        wait_text(self.driver, "#bench .controls", lambda text: "In force: 100 frames" in text)
        wait_for(lambda: self.map_peak() < 0.1, what="the map against the new reference")
        self.check_console()
        self.driver.get("about:blank")
        self.driver.get(self.links["look"])
        wait_text(self.driver, "#bench .controls", lambda text: "Exposure" in text)
        self.assertEqual(self.script("return document.querySelectorAll('#bench input, #bench button, #aberration input, #slm button').length"), 0)
        self.assertEqual(text_of(self.driver, "#role"), "looking only")

    def test_what_is_old_does_not_look_new(self):
        self.open()
        with Client("tcp://127.0.0.1:7790") as twin:
            twin.call("twin.fault", {"kind": "unplug", "seconds": 60.0})
            wait_text(self.driver, "#camera .veil", lambda text: text.startswith("Nothing new for"))
            wait_for(lambda: self.script("return document.querySelector('#figures').classList.contains('stale')"), what="the figures to look old")
            wait_text(self.driver, "#verdict p", lambda text: "amera" in text)
            twin.call("twin.fault", {"kind": "none"})
            wait_text(self.driver, "#verdict p", lambda text: text == "The bench is well", 20.0)
        self.bench.stop("ovws-web")
        wait_text(self.driver, "#verdict p", lambda text: "No connection" in text)

    def test_another_sites_page_gets_nothing(self):
        self.driver = open_browser(self)
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 8099), Hostile)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        self.driver.get(f"http://127.0.0.1:8099/#{self.tokens['control']}")
        results = wait_for(lambda: self.script("return window.results"), what="the hostile page")
        self.assertEqual(results["read"], "refused")
        self.assertEqual(results["command"], "refused")
        self.assertIn(results["blind"], ("opaque", "refused"))
        self.assertEqual(results["frame"], "refused")
        self.assertEqual(self.call("camera.get")["settings"]["gain_db"], 0.0)
        self.health(lambda m: m["refused"]["origin"] >= 2)


if __name__ == "__main__":
    AXE = axe_script()  # before there is no network any more
    main()
