"""The live page's calculations, run by node without a browser, against the Python client's rules and known cases of optics."""
import json
import math
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy

from case import PROGRAM_PATIENCE_S, ROOT, bench_module

bench_module.python_client()
from ovws_client.zernike import MAX_J, orders, phase_map_waves, pupil_grid, zernike  # noqa: E402

PAGE = ROOT / "daemon" / "web" / "page"
# Numbers of Z1 to Z15 of the OSA/ANSI order in published tables: R. J. Noll, J. Opt. Soc. Am. 66, 207 (1976), table I; and the Fringe set.
NOLL = [3, 2, 5, 4, 6, 9, 7, 8, 10, 15, 13, 11, 12, 14, 21]
FRINGE = [3, 2, 6, 4, 5, 11, 8, 7, 10, 18, 13, 9, 12, 17, 27]


class PageModules(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if not shutil.which("node"):
            raise unittest.SkipTest("no node")
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        for path in PAGE.glob("*.js"):
            shutil.copy(path, cls.folder.name)
        pathlib.Path(cls.folder.name, "package.json").write_text('{"type": "module"}')
        script = pathlib.Path(__file__).with_name("page_modules.mjs")
        cls.node = subprocess.Popen(["node", script, cls.folder.name], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        cls.addClassCleanup(cls.end)

    @classmethod
    def end(cls):
        cls.node.stdin.close()
        cls.node.wait(PROGRAM_PATIENCE_S)
        cls.node.stdout.close()

    def run_js(self, module, body, **values):
        """Runs a function body with `m`, the module, and these values; returns its result."""
        self.node.stdin.write(json.dumps({"module": module, "body": body, "values": values}) + "\n")
        self.node.stdin.flush()
        return json.loads(self.node.stdout.readline())

    def test_indices_are_those_of_the_published_tables(self):
        found = self.run_js("zernike.js", "return ['osa', 'noll', 'fringe'].map((k) => js.map(m.INDICES[k].of))", js=list(range(1, 16)))
        self.assertEqual(found, [list(range(1, 16)), NOLL, FRINGE])
        every = self.run_js("zernike.js", "return js.map((j) => [m.orders(j).n, m.orders(j).m])", js=list(range(MAX_J + 1)))
        self.assertEqual([tuple(pair) for pair in every], [orders(j) for j in range(MAX_J + 1)])
        for name in ("noll", "fringe"):
            numbers = self.run_js("zernike.js", f"return js.map(m.INDICES.{name}.of)", js=list(range(MAX_J + 1)))
            self.assertEqual(len(set(numbers)), MAX_J + 1, name)
            if name == "noll":
                self.assertEqual(sorted(numbers), list(range(1, MAX_J + 2)))

    def test_modes_and_maps_are_those_of_the_python_client(self):
        js = [0, 1, 2, 3, 4, 7, 12, 20, 65, 135, 229, MAX_J]
        points = [[0.0, 0.0], [0.3, -0.4], [-0.9, 0.1], [0.6, 0.8]]
        found = self.run_js("zernike.js", "return js.map((j) => at.map(([x, y]) => m.zernike(j, x, y)))", js=js, at=points)
        x, y = numpy.array(points).T
        for j, values in zip(js, found):
            numpy.testing.assert_allclose(values, zernike(j, x, y), atol=1e-5 if j > 100 else 1e-12)
        coefficients = [0.3, -0.2, 0.1, 0.05]
        found = self.run_js("zernike.js", "return m.wavefrontMap(js, c, 128)", js=[1, 3, 8, 12], c=coefficients)
        numpy.testing.assert_allclose(numpy.array(found, float).reshape(128, 128), phase_map_waves([1, 3, 8, 12], coefficients), atol=1e-6)

    def test_unit_amplitude_is_one_at_the_edge(self):
        for j in (1, 4, 5, 8, 12):
            factor = self.run_js("zernike.js", "return m.rmsFactor(j)", j=j)
            n, m = orders(j)
            angle = 0.0 if m >= 0 else math.pi / (2 * -m)
            self.assertAlmostEqual(float(zernike(j, math.cos(angle), math.sin(angle))), factor, 9, j)

    def test_a_change_that_is_refused_says_so_and_takes_no_other_with_it(self):
        send = """const refused = { error: { data: { field: "camera.exposure_us", reason: "too long" } } }, sent = [], shown = [];
            const answer = (params) => { sent.push(params); return params.exposure_us > 5 ? refused : { result: {} }; };
            const sender = new m.Sender(async (params) => answer(params), (reply) => shown.push(m.reasonOf(reply)));
            return Promise.all(changes.map((params) => sender.send(params))).then(() => [sent, shown])"""
        first, gain, long, short = {"exposure_us": 1}, {"gain_db": 3}, {"exposure_us": 9}, {"exposure_us": 2}
        both = {**long, **gain}
        for changes, sent, shown in (
            ([long, gain], [long, gain], "too long"),
            ([long, short], [long, short], ""),
            ([first, long, gain], [first, both, gain], "too long"),
            ([gain, long], [gain, long], "too long"),
        ):
            self.assertEqual(self.run_js("widgets.js", send, changes=changes), [sent, [shown]], changes)

    def test_numbers_have_digits_and_axis_labels_are_short(self):
        found = self.run_js("format.js", "return values.map(m.brief)", values=[0.0003, -0.0012, 0.0123, 0.02, 0.4, 1.5, 12.34, 456.7, 1e-12, 0])
        self.assertEqual(found, ["0.00030", "\u22120.0012", "0.012", "0.020", "0.400", "1.50", "12.3", "457", "0.000000", "0"])
        found = self.run_js("format.js", "return values.map(m.tick)", values=[0, 0.005, -0.25, 1000, 50000, 1e5, 2e5, -1e6, 1.25e7])
        self.assertEqual(found, ["0", "0.005", "\u22120.25", "1000", "50000", "10\u2075", "2\u00b710\u2075", "\u221210\u2076", "1.25\u00b710\u2077"])
        self.assertEqual(self.run_js("format.js", "return [0, 1, 2000].map((n) => m.plural(n, 'frame', 'frames'))"), ["0 frames", "1 frame", "2\u202f000 frames"])

    def test_units(self):
        found = self.run_js("units.js", "return Object.values(m.UNITS).map((u) => 0.1 * u.perWave(632.8))")
        numpy.testing.assert_allclose(found, [0.1, 63.28, 0.2 * math.pi])

    def test_radius_of_curvature_is_that_of_a_sphere(self):
        # The sag of a sphere of 20 m over a pupil of 8 mm at 500 nm, fitted by piston and defocus.
        x, y = pupil_grid(200)
        inside = numpy.hypot(x, y) <= 1
        sag_m = 20 - numpy.sqrt(20**2 - (x[inside]**2 + y[inside]**2) * 4e-3**2)
        basis = numpy.array([zernike(j, x[inside], y[inside]) for j in (0, 4)]).T
        defocus = numpy.linalg.lstsq(basis, sag_m / 500e-9, rcond=None)[0][1]
        self.assertAlmostEqual(self.run_js("units.js", "return m.radiusOfCurvatureM(c, 500, 8)", c=defocus), 20.0, delta=1e-3)
        self.assertAlmostEqual(self.run_js("units.js", "return m.radiusOfCurvatureM(c, 500, 8)", c=-defocus), -20.0, delta=1e-3)

    def refraction(self, coefficients):
        return self.run_js("units.js", "return m.refraction((j) => c[j], 550, 6)", c=coefficients)

    def test_a_lens_is_found_by_its_sphere_cylinder_and_axis(self):
        # A wavefront that a lens of sphere S, cylinder C and axis A corrects: W = -(S r^2 + C (r sin(theta - A))^2) / 2, in m.
        x, y = pupil_grid(200)
        inside = numpy.hypot(x, y) <= 1
        x, y = 3e-3 * x[inside], 3e-3 * y[inside]
        for sphere, cylinder, axis in ((1.5, -0.75, 30.0), (-2.0, -1.0, 120.0), (0.25, -0.5, 0.0), (-1.0, -0.25, 90.0)):
            a = math.radians(axis)
            across = y * math.cos(a) - x * math.sin(a)
            waves = -(sphere * (x**2 + y**2) + cylinder * across**2) / 2 / 550e-9
            basis = numpy.array([zernike(j, x / 3e-3, y / 3e-3) for j in (0, 3, 4, 5)]).T
            c = numpy.linalg.lstsq(basis, waves, rcond=None)[0]
            found = self.refraction({"3": c[1], "4": c[2], "5": c[3]})
            self.assertAlmostEqual(found["sphereD"], sphere, 6)
            self.assertAlmostEqual(found["cylinderD"], cylinder, 6)
            self.assertAlmostEqual(found["axisDeg"], axis, 4)
        self.assertIsNone(self.refraction({"3": 0.1, "4": 0.1}))

    def test_seidel_terms_give_the_same_wavefront(self):
        random = numpy.random.default_rng(5)
        x, y = pupil_grid(100)
        inside = numpy.hypot(x, y) <= 1
        x, y = x[inside], y[inside]
        rho2 = x**2 + y**2
        for _ in range(20):
            c = dict(zip((1, 2, 3, 4, 5, 7, 8, 12), random.normal(size=8)))
            waves = sum(value * zernike(j, x, y) for j, value in c.items())
            found = self.run_js("units.js", "return m.seidel((j) => c[j])", c={str(j): value for j, value in c.items()})
            w = {term["name"]: term["waves"] for term in found}
            along = {term["name"]: (lambda a: x * math.cos(a) + y * math.sin(a))(math.radians(term["angleDeg"] or 0)) for term in found}
            seidel = w["tilt"] * along["tilt"] + w["focus"] * rho2 + w["astigmatism"] * along["astigmatism"]**2
            seidel += w["coma"] * rho2 * along["coma"] + w["spherical"] * rho2**2
            difference = waves - seidel
            self.assertLess(numpy.ptp(difference), 1e-9, "they differ by a constant only")
            middle = 2 * math.sqrt(3) * c[4] - 6 * math.sqrt(5) * c[12]
            bent = math.sqrt(6) * math.hypot(c[3], c[5])
            self.assertAlmostEqual(abs(w["focus"]), min(abs(middle + bent), abs(middle - bent)), 9, "the smaller focus")
        missing = self.run_js("units.js", "return m.seidel((j) => c[j])", c={str(j): 0.1 for j in range(1, 6)})
        self.assertEqual([term["name"] for term in missing if term["waves"] is not None], ["astigmatism"])

    def test_fft_is_that_of_numpy(self):
        values = numpy.random.default_rng(1).normal(size=(2, 16, 16))
        re, im = self.run_js("fft.js", "m.fft2(re, im, 16); return [re, im]", re=values[0].ravel().tolist(), im=values[1].ravel().tolist())
        wanted = numpy.fft.fft2(values[0] + 1j * values[1])
        numpy.testing.assert_allclose(numpy.array(re).reshape(16, 16) + 1j * numpy.array(im).reshape(16, 16), wanted, atol=1e-12)

    def psf(self, coefficients):
        """(PSF, MTF, peak, pixels per lambda/D) of a wavefront with these coefficients by j."""
        self.assertEqual(self.run_js("psf.js", "return m.PUPIL_PX"), 64)
        waves = phase_map_waves(list(coefficients), list(coefficients.values()), 64)
        values = [[None if math.isnan(value) else value for value in row] for row in waves.tolist()]
        psf, mtf, peak, scale = self.run_js(
            "psf.js", "const p = m.psfOf(Float32Array.from(w.flat(), (v) => v ?? NaN)); return [p.values, m.mtfOf(p), p.peak, m.PX_PER_LAMBDA_D]", w=values)
        size = math.isqrt(len(psf))
        return numpy.array(psf).reshape(size, size), mtf, peak, scale

    def test_psf_without_aberration_is_airys(self):
        psf, mtf, peak, scale = self.psf({4: 0.0})
        middle = psf.shape[0] // 2
        self.assertAlmostEqual(peak, 1.0, 6)
        self.assertEqual(numpy.unravel_index(psf.argmax(), psf.shape), (middle, middle))
        t = numpy.linspace(0, math.pi, 2001)
        for line in (psf[middle, middle:], psf[middle:, middle]):
            z = math.pi * numpy.arange(1, 60) / scale
            bessel = numpy.array([numpy.cos(t - v * numpy.sin(t)).mean() for v in z])
            numpy.testing.assert_allclose(line[1:60], (2 * bessel / z)**2, atol=0.004)
            # The first zero of the amplitude, linear between the samples beside it.
            before, behind = numpy.sqrt(line[[4, 5]])
            zero = 4 + before / (before + behind)
            self.assertAlmostEqual(zero / scale, 1.2197, delta=0.02)
        for point in mtf:
            self.assertAlmostEqual(point["x"], point["limit"], delta=0.015)
            self.assertAlmostEqual(point["y"], point["limit"], delta=0.015)
        self.assertAlmostEqual(mtf[32]["limit"], 0.391, delta=0.001)
        self.assertAlmostEqual(mtf[64]["x"], 0.0, delta=1e-3)

    def test_strehl_of_a_known_aberration(self):
        # Defocus of c waves RMS: the intensity on the axis is (sin(2 sqrt(3) pi c) / (2 sqrt(3) pi c))^2, exactly.
        for c in (0.02, 0.1, 0.2):
            exact = numpy.sinc(2 * math.sqrt(3) * c) ** 2
            psf, mtf, peak, _ = self.psf({4: c})
            middle = psf.shape[0] // 2
            self.assertAlmostEqual(psf[middle, middle], exact, delta=0.005)
            strehl = self.run_js("units.js", "return m.strehlOf(w.map((v) => v ?? NaN))",
                                 w=[None if math.isnan(v) else v for v in phase_map_waves([4], [c]).ravel().tolist()])
            self.assertAlmostEqual(strehl, exact, delta=0.003)
            self.assertLess(mtf[32]["x"], mtf[32]["limit"] + 0.01)

    def test_tilt_moves_the_spot_to_where_the_wavefront_rises(self):
        psf, _, peak, scale = self.psf({2: 0.5})  # RMS 0.5: 2 waves over the diameter, thus 2 lambda/D
        middle = psf.shape[0] // 2
        self.assertEqual(numpy.unravel_index(psf.argmax(), psf.shape), (middle, middle + round(2 * scale)))
        self.assertAlmostEqual(peak, 1.0, delta=0.01)

    def test_contours_of_known_surfaces(self):
        bowl = (phase_map_waves([4], [1.0], 64) / math.sqrt(3) + 1) / 2  # rho^2
        values = [None if math.isnan(v) else v for v in bowl.ravel().tolist()]
        body = "return m.contour(w.map((v) => v ?? NaN), 64, level)"
        for level in (0.25, 0.5):
            ends = numpy.array(self.run_js("contour.js", body, w=values, level=level)).reshape(-1, 2)
            radius = numpy.hypot(*((2 * ends + 1) / 64 - 1).T)
            numpy.testing.assert_allclose(radius, math.sqrt(level), atol=0.002)
            self.assertGreater(len(ends), 100)
        self.assertEqual(self.run_js("contour.js", "return m.levels(-0.45, 0.41, 0.2)"), [-0.4, -0.2, 0, 0.2, 0.4])

    def lightness(self, abgr):
        """OKLab lightness of a colour."""
        srgb = numpy.array([abgr & 255, abgr >> 8 & 255, abgr >> 16 & 255]) / 255
        linear = numpy.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
        lms = numpy.array([[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566], [0.0883024619, 0.2817188376, 0.6299787005]]) @ linear
        return float(numpy.array([0.2104542553, 0.793617785, -0.0040720468]) @ numpy.cbrt(lms))

    def test_palettes_have_even_steps_of_lightness(self):
        names = [*self.run_js("palette.js", "return m.SIGNED"), "heat"]
        for name, dark in [(name, dark) for name in names for dark in (False, True)]:
            colours = self.run_js("palette.js", "return m.palette(name, dark)", name=name, dark=dark)
            found = numpy.array([self.lightness(colour) for colour in colours])
            halves = [found] if name in ("grey", "heat") else [found[:256], found[256:]]
            for half in halves:
                even = numpy.linspace(half[0], half[-1], len(half))
                self.assertLess(numpy.abs(half - even).max(), 0.01, name)
                self.assertGreater(abs(half[-1] - half[0]), 0.5, name)

    def test_the_hour_is_coarse_with_fine_bins_at_its_end_and_bounded(self):
        body = """globalThis.localStorage = { getItem: () => null, setItem() {} };
            const bin = (bin_s, end_s) => m.takeTrend({ bin_s, span_s: bin_s, t_ns: end_s * 1e9 });
            for (let t = 0.5; t <= 4000; t += 0.5) { bin(0.5, t); if (t % 5 === 0 && t < 4000) bin(5, t); }
            return m.SPANS.map(([seconds]) => { m.chooseSpan(seconds); const list = m.bins();
                return [list.length, list[0].t_ns / 1e9, list.at(-1).t_ns / 1e9, list.slice(1).some((next, i) => m.isGap(list[i], next))]; })"""
        three, quarter, hour = self.run_js("history.js", body)
        self.assertEqual(three, [361, 3820.0, 4000.0, False])
        self.assertEqual(quarter[2:], [4000.0, False])
        self.assertAlmostEqual(quarter[1], 3100.0, delta=5.0)
        self.assertEqual(hour[2:], [4000.0, False])
        self.assertAlmostEqual(hour[1], 400.0, delta=5.0)
        self.assertAlmostEqual(hour[0], 720, delta=12)
        # Bins that arrive again are ignored; a clock that was set back by more begins again.
        again = """const bin = (t) => m.takeTrend({ bin_s: 0.5, span_s: 0.5, t_ns: t * 1e9 }); m.chooseSpan(180);
            bin(3999); const known = m.bins().length; bin(100); return [known, m.bins().length, m.minutesAgo(1), m.minutesAgo(0)]"""
        self.assertEqual(self.run_js("history.js", again), [361, 1, "\u22123 min", "now"])

    def test_csv_is_quoted_and_has_all_digits(self):
        text = self.run_js("save.js", 'return m.csvText({ unit: "nm" }, [["a", "b,\\"c"], [1 / 3, null], [NaN, -2]])')
        self.assertEqual(text, '# unit: nm\na,"b,""c"\n0.3333333333333333,\n,-2\n')

    def test_a_dragged_region_becomes_one_that_the_camera_has(self):
        limits = {"roi_width": {"min": 16, "max": 1024, "increment": 16}, "roi_height": {"min": 2, "max": 770, "increment": 2}, "sensor_width": 1032, "sensor_height": 771}
        for dragged, wanted in (((3.2, 5.7, 100.4, 33.3), (0, 6, 96, 34)), ((-50, -50, 5000, 5000), (0, 0, 1024, 770)), ((1031, 770, 0, 0), (1008, 768, 16, 2)),
                                ((500, 300, 8, 1), (496, 300, 16, 2))):
            region = dict(zip(("x", "y", "width", "height"), dragged))
            found = self.run_js("region.js", "return m.snapped(region, limits)", region=region, limits=limits)
            self.assertEqual(tuple(found[key] for key in region), wanted, dragged)

    def test_the_sentence_about_exposure_speaks_of_spots_where_they_are_known(self):
        image = {"saturated": 0, "brightest": 200, "full": 255, "width": 100, "height": 100}
        for changes, peaks, wellness, words in (({}, [], "", "brightest pixel reaches 78 %"), ({}, [102, 51], "", "brightest spot reaches 40 %"), ({}, [25], "note", "Raise the exposure"),
                                                ({"saturated": 3}, [102], "", "None is in a spot"), ({"saturated": 3}, [], "warning", "3 pixels are saturated (<0.03>"),
                                                ({"saturated": 1}, [255, 255, 20], "warning", "2 spots are measured wrong")):
            found = self.run_js("histogram.js", "return m.verdict(image, peaks)", image=image | changes, peaks=peaks)
            self.assertEqual(found["wellness"], wellness, found["text"])
            self.assertIn(words.replace("<0.03>", "0.030 %)"), found["text"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
