"""The live page's wavefront, coefficients and history in a real browser: figures, units, exports, alarm and the hour that the server keeps."""
import csv
import io
import math
import time

import numpy

from case import wait_for
from ovws_client.zernike import phase_map_waves, pupil_grid, zernike
from PIL import Image
from web_case import ADDRESS, BrowserCase, browser_main

SHOWN = {3: 0.2, 4: 0.1, 8: -0.1}  # waves
WAVELENGTH_NM, PUPIL_MM = 632.0, 768 * 19e-3
LAMBDA_PX = 632e-3 * 200 / PUPIL_MM / 3.45  # lambda/D on the camera
NOISE = 0.006  # waves: difference between introduced and measured coefficients


def table(data):
    """(facts, rows) of a CSV file with a head of `# key: value`."""
    lines = data.decode().splitlines()
    facts = dict(line[2:].split(": ", 1) for line in lines if line.startswith("# "))
    return facts, list(csv.reader(line for line in lines if not line.startswith("# ")))


def number(text):
    """The first number of a text of the page."""
    return float(text.replace("\u2212", "-").replace("+", "").split()[0].rstrip("\u00b0"))


def numbers(rows):
    return numpy.array([[float(cell) if cell else math.nan for cell in row] for row in rows])


class PageWavefront(BrowserCase):
    daemon_config = {"tracking": {"tracker": "fit"}}

    def setUp(self):
        super().setUp()
        self.message("ovws.status/1")  # from here on ovws-web hears every event
        self.take_reference()
        self.call("aberration.set", {"modes": [{"j": j, "waves": waves} for j, waves in SHOWN.items()]})
        self.browser = self.new_browser(1000)
        self.browser.open(self.links["control"])
        self.browser.wait_text("#figures dd .value", lambda text: text.startswith("0.24"))
        self.open_folds()

    def open_folds(self):
        self.browser.run("document.querySelectorAll('.tools details, .derived').forEach((fold) => { fold.open = true; })")

    def tearDown(self):
        self.assertEqual([line for line in self.browser.ask("said") if ADDRESS in line], [])

    def caption(self, what):
        """Waits until the map's caption contains a text; returns the caption."""
        return self.browser.wait_text("#map-caption", lambda text: what in text)

    def rows(self, selector):
        return self.browser.run("return [...document.querySelectorAll(`${arguments[0]} tbody tr`)].map((r) => [...r.cells].map((c) => c.textContent))", selector)

    def pixels(self, selector):
        return self.browser.run("const c = document.querySelector(arguments[0]); return c.toDataURL()", selector)

    def press(self, panel, text):
        self.browser.click(f"{panel} .tools >> text={text}")

    def freeze(self):
        """Freezes the page at a frame that templates of its wavefront measured: those of the one before measure the first frames.
        Returns its coefficients in waves by j."""
        def with_errors():
            self.press("#modes", "Freeze")
            found = self.browser.download("#modes .tools button >> text=CSV")
            rows = table(found[1])[1][1:]
            if all(row[5] and abs(float(row[4]) - SHOWN.get(int(row[0]), 0.0)) <= NOISE for row in rows):
                return found
            self.press("#modes", "Freeze")  # the button shows live frames again
            return None

        name, data = wait_for(with_errors, what="a frame with standard errors and the coefficients that are introduced")
        self.assertRegex(name, r"^ovws-coefficients-\d{8}-\d{6}\.csv$")
        facts, (head, *rows) = table(data)
        self.assertEqual(head, ["index_osa", "n", "m", "name", "coefficient_wave", "standard_error_wave"])
        self.assertEqual(rows[2][1:4], ["2", "-2", "oblique astigmatism"])
        self.assertTrue(all(0 < float(row[5]) < 0.01 for row in rows))
        return facts, {int(row[0]): float(row[4]) for row in rows}

    def test_figures_of_a_frozen_frame(self):
        facts, found = self.freeze()
        frame = f"frame {facts['frame_id']}"
        self.browser.wait_text("#map-sub", lambda text: text.startswith("frozen") and text.endswith(frame))
        time.sleep(0.6)
        self.assertTrue(self.browser.text("#map-sub").endswith(frame), "it stays frozen")
        truth = phase_map_waves(list(found), list(found.values()))
        self.check_map(truth, found)
        self.check_terms(facts, found)
        self.press("#map", "without tilts")
        self.press("#map", "without defocus")
        text = self.caption("Tilts and defocus left out, by their coefficients")
        without = {j: 0.0 if j in (1, 2, 4) else waves for j, waves in found.items()}
        self.assertAlmostEqual(float(text.split()[6]), math.hypot(*without.values()), delta=1e-4)
        self.assertNotIn("radius", text)
        facts, rows = table(self.browser.download("#map .tools button >> text=CSV")[1])
        self.assertEqual(facts["left_out_defocus"], "yes")
        numpy.testing.assert_allclose(numbers(rows), phase_map_waves(list(without), list(without.values())), atol=2e-6)
        self.press("#map", "Freeze")
        self.browser.wait_text("#map-sub", lambda text: not text.startswith("frozen") and text != frame)

    def check_map(self, truth, found):
        """The map's file and caption against the coefficients."""
        name, data = self.browser.download("#map .tools button >> text=CSV")
        facts, rows = table(data)
        self.assertRegex(name, r"^ovws-wavefront-.*\.csv$")
        self.assertEqual((facts["unit"], float(facts["wavelength_nm"])), ("wave", WAVELENGTH_NM))
        numpy.testing.assert_allclose(numbers(rows), truth, atol=2e-6)
        text = self.caption("radius of curvature")
        words = text.split()
        self.assertAlmostEqual(float(words[3]), numpy.nanmax(truth) - numpy.nanmin(truth), delta=0.006)
        self.assertAlmostEqual(float(words[6]), math.hypot(*found.values()), delta=1e-4)
        untilted = phase_map_waves([j for j in found if j > 2], [waves for j, waves in found.items() if j > 2])
        strehl = abs(numpy.nanmean(numpy.exp(2j * math.pi * untilted))) ** 2
        self.assertAlmostEqual(float(text.split("Strehl ratio ")[1].split(",")[0]), strehl, delta=0.0006)
        # The curvature at the pupil's centre of the mode alone, by differences.
        step = 1e-3
        bend = (zernike(4, step, 0) + zernike(4, -step, 0) - 2 * zernike(4, 0, 0)) / step**2 * found[4] * WAVELENGTH_NM * 1e-9
        self.assertAlmostEqual(float(text.split("curvature ")[1].split()[0]), (PUPIL_MM / 2e3) ** 2 / bend, delta=0.6)

    def check_terms(self, facts, found):
        """Seidel terms, sphere and cylinder against differences of the wavefront."""
        shown = {row[0]: row[1:] for row in self.rows(".derived")}
        second = lambda x, y: sum(found[j] * zernike(j, x, y) for j in (3, 4, 5))
        across = second(math.sqrt(0.5), math.sqrt(0.5)) - second(math.sqrt(0.5), -math.sqrt(0.5))
        self.assertAlmostEqual(number(shown["Seidel astigmatism"][0]), across, delta=0.003)
        self.assertAlmostEqual(number(shown["Seidel astigmatism"][1]), 45.0, delta=0.5)
        # Along x, coma is a rho^3 + b rho.
        a, _ = numpy.linalg.solve([[1, 1], [0.125, 0.5]], [found[8] * zernike(8, 1, 0), found[8] * zernike(8, 0.5, 0)])
        self.assertAlmostEqual(number(shown["Seidel coma"][0]), abs(a), delta=0.003)
        self.assertAlmostEqual(number(shown["Seidel coma"][1]), 180.0, delta=2.0)
        # The powers of the correcting lens: eigenvalues of minus the wavefront's second derivatives.
        h = 1e-2
        at = lambda x, y: float(second(x, y))
        xx, yy = at(h, 0) + at(-h, 0) - 2 * at(0, 0), at(0, h) + at(0, -h) - 2 * at(0, 0)
        xy = (at(h, h) + at(-h, -h) - at(h, -h) - at(-h, h)) / 4
        scale = WAVELENGTH_NM * 1e-9 / (h * PUPIL_MM / 2e3) ** 2
        powers, meridians = numpy.linalg.eigh(-scale * numpy.array([[xx, xy], [xy, yy]]))
        self.assertAlmostEqual(number(shown["sphere"][0]), powers[1], delta=1e-4)
        self.assertAlmostEqual(number(shown["cylinder"][0]), powers[0] - powers[1], delta=1e-4)
        axis = math.degrees(math.atan2(meridians[1, 1], meridians[0, 1])) % 180
        self.assertAlmostEqual(number(shown["cylinder"][1]), axis, delta=0.06)
        self.assertAlmostEqual(float(facts["pupil_mm"]), PUPIL_MM, 9)
        self.assertAlmostEqual(float(facts["sphere_D"]), powers[1], delta=1e-6)

    def test_units_index_and_normalisation_hold_for_the_whole_page(self):
        _, found = self.freeze()
        unit, norm, index = (f"#modes .tools .options label:nth-child({k}) select" for k in (1, 2, 3))
        for name, per_wave in (("nm", WAVELENGTH_NM), ("rad", 2 * math.pi)):
            self.browser.choose(unit, name)
            self.browser.wait_text("#mode-table thead", lambda text: f"mode{name}" in text)
            row = self.rows("#mode-table")[2]
            self.assertEqual(row[0], "Z3oblique astigmatism")
            self.assertAlmostEqual(number(row[1]), found[3] * per_wave, delta=0.01)
            self.browser.wait_text("#figures dd", lambda text: text.endswith(name))  # with the first value in this unit
            self.assertAlmostEqual(number(self.browser.text("#figures dd .value")), math.hypot(*SHOWN.values()) * per_wave, delta=NOISE * per_wave)
            self.assertAlmostEqual(float(self.caption(f" {name}, RMS").split()[6]), math.hypot(*found.values()) * per_wave, delta=0.02)
            self.browser.wait_text("#trends figcaption .title", lambda text: text == f"RMS without tilts, {name}")
        self.browser.choose(norm, "unit")
        self.browser.choose(index, "noll")
        rows = wait_for(lambda: (rows := self.rows("#mode-table"))[3][0] == "Z5oblique astigmatism" and rows)
        self.assertEqual([row[0].split("v")[0] for row in rows[:2]], ["Z2horizontal tilt", "Z3"])
        self.assertAlmostEqual(number(rows[3][1]), found[3] * math.sqrt(6) * 2 * math.pi, delta=0.001)
        self.browser.choose(index, "fringe")
        wait_for(lambda: [row[0] for row in self.rows("#mode-table")[2:5]] == ["Z4defocus", "Z5vertical astigmatism", "Z6oblique astigmatism"])
        facts, (head, *rows) = table(self.browser.download("#modes .tools button >> text=CSV")[1])
        self.assertEqual((head[0], head[4], facts["normalisation"]), ("index_fringe", "coefficient_rad", "unit amplitude"))
        self.assertAlmostEqual(float(rows[2][4]), found[4] * math.sqrt(3) * 2 * math.pi, 6)
        self.browser.ask("clipboard")
        self.press("#modes", "Copy")
        wait_for(lambda: self.browser.ask("clipboard").startswith("index_fringe\tn\tm\tname\tcoefficient_rad"), what="the copied table")
        self.assert_png(self.browser.download("#modes .tools button >> text=PNG")[1], 700)
        whiskers = self.browser.run("return [...document.querySelectorAll('td.bar b')].map((b) => [b.hidden, parseFloat(b.style.width)])")
        self.assertTrue(all(not hidden and 0 <= width < 5 for hidden, width in whiskers))
        self.browser.ask("reload")
        self.browser.wait_text("#mode-table", lambda text: "Z6oblique astigmatism" in text and "moderad" in text)

    def assert_png(self, data, least_px):
        image = Image.open(io.BytesIO(data)).convert("RGB")
        self.assertGreater(image.width, least_px)
        self.assertGreater(len(image.getcolors(1 << 20)), 30)

    def test_scale_colours_contours_and_far_field(self):
        view = "#map .tools .keys select"
        self.press("#modes", "Freeze")
        drawn = self.pixels("#map-canvas")
        for what in ("contours", "lock scale"):
            self.press("#map", what)
        wait_for(lambda: self.pixels("#map-canvas") != drawn, what="contours")
        self.caption("Contours every 0.200 wave")
        limit = "#map .tools input[type=number]"
        self.browser.fill(limit, "0.5")
        self.browser.press("Enter")
        self.caption("Contours every 0.100 wave")
        for name in ("purple\u2013green", "grey"):
            drawn = self.pixels("#map-canvas")
            self.browser.choose("#map .tools .options select", name)
            wait_for(lambda: self.pixels("#map-canvas") != drawn, what=f"other colours: {name}")
        self.browser.ask("clipboard")
        self.press("#map", "Copy")
        wait_for(lambda: self.browser.ask("clipboard").startswith("Peak to valley 1."), what="the copied figures")
        self.assert_png(self.browser.download("#map .tools button >> text=PNG")[1], 900)
        self.check_psf(view)
        self.browser.choose(view, "mtf")
        self.caption("Contrast")
        facts, (head, *rows) = table(self.browser.download("#map .tools button >> text=CSV")[1])
        mtf = numbers(rows)
        self.assertEqual(head[:2], ["frequency_D_per_lambda", "frequency_cycles_per_mm"])
        self.assertAlmostEqual(mtf[-1, 1], 1000 / (LAMBDA_PX * 3.45), delta=0.01)
        self.assertTrue((mtf[:, 2:4] <= mtf[:, 4:] + 0.02).all(), "an aberration lowers the MTF")
        numpy.testing.assert_allclose(mtf[0, 2:], 1.0, atol=1e-6)
        self.browser.ask("reload")
        self.browser.wait_text("#map-caption", lambda text: "Contrast" in text)
        self.assertEqual(self.browser.run("return document.querySelector(arguments[0]).value", limit), "0.5")

    def check_psf(self, view):
        """The PSF's file against a direct Fourier transform in the pupil."""
        self.browser.choose(view, "psf")
        text = self.caption("Intensity relative to the peak")
        self.assertAlmostEqual(float(text.split("\u03bb/D = ")[1].split()[0]), LAMBDA_PX, delta=0.01)
        facts, rows = table(self.browser.download("#map .tools button >> text=CSV")[1])
        psf = numbers(rows)
        _, found = self.frozen_coefficients()
        x, y = pupil_grid(64)
        waves = phase_map_waves(list(found), list(found.values()), 64)
        inside = ~numpy.isnan(waves)
        field = numpy.exp(2j * math.pi * waves[inside])
        middle, per_lambda = int(facts["axis_pixel"]), float(facts["pixels_per_lambda_D"])
        for row, column in ((middle, middle), (middle + 3, middle - 2), (middle - 5, middle + 4)):
            u, v = (column - middle) / per_lambda, (row - middle) / per_lambda
            direct = abs((field * numpy.exp(-1j * math.pi * (u * x[inside] + v * y[inside]))).mean()) ** 2
            self.assertAlmostEqual(psf[row, column], direct, delta=1e-4)
        drawn = self.pixels("#map-canvas")
        self.press("#map", "logarithmic")
        wait_for(lambda: self.pixels("#map-canvas") != drawn, what="a logarithmic scale")

    def frozen_coefficients(self):
        facts, (_, *rows) = table(self.browser.download("#modes .tools button >> text=CSV")[1])
        return facts, {int(row[0]): float(row[4]) for row in rows}

    def test_history_alarm_and_events(self):
        limit = "#trends .tools input[type=number]"
        self.browser.fill(limit, "0.1")
        self.browser.press("Enter")
        self.browser.wait_text("#verdict p", lambda text: text.startswith("RMS 0.24") and text.endswith("wave is above the alarm limit of 0.1000 wave"))
        self.assertIn("RMS 0.24", self.browser.run("return document.title"))
        self.press("#trends", "sound")
        self.press("#trends", "notification")
        wait_for(lambda: self.browser.run("return [...document.querySelectorAll('#trends input[type=checkbox]')].map((c) => c.checked)") == [True, False], what="a refused notification")
        wait_for(lambda: len(self.history()[1]) > 12, what="seven seconds of history")
        before = self.history()
        self.check_marks()
        self.check_cursor()
        self.assert_png(self.browser.download("#trends .tools button >> text=PNG")[1], 900)
        self.browser.choose("#trends .tools .keys select", "3600")
        self.browser.wait_text("#trends-sub", lambda text: text == "last 1 h")
        self.browser.wait_text("#strip-title", lambda text: text == "last 1 h")
        head, hour = self.history()
        self.assertEqual(float(hour[0][1]), 5.0)
        # Reloaded, the page has the bins that the server kept.
        self.browser.ask("reload")
        self.browser.wait_text("#verdict p", lambda text: text.startswith("RMS 0.24"))
        self.browser.wait_text("#trends-sub", lambda text: text == "last 1 h")
        self.assertEqual(self.history()[1][0], hour[0])
        self.browser.choose("#trends .tools .keys select", "180")
        after = wait_for(lambda: (table := self.history())[1][-1][0] > before[1][-1][0] and table, what="the history after the reload")
        self.assertEqual(after[0], before[0])
        kept = [row for row in after[1] if row[0] <= before[1][-1][0]]
        self.assertEqual(kept, before[1][-len(kept):])
        self.assertGreater(len(kept), 10)
        self.open_folds()
        self.browser.fill(limit, "")
        self.browser.press("Enter")
        self.browser.wait_text("#verdict p", lambda text: "alarm" not in text)

    def history(self):
        facts, (head, *rows) = table(self.browser.download("#trends .tools button >> text=CSV")[1])
        self.assertEqual(head[6:9], ["rms_mean_wave", "rms_min_wave", "rms_max_wave"])
        last = dict(zip(head, rows[-1]))
        self.assertAlmostEqual(float(last["rms_mean_wave"]), math.hypot(*SHOWN.values()), delta=NOISE)
        self.assertLessEqual(float(last["rms_min_wave"]), float(last["rms_max_wave"]))
        self.assertAlmostEqual(float(last["z3_wave"]), SHOWN[3], delta=NOISE)
        return head, rows

    def check_marks(self):
        """Events on the time axis: the text shows on focus and arrows move."""
        texts = self.browser.run("return [...document.querySelectorAll('.mark-button:not([hidden])')].map((b) => b.getAttribute('aria-label'))")
        self.assertTrue(any("reference.take" in text for text in texts), texts)
        self.browser.run("document.querySelector('.mark-button[tabindex=\"0\"]').focus()")
        self.browser.wait_text(".mark-text", lambda text: text == texts[-1])
        self.browser.press("ArrowLeft")
        self.browser.wait_text(".mark-text", lambda text: text == texts[-2])
        self.browser.run("document.activeElement.blur()")

    def check_cursor(self):
        """The cursor shows the values of a time, by pointing at a chart and by the slider."""
        size = self.browser.run("const c = document.querySelector('#trends canvas'); return [c.clientWidth, c.clientHeight]")
        self.browser.ask("hover", selector="#trends figure:first-of-type canvas", x=size[0] - 6, y=size[1] / 2)
        self.browser.wait_text("#trends figcaption .value", lambda text: ":" in text and "0.24" in text)
        self.browser.ask("hover", selector="#trends h2", x=2, y=2)
        self.browser.wait_text("#trends figcaption .value", lambda text: ":" not in text)
        self.browser.run("document.querySelector('.cursor').focus()")
        for _ in range(4):
            self.browser.press("ArrowLeft")
        self.browser.wait_text("#trends-sub", lambda text: text.startswith("at "))
        self.browser.press("End")
        self.browser.wait_text("#trends-sub", lambda text: text.startswith("last "))

    def test_nothing_keeps_anybody_out(self):
        self.check_axe(("dark", 390), ("light", 1440))
        reached = set()
        self.browser.run("document.querySelector('#map .tools select').focus()")
        for _ in range(70):
            self.browser.press("Tab")
            reached.add(self.browser.run("const e = document.activeElement; return e.parentElement.textContent && e.closest('label')?.textContent || e.textContent || e.className"))
        for wanted in ("Freeze", "Copy", "CSV", "PNG", "Options", "without tilts", "contours", "lock scale", "Seidel terms, sphere and cylinder", "sound"):
            self.assertTrue(any(wanted in text for text in reached), wanted)


if __name__ == "__main__":
    browser_main()
