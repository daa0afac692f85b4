"""The live page in a real browser: the bar of daily controls, the camera's panel, folding panels, and what a page without control shows."""
import io
import math
import re
import time

import numpy
from PIL import Image

from case import PATIENCE_S, wait_for
from web_case import BrowserCase, browser_main

PANELS = "return [...document.querySelectorAll('main > section')].filter((s) => s.offsetHeight > 0).map((s) => s.id)"
READOUT = re.compile(r"x (\d+), y (\d+)(?: \((\d+), (\d+) in the region\))?: (\d+) DN, ([\d.]+) % of full scale(.*)")
# The slider's upper end; null while it cannot be moved.
SLIDER_MAX = "const s = document.querySelector('#bar .wide input[type=range]:enabled'); return s && Number(s.max)"
WHY = """const shown = (e) => e && e.offsetParent !== null && e.textContent !== "";
    return [...document.querySelectorAll(":is(button, input, select):disabled")].filter((e) => e.offsetParent !== null)
        .filter((e) => !e.title || !(e.getAttribute("aria-describedby") ?? "").split(" ").some((id) => shown(document.getElementById(id)) && document.getElementById(id).textContent === e.title))
        .map((e) => e.outerHTML)"""
# Calls wait for release(); `pending`: those without a reply.
HOLD_CALLS = """const real = window.fetch, released = new Promise((release) => { Object.assign(window, { release, pending: 0 }); });
    const held = async (given) => { window.pending += 1; await released; const reply = await real(...given), text = await reply.text();
      setTimeout(() => { window.pending -= 1; }, 100); return new Response(text, reply); };
    window.fetch = (...given) => String(given[0]).includes("/rpc") ? held(given) : real(...given);"""


class PageCase(BrowserCase):
    small = True
    daemon_config = {"record": {"directory": "recordings"}}

    def setUp(self):
        super().setUp()
        self.take_reference()
        self.browser = self.new_browser()
        self.open("control")

    def open(self, link):
        self.browser.open("about:blank")
        self.browser.open(self.links[link])
        self.browser.wait_text("#camera-sub", lambda text: "frame" in text)

    def settings(self):
        return self.call("camera.get")["settings"]

    def press(self, text, within="#bar .fields"):
        self.browser.click(f"{within} button >> text=/^{text}/")

    def check_box(self, selector):
        """Checks that the element is in the window as a whole, and returns its box."""
        left, top, width, height = self.browser.box(selector)
        window = self.browser.run("return [innerWidth, innerHeight]")
        self.assertGreater(width * height, 0, selector)
        self.assertTrue(left >= 0 and top >= 0 and left + width <= window[0] and top + height <= window[1], f"{selector}: {left, top, width, height} in {window}")
        return left, top, width, height

    def canvas_at(self, x, y):
        """Window position of a part of the canvas, once it shows an image."""
        wait_for(lambda: self.browser.run("return document.querySelector('#camera-canvas').style.aspectRatio"), what="a drawn image")
        left, top, width, height = self.browser.box("#camera-canvas")
        return left + x * width, top + y * height

    def readout(self, *at):
        """What is shown of the pixel at this part of the canvas, which the mouse points at again until it is there, or of the marked one."""
        def read():
            if at:
                x, y = self.canvas_at(*at)
                self.browser.mouse(("move", x + 9, y), ("move", x, y))
                self.browser.run("await new Promise((drawn) => requestAnimationFrame(() => setTimeout(drawn)))")
            return READOUT.fullmatch(self.browser.text("#camera-readout"))
        return wait_for(read, what="the value of a pixel")

    def pixel(self, *at):
        """The position that the readout shows."""
        return [int(self.readout(*at)[k]) for k in (1, 2)]

    def in_still_canvas(self, act):
        """What `act(its box)` gives, done again until the canvas stood still: remarks above it come and go, move it and change its size."""
        def attempt():
            box = self.browser.box("#camera-canvas")
            given = act(box)
            return self.browser.box("#camera-canvas") == box and [given]
        return wait_for(attempt, what="a canvas that stays as it is")[0]

    def pixel_in_middle(self):
        """The position that the readout shows of the canvas's middle."""
        return self.in_still_canvas(lambda _: self.pixel(0.5, 0.5))

    def zoom(self):
        """What the page shows, CSS pixels per camera pixel; 0: the whole image."""
        return float(self.browser.run("return (document.querySelector('#camera-sub').textContent.match(/([\\d.]+) \u00d7$/) ?? [0, 0])[1]"))

    def wheel(self, steps):
        """Zooms in on the middle by single turns of the wheel: a busy browser merges those that are queued."""
        for _ in range(steps):
            before = self.zoom()
            self.browser.mouse(("move", *self.canvas_at(0.5, 0.5)), ("wheel", 0, -200))
            wait_for(lambda: self.zoom() > before, what="a larger zoom")
        return self.zoom()


class Bar(PageCase):
    def check_full_screen(self):
        self.browser.click("#camera-tools >> text=Full screen")
        wait_for(lambda: self.browser.run(PANELS) == ["camera"], what="the camera alone")
        self.check_box("#camera-canvas")
        self.check_box("#bar .wide input[type=range]")
        self.browser.click("#camera-tools >> text=Full screen")
        wait_for(lambda: len(self.browser.run(PANELS)) > 5, what="all panels")

    def test_camera_and_daily_controls_are_in_one_view(self):
        wait_for(lambda: min(self.browser.box("#camera-canvas")[2:]) > 500, what="a large image: a busy machine's findings take some of its room")
        self.check_box("#camera-canvas")
        self.check_full_screen()
        for selector in ("#bar .wide input[type=range]", "#bar .wide input[type=number]", "#bar .wide button", "#saturation", "#map-canvas"):
            self.check_box(selector)
        for width, height in ((1440, 900), (390, 844)):
            self.browser.resize(width, height)
            self.browser.run("scrollTo(0, document.body.scrollHeight)")
            wait_for(lambda: self.browser.run("return scrollY") > 500, what="a page that is scrolled")
            self.check_box("#bar .wide input[type=range]")
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
        self.assertLess(self.browser.box("#bar")[3], 100)
        self.assertEqual(self.browser.run("return [...document.querySelectorAll('#bar .field')].filter((f) => f.offsetParent).length"), 1)
        self.browser.click("#more")
        self.assertEqual(self.browser.run("return [...document.querySelectorAll('#bar .field')].filter((f) => f.offsetParent).length"), 6)
        self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), 390)
        self.browser.click("#menu-button")
        self.browser.click("#menu button >> text=/^Camera$/")
        wait_for(lambda: 0 < self.browser.box("#camera")[1] < 400, what="the camera's panel below the bar")
        self.browser.click("#camera .fold")
        self.browser.click("#map .fold")
        self.open("control")
        self.browser.wait_text("#camera-sub", lambda text: "frame" in text)
        folded = "return [...document.querySelectorAll('.folded')].map((s) => s.id)"
        self.assertEqual(self.browser.run(folded), ["camera", "map"])
        self.browser.click("#menu-button")
        self.browser.click("#menu button >> text=/^Camera$/")
        self.assertEqual(self.browser.run(folded), ["map"])
        self.check_console()

    def test_findings_leave_camera_and_daily_controls_in_one_view(self):
        browser = self.browser
        self.call("aberration.set", {"modes": [{"j": 7, "waves": 0.1}]})
        self.take_reference(allow_aberration=True)
        self.call("camera.set", {"exposure_us": 9000.0})  # saturates; the reference is stale
        wait_for(lambda: browser.run("return document.querySelectorAll('#findings li').length") >= 2, what="three findings")
        self.assertGreater(browser.box("#findings")[3], 50)
        for selector in ("#camera-canvas", "#saturation", "#bar .wide input[type=range]", "#bar .wide button"):
            self.check_box(selector)
        self.assertGreater(browser.box("#camera-canvas")[3], 400)
        self.check_console()

    def test_what_is_set_or_typed_while_a_reply_is_awaited_is_not_lost(self):
        browser, gain = self.browser, "#bar .field:nth-child(2) input[type=number]"
        wait_for(lambda: browser.run(SLIDER_MAX), what="a slider that can be moved")
        browser.run(HOLD_CALLS)
        for selector, value in (("#bar .wide input[type=number]", "1200"), ("#bar .wide input[type=number]", "1300"), (gain, "3")):
            browser.fill(selector, value)
            browser.press("Enter")
        browser.fill(gain, "4")
        browser.run("release()")
        wait_for(lambda: [self.settings()[key] for key in ("exposure_us", "gain_db")] == [1300.0, 3.0], what="exposure and gain")
        wait_for(lambda: browser.run("return window.pending") == 0, what="the replies")
        self.assertEqual(browser.run("return document.querySelector(arguments[0]).value", gain), "4")
        browser.press("Enter")
        wait_for(lambda: self.settings()["gain_db"] == 4.0, what="the gain that was typed meanwhile")
        self.check_console()

    def test_clear_is_not_overtaken_by_what_a_slider_set_before(self):
        browser, defocus = self.browser, "#aberration input[aria-label^='Z4'] + input"
        self.call("aberration.set", {"modes": [{"j": 5, "waves": 0.1}]})
        browser.wait_text("#bar .fields", lambda text: "0.1000 wave" in text)
        browser.run(HOLD_CALLS)
        for value in ("0.02", "0.03"):
            browser.fill(defocus, value)
            browser.press("Enter")
        self.press("Clear$")
        browser.run("release()")
        wait_for(lambda: browser.run("return window.pending") == 0, what="the replies")
        self.assertEqual(self.call("aberration.get")["modes"], [])

    def test_every_control_of_the_bar_acts_on_the_bench(self):
        browser = self.browser
        wait_for(lambda: browser.run(SLIDER_MAX), what="a slider that can be moved")
        browser.run("""const slider = document.querySelector("#bar .wide input[type=range]");
            slider.value = "3.2"; slider.dispatchEvent(new Event("input", {bubbles: true}))""")
        wait_for(lambda: self.settings()["exposure_us"] == 1585.0, what="the slider's exposure")
        browser.fill("#bar .wide input[type=number]", "1200")
        browser.press("Enter")
        wait_for(lambda: self.settings()["exposure_us"] == 1200.0, what="the exposure as a number")
        browser.fill("#bar .field:nth-child(2) input[type=number]", "3")
        browser.press("Enter")
        wait_for(lambda: self.settings()["gain_db"] == 3.0, what="the gain")
        browser.wait_text("#bar .fields", lambda text: "stale" in text)
        taken = self.call("reference.get")["t_taken_ns"]
        self.press("Take 100")
        wait_for(lambda: self.call("reference.get")["t_taken_ns"] != taken, what="a new reference")
        self.wait_until("running")
        self.call("aberration.set", {"modes": [{"j": 4, "waves": 0.1}]})
        browser.wait_text("#bar .fields", lambda text: "0.1000 wave" in text)
        self.press("Clear$")
        wait_for(lambda: self.call("aberration.get")["modes"] == [], what="no aberration")
        browser.run("document.querySelector('#loop').open = true")
        browser.fill("#loop .field:has(> label:text-is('Open by itself after')) input", str(PATIENCE_S))
        self.press("Close")
        wait_for(lambda: self.call("loop.get")["closed"], what="a closed loop")
        self.press("Open")
        wait_for(lambda: not self.call("loop.get")["closed"], what="an open loop")
        self.press("Record")
        wait_for(lambda: self.call("record.get")["state"] == "recording", what="a recording")
        self.press("Stop")
        wait_for(lambda: self.call("record.get")["state"] == "ended", what="its end")
        self.call("camera.set", {"exposure_us": 200.0, "gain_db": 0.0})
        self.browser.wait_text("#saturation", lambda text: "Raise the exposure" in text)
        self.press("Auto")
        wait_for(lambda: self.settings()["exposure_us"] > 800.0, what="a longer exposure")
        self.browser.wait_text("#saturation", lambda text: re.search(r" [5-9]\d % of full scale", text))
        self.check_console()

    def check_remedy_clears_the_aberration(self):
        """The banner's button takes a reference as that of the bar does."""
        self.call("aberration.set", {"modes": [{"j": 4, "waves": 0.1}]})
        self.call("camera.set", {"exposure_us": 1100.0})
        self.browser.wait_text("#bar .fields", lambda text: "Clear aberration and take" in text)
        self.browser.click("header button >> text=Clear aberration and take")
        self.browser.wait_text("header", lambda text: "another gain" not in text)
        self.assertEqual(self.call("aberration.get")["modes"], [])
        self.assertEqual(self.browser.text("#verdict-error"), "")

    def test_findings_lead_to_their_remedy(self):
        self.call("camera.set", {"exposure_us": 9000.0})
        self.browser.wait_text("#verdict", lambda text: "spots are saturated" in text)
        self.browser.wait_text("#saturation", lambda text: "spots are measured wrong" in text)
        self.browser.click("#verdict button >> text=Set the exposure")
        wait_for(lambda: self.settings()["exposure_us"] < 6000.0, what="a shorter exposure")
        self.wait_until("running")
        self.call("camera.set", {"exposure_us": 1000.0})
        self.browser.click("header button >> text=Take a new one")
        self.browser.wait_text("header", lambda text: "another gain" not in text)
        self.check_remedy_clears_the_aberration()
        self.call("slm.show", {"pattern": "grating"})
        self.browser.click("header button >> text=Show the sensor's hologram")
        wait_for(lambda: self.call("system.status")["slm"]["pattern"] == "sensor", what="the sensor's hologram")
        self.call("reference.clear")
        self.browser.click("header button >> text=Take a reference")
        wait_for(lambda: self.call("reference.get")["taken"], what="a reference")
        self.check_console()

    def test_the_button_of_the_colours_says_so(self):
        self.assertEqual(self.browser.text("#theme"), "Colours: system")
        for width in (390, 1440):
            self.browser.resize(width, 900)
            self.check_box("#theme")
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
        for colours in ("light", "dark", "system"):
            self.browser.click("#theme")
            self.assertEqual(self.browser.text("#theme"), f"Colours: {colours}")

    def test_a_correction_of_the_open_loop_is_shown_and_cleared(self):
        self.call("aberration.set", {"modes": [{"j": 8, "waves": 0.1}]})
        self.close_loop()
        wait_for(lambda: self.call("loop.get")["correction_rms_waves"] > 0.08, what="a correction")
        title = "return [...document.querySelectorAll('#bar button')].find((b) => b.textContent === 'Clear').title"
        wait_for(lambda: self.browser.run(title) == "Clears the aberration", what="the title with the loop closed")
        self.press("Open")
        rms = r"correction 0\.\d+ wave"
        self.browser.wait_text("#bench .controls", lambda text: re.search(f"Loop open since .*; {rms} RMS", text))
        self.browser.wait_text("#bar .fields", lambda text: re.search(f"Aberration.*{rms}.*0\\.1000 wave", text))
        wait_for(lambda: self.browser.run(title) == "Clears the aberration and the correction", what="the title with the loop open")
        self.call("aberration.clear")
        wait_for(lambda: self.browser.run(title) == "Clears the correction", what="the title without an aberration")
        self.press("Clear$")
        wait_for(lambda: self.call("loop.get")["correction_rms_waves"] == 0.0, what="no correction")
        self.browser.wait_text("#bar .fields", lambda text: "correction" not in text)
        self.call("correction.set", {"modes": [{"j": 8, "waves": 0.05}]})
        self.call("aberration.set", {"modes": [{"j": 4, "waves": 0.1}]})
        wait_for(lambda: self.browser.run(title) == "Clears the aberration and the correction", what="the title with both")
        self.press("Clear$")
        wait_for(lambda: self.call("aberration.get")["modes"] == self.call("correction.get")["modes"] == [], what="neither")
        self.check_console()

    def test_what_a_closed_loop_excludes_is_disabled_and_says_why(self):
        self.call("camera.set", {"exposure_us": 1100.0})
        self.browser.wait_text("header", lambda text: "Take a new one" in text)
        self.close_loop()
        self.browser.wait_text("#bar .fields", lambda text: "Open the loop first." in text)
        disabled = "return [...document.querySelectorAll('button:disabled, select:disabled')].filter((e) => e.offsetParent).map((e) => e.textContent)"
        names = self.browser.run(disabled)
        for name in ("Auto", "Take 100 frames", "Take a new one", "Clear reference", "Clear correction"):
            self.assertIn(name, names)
        self.assertEqual(self.browser.run(WHY), [])
        wait_for(lambda: not self.browser.run("return document.querySelector('#bar .wide input').disabled"), what="an exposure that can be set")
        self.press("Open")
        wait_for(lambda: self.browser.run(disabled) == [], what="all controls with the loop open")
        self.check_console()

    def test_without_control_everything_that_is_disabled_says_why(self):
        self.assertEqual(self.browser.run(WHY), [])
        self.call("reference.clear")
        self.browser.wait_text("#bar .fields", lambda text: "Needs a reference." in text)
        self.assertEqual(self.browser.run(WHY), [])
        self.open("look")
        self.browser.wait_text("#bar-why", lambda text: text.startswith("View only"))
        wait_for(lambda: self.browser.run("return document.querySelector('header button.call')?.disabled"), what="a remedy that is disabled")
        self.browser.click("#camera-tools >> text=Region")
        self.assertGreater(self.browser.run("return document.querySelectorAll(':disabled').length"), 15)
        self.assertEqual(self.browser.run(WHY), [])

    def test_a_page_that_does_not_know_the_limits_yet_waits_for_them(self):
        for name in ("ovws-web", "ovwsd"):
            self.bench.stop(name)
        self.start_web()
        self.browser.open("about:blank")
        self.browser.open(self.links["control"])
        self.browser.wait_text("#bar-why", lambda text: text == "Waiting for ovwsd.")
        self.browser.wait_text("#role", lambda text: text == "control enabled")
        self.assertEqual(self.browser.run("return document.querySelectorAll('#bar .field :is(button, input):enabled').length"), 0)
        self.assertTrue(self.browser.run("return document.querySelector('#bench .controls').hidden"))
        self.assertEqual(self.browser.run(WHY), [])
        self.start_daemon()
        self.assertAlmostEqual(wait_for(lambda: self.browser.run(SLIDER_MAX), what="a slider that can be moved"), math.log10(1e6 / 30), places=4)
        self.assertFalse(self.browser.run("return document.querySelector('#bench .controls').hidden"))


class Camera(PageCase):
    def check_looks(self):
        browser = self.browser
        self.load_axe()
        self.call("camera.set", {"exposure_us": 9000.0})
        browser.wait_text("#verdict", lambda text: "saturated" in text)
        for theme, width, mode in (("dark", 1440, "Region"), ("light", 390, "Profile")):
            browser.run("document.documentElement.dataset.theme = arguments[0]", theme)
            browser.resize(width, 900)
            browser.click(f"#camera-tools >> text={mode}")
            browser.click("#menu-button")
            grave = [(v["id"], v["nodes"][0]["html"]) for v in browser.run("return (await axe.run()).violations") if v["impact"] in ("serious", "critical")]
            self.assertEqual(grave, [], f"{theme}, {width} px")
            browser.press("Escape")
            self.assertLessEqual(browser.run("return document.documentElement.scrollWidth"), width)

    def test_zoom_pan_and_the_value_of_a_pixel(self):
        browser = self.browser

        def zoomed_by_the_wheel(box):
            browser.click("#camera-tools >> text=Fit")  # a key acts only once the canvas has the focus
            wait_for(lambda: self.zoom() == 0, what="the whole image")
            return self.wheel(4) / (min(box[2:]) / 512)

        self.assertAlmostEqual(self.in_still_canvas(zoomed_by_the_wheel), 1.4 ** 4, delta=0.05)
        wheeled = self.zoom()
        x, y = self.pixel_in_middle()
        self.assertTrue(250 <= x <= 262 and 250 <= y <= 262, (x, y))
        middle = self.canvas_at(0.5, 0.5)
        browser.drag(middle, (middle[0] - 200, middle[1] + 100))
        moved = self.pixel_in_middle()
        self.assertAlmostEqual(moved[0] - x, 200 / wheeled, delta=3)  # both are rounded, and so is the zoom
        self.assertAlmostEqual(y - moved[1], 100 / wheeled, delta=3)
        browser.mouse(("down",), ("up",), ("move", 5, 5))
        wait_for(lambda: self.pixel() == moved, what="the marked pixel")
        browser.press("Shift+ArrowRight")
        wait_for(lambda: self.pixel() == [moved[0] + 1, moved[1]], what="the next pixel")
        browser.press("Escape")
        browser.wait_text("#camera-readout", lambda text: "Point at the image" in text)
        browser.press("+")
        wait_for(lambda: abs(self.zoom() / wheeled - 1.4) < 0.02, what="the key's zoom")
        browser.press("0")
        wait_for(lambda: self.zoom() == 0, what="the whole image by its key")
        before = self.wheel(1)
        browser.pinch(self.canvas_at(0.5, 0.5), 100.0, 250.0)
        wait_for(lambda: abs(self.zoom() / before - 2.5) < 0.1, what="a zoom by what the fingers move apart")
        browser.press("0")
        browser.click("#camera-tools >> text=1:1")
        wait_for(lambda: self.zoom() == 1.0 or self.zoom() == 0, what="pixel by pixel")
        browser.click("#camera-tools >> text=Fit")
        self.check_console()

    def test_a_frozen_image_is_saved_as_the_camera_made_it(self):
        browser, images = self.browser, self.stream("image", endpoint="tcp://127.0.0.1:7703")
        kept = {}
        browser.click("#camera-tools >> text=Freeze")
        frame = int(browser.wait_text("#camera-badge", lambda text: text.startswith("Frozen")).split()[2].strip(","))
        while frame not in kept and (message := images.next(1.0)):
            kept[message["frame_id"]] = message
            if message["frame_id"] > frame:
                break
        name, png = browser.download("#camera-tools >> text=Raw")
        self.assertRegex(name, r"ovws-camera-raw-\d{8}-\d{6}\.png")
        pixels = numpy.asarray(Image.open(io.BytesIO(png)))
        self.assertEqual((pixels.shape, pixels.dtype), ((512, 512), numpy.uint8))
        if frame in kept:
            self.assertEqual(pixels.tobytes(), kept[frame]["binary"])
        x, y, _, _, level, share, _ = self.readout(0.51, 0.5).groups()
        self.assertEqual(int(level), pixels[int(y), int(x)])
        self.assertAlmostEqual(float(share), 100 * int(level) / 255, delta=0.06)
        time.sleep(0.5)
        self.assertIn(f"frame {frame}", browser.text("#camera-sub"))

        def sizes(_):
            """Of the saved view, and of the canvas."""
            view = Image.open(io.BytesIO(browser.download("#camera-tools >> text=PNG")[1]))
            return [*view.size], browser.run("const c = document.querySelector('#camera-canvas'); return [c.width, c.height]")

        self.assertEqual(*self.in_still_canvas(sizes))
        browser.click("#camera-tools >> text=Freeze")
        wait_for(lambda: f"frame {frame}" not in browser.text("#camera-sub"), what="newer frames")
        self.check_console()

    def test_profile_histogram_and_colours(self):
        browser = self.browser
        browser.click("#camera-tools >> text=Profile")

        def drag(box):
            browser.drag(self.canvas_at(0.3, 0.4), self.canvas_at(0.7, 0.6))
            return box[2:]

        width, height = self.in_still_canvas(drag)
        length = ((0.4 * width) ** 2 + (0.2 * height) ** 2) ** 0.5 * 512 / min(width, height)
        shown = lambda: float(re.search(r"along ([\d.]+) px", browser.wait_text("#profile-text", lambda text: "DN along" in text))[1])
        wait_for(lambda: abs(shown() - length) < 3, what=f"a profile along {length} px")
        colours = """const c = document.querySelector(arguments[0]);
            return new Set(new Uint32Array(c.getContext("2d").getImageData(0, 0, c.width, c.height).data.buffer)).size"""
        for canvas in ("#profile-canvas", "#histogram-canvas"):
            wait_for(lambda canvas=canvas: browser.run(colours, canvas) > 3, what=f"a drawn {canvas}")
        coloured = """const c = document.querySelector("#camera-canvas"); const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
            let n = 0; for (let i = 0; i < d.length; i += 4) if (Math.max(d[i], d[i + 1], d[i + 2]) - Math.min(d[i], d[i + 1], d[i + 2]) > 60) n += 1; return n"""
        browser.run("for (const id of ['marks', 'regions']) document.querySelector(`#show-${id}`).click()")
        browser.click("#camera-tools >> text=Move")
        wait_for(lambda: browser.run(coloured) < 50, what="a grey image without marks")
        self.call("camera.set", {"exposure_us": 9000.0})
        wait_for(lambda: browser.run(coloured) > 2000, what="saturated pixels in their colour")
        self.call("camera.set", {"exposure_us": 1000.0})
        wait_for(lambda: browser.run(coloured) < 50, what="no saturated pixel")
        browser.run("const s = document.querySelector('#camera-scale'); s.value = 'heat'; s.dispatchEvent(new Event('change'))")
        wait_for(lambda: browser.run(coloured) > 2000, what="false colours")
        self.check_looks()
        self.check_console()

    def test_a_region_is_dragged_shown_and_applied(self):
        browser = self.browser
        browser.click("#camera-tools >> text=Region")
        browser.drag(self.canvas_at(0.2, 0.1), self.canvas_at(0.8, 0.9))
        numbers = "return [...document.querySelectorAll('#region input')].map((i) => Number(i.value))"
        x, y, width, height = browser.run(numbers)
        self.assertEqual((x % 4, width % 4, height % 2), (0, 0, 0))
        self.assertIn(f"Sets {width} \u00d7 {height} px at ({x}, {y})", browser.text("#region"))
        self.assertEqual(self.settings()["roi"]["width"], 512)
        self.press("Cancel", "#region")
        self.assertEqual(self.settings()["roi"]["width"], 512)
        browser.click("#camera-tools >> text=Region")
        browser.fill("#region input:nth-of-type(1)", "17")
        browser.fill("#region input:nth-of-type(3)", "9999")
        browser.press("Tab")
        self.assertEqual(browser.run(numbers), [0, 0, 1024, 512])
        self.press("Whole", "#region")
        self.press("Apply", "#region")
        wait_for(lambda: self.settings()["roi"] == {"x": 0, "y": 0, "width": 1024, "height": 1024}, what="the whole sensor")
        browser.click("#camera-tools >> text=Region")
        browser.wait_text("#camera-sub", lambda text: text.startswith("1024 \u00d7 1024"))
        browser.drag(self.canvas_at(0.1, 0.1), self.canvas_at(0.6, 0.6))
        self.press("Apply", "#region")
        roi = wait_for(lambda: (now := self.settings()["roi"])["width"] < 1024 and now, what="the dragged region")
        browser.wait_text("#camera-sub", lambda text: text.startswith(f"{roi['width']} \u00d7 {roi['height']}"))
        sensor_x, _, x, *_ = wait_for(lambda: (found := self.readout(0.5, 0.5))[3] and found, what="both coordinates").groups()
        self.assertEqual(int(sensor_x), roi["x"] + int(x))
        self.check_console()


class LargeCamera(PageCase):
    twin_config = {"camera": {"sensor_width": 2048, "sensor_height": 2048}}
    daemon_config = {"camera": {"roi": {"width": 2048, "height": 2048}, "frame_rate_hz": 10.0}}

    def test_all_pixels_are_there_when_zoomed_in(self):
        browser = self.browser
        browser.wait_text("#camera-badge", lambda text: text == "reduced by 2; zoom in for all pixels")
        self.assertEqual(self.readout(1 / 3, 1 / 3)[7], ", mean of 2 \u00d7 2 pixels")
        self.wheel(6)
        wait_for(lambda: self.readout(0.5, 0.5)[7] == "", what="a value of one pixel")
        wait_for(lambda: browser.run("return document.querySelector('#camera-badge').hidden"), what="no word about reduction")
        fetched = "return [performance.getEntriesByType('resource').filter((e) => e.name.includes('/image?')).length, performance.now() / 1000]"
        (before, began_s), (count, now_s) = (browser.run(fetched) for _ in range(2) if not time.sleep(1.0))
        self.assertLess(count - before, 15 * (now_s - began_s))  # once for each of at most ten images a second
        browser.click("#camera-tools >> text=Freeze")
        browser.click("#camera-tools >> text=Fit")
        browser.wait_text("#camera-badge", lambda text: text.startswith("Frozen") and "reduced" not in text)
        self.check_console()


if __name__ == "__main__":
    browser_main()
