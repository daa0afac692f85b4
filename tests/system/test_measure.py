"""ovws measure: results and errors for good and bad image files."""
import json
import math
import os
import random
import resource
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
from PIL import Image

from case import PROGRAM_PATIENCE_S, bench_module

OVWS = bench_module.find_programs() / "ovws"


class Measure(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def ovws(self, *arguments, status=0):
        done = subprocess.run([OVWS, "--json", *map(str, arguments)], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        if status is None:
            status = int(any("error" in line for line in lines))
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        return lines

    def farfield(self, name, modes="", bits=12, *more):
        path = self.folder / name
        self.ovws("farfield", "--modes", modes, "--bits", bits, *more, "-o", path)
        return path

    def save(self, name, pixels):
        path = self.folder / name
        Image.fromarray(pixels).save(path)
        return path

    def measure(self, *images, reference=None, more=()):
        base = ("--reference", reference) if reference else ("--model-reference",)
        return self.ovws("measure", *base, *more, *images)

    def assert_mode(self, line, wanted):
        self.assertTrue(line["valid"], line)
        for j, value in zip(line["j"], line["coefficients"]):
            self.assertAlmostEqual(value, wanted.get(j, 0.0), delta=0.02, msg=f"j = {j}")

    def test_png_tiff_and_pgm_of_8_and_16_bit_give_the_same(self):
        wide = self.farfield("wide.png", "2,-2:0.3")
        pixels = np.asarray(Image.open(wide)).astype(np.uint16)
        files = [wide, self.save("wide.tiff", pixels), self.farfield("narrow.png", "2,-2:0.3", 8)]
        narrow = np.asarray(Image.open(files[2]))
        files += [self.save("narrow.pgm", narrow), self.save("narrow.tif", narrow)]
        high = self.folder / "wide.pgm"
        high.write_bytes(b"P5 512 512 65535\n" + pixels.astype(">u2").tobytes())
        reference = self.farfield("flat.png", "")
        lines = self.measure(*files, high, reference=reference)
        self.assertEqual([Path(line["file"]).name for line in lines], [f.name for f in [*files, high]])
        for line in lines:
            self.assert_mode(line, {3: 0.3})
            self.assertEqual(len(line["spots"]), 19)
            self.assertEqual(sorted(line["spots"][0]), ["i", "quality", "x", "y"])

    def test_every_page_of_a_stack_is_measured(self):
        flat, aberrated = self.farfield("flat.png"), self.farfield("aberrated.png", "2,-2:0.3")
        pages = [Image.fromarray(np.asarray(Image.open(path)).astype(np.uint16)) for path in (flat, aberrated, flat)]
        stack = self.folder / "stack.tif"
        pages[0].save(stack, save_all=True, append_images=pages[1:])
        lines = self.measure(stack, aberrated, reference=flat)
        self.assertEqual([(line["file"], line["page"]) for line in lines], [(str(stack), 1), (str(stack), 2), (str(stack), 3), (str(aberrated), 1)])
        for line, astigmatism in zip(lines, (0.0, 0.3, 0.0, 0.3)):
            self.assert_mode(line, {3: astigmatism})
        text = subprocess.run([OVWS, "measure", "--reference", flat, stack], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S).stdout
        self.assertIn(f"{stack}, page 2 of 3: 19 of 19 spots, valid", text)
        small = [pages[0], pages[0].resize((20, 20)), pages[1]]
        small[0].save(stack, save_all=True, append_images=small[1:])
        lines = self.ovws("measure", "--reference", flat, stack, status=1)
        self.assertEqual([line.get("page") for line in lines], [1, None, 3])
        self.assertIn(f"{stack}, page 2 of 3: ", str(lines[1]))
        (line,) = self.ovws("measure", "--reference", stack, flat, status=1)
        self.assertIn("has 3 pages: give a file with one image", str(line))

    def test_saturation_is_told_at_the_depth_of_the_camera(self):
        """12 bits in words of 16 bits, in either alignment, with the camera's format in the configuration and without."""
        good = np.asarray(Image.open(self.farfield("good.png", "2,-2:0.1"))).astype(np.uint16)
        clipped = np.minimum(good.astype(np.uint32) * 4095 * 2 // good.max(), 4095).astype(np.uint16)
        mono12 = self.folder / "mono12.json"
        mono12.write_text(json.dumps({"camera": {"pixel_format": "Mono12"}}))
        for name, shift in (("low", 0), ("high", 4)):
            fine, cut = self.save(f"good-{name}.png", good << shift), self.save(f"cut-{name}.png", clipped << shift)
            for more in ((), ("--config", mono12)):
                with self.subTest(name, more=more):
                    whole, lines = self.measure(fine, cut, more=more)
                    self.assertEqual(whole["saturated"], 0.0)
                    self.assert_mode(whole, {3: 0.1})
                    self.assertEqual(lines["saturated"], 1.0)
                    text = subprocess.run([OVWS, "measure", "--model-reference", *more, fine, cut], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S).stdout
                    self.assertEqual(text.count("19 of 19 spots are saturated: lower the exposure or the gain"), 1, text)
        burnt = self.save("burnt.png", np.minimum(good.astype(np.uint32) * 100, 4095).astype(np.uint16))
        (line,) = self.ovws("measure", "--reference", burnt, fine, status=1)
        self.assertRegex(str(line), "not found in the reference image: .*; spots are saturated: lower the exposure")

    def test_all_pages_of_a_stack_have_one_depth(self):
        """A page that tells neither alignment nor full scale has those of the other pages."""
        def stack(name, *pages):
            first, *others = map(Image.fromarray, pages)
            first.save(self.folder / name, save_all=True, append_images=others)
            return self.folder / name

        bright, dim = (np.asarray(Image.open(self.farfield(f"{peak}.png", "2,-2:0.1", 12, "--peak", peak))).astype(np.uint16) for peak in (5000, 300))
        self.assertLess(dim.max(), 256)
        camera = ("--refine", "--electrons-per-dn", 10000 / 4095, "--black-level", 2, "--read-noise", 6)
        mono12 = self.folder / "mono12.json"
        mono12.write_text(json.dumps({"camera": {"pixel_format": "Mono12"}}))
        plain = self.measure(self.save("dim.png", dim), self.save("bright.png", bright), more=(*camera, "--config", mono12))
        for line, same in zip(self.measure(stack("aligned.tif", dim << 4, bright << 4), more=camera), plain, strict=True):
            self.assert_mode(line, {3: 0.1})
            self.assertEqual(line["refined"], same["refined"])
        cut, one, spot = np.minimum(bright * 4, 4095), bright.copy(), plain[1]["spots"][9]
        one[round(spot["y"]), round(spot["x"])] = 4095
        lines = self.measure(stack("cut.tif", one, cut))
        self.assertEqual([round(19 * line["saturated"]) for line in lines], [1, 19])

    def test_an_image_that_cannot_be_written_leaves_the_one_before(self):
        path = self.farfield("flat.png")
        before = path.read_bytes()
        done = subprocess.run([OVWS, "farfield", "-o", path], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)), restore_signals=False)
        self.assertEqual((done.returncode, path.read_bytes(), os.listdir(self.folder)), (1, before, ["flat.png"]), done)
        link = self.folder / "link.png"
        link.symlink_to("flat.png")
        self.ovws("farfield", "-o", link)
        self.assertTrue(link.is_symlink() and not path.is_symlink())
        link.unlink()
        link.symlink_to("new.png")
        self.ovws("farfield", "-o", link)
        self.assertTrue(link.is_symlink() and (self.folder / "new.png").is_file())
        self.ovws("farfield", "-o", "/dev/null")

    def lenslets(self, modes, seed, px=272, across=9, turn_deg=0.0):
        """Pixels of a square array's image: each spot is that of its lenslet alone, where the slope at the lenslet's centre moves it."""
        pitch, spot, radius = 150 / 5.3, 632e-3 * 7e3 / 150 / 5.3, across * 150 / 5.3 / 2
        slope = 632e-3 * 7e3 / 5.3**2 / radius
        gradients = {3: lambda u, v: (6**0.5 * 2 * v, 6**0.5 * 2 * u), 4: lambda u, v: (3**0.5 * 4 * u, 3**0.5 * 4 * v),
                     8: lambda u, v: (8**0.5 * (9 * u * u + 3 * v * v - 2), 8**0.5 * 6 * u * v)}
        pixels = np.arange(px) - (px - 1) / 2
        light = np.full((px, px), 10.0)
        sine, cosine = math.sin(math.radians(turn_deg)), math.cos(math.radians(turn_deg))
        for b in pitch * (np.arange(across) - across // 2):
            for a in pitch * (np.arange(across) - across // 2):
                x, y = cosine * a - sine * b, sine * a + cosine * b
                moved = slope * sum((waves * np.array(gradients[j](x / radius, y / radius)) for j, waves in modes.items()), start=np.zeros(2))
                to_row, to_column = (np.sinc((pixels - at) / spot) ** 2 for at in (y + moved[1], x + moved[0]))
                light += 180 * np.outer(to_row, to_column)
        return np.clip(np.rint(light + np.random.default_rng(seed).normal(0.0, 1.0, light.shape)), 0, 255).astype(np.uint8)

    def test_an_array_may_be_seen_mirrored_and_turned_by_quarters(self):
        """Modes are those of the array, whichever way the camera sees it, and the same by positions and by all pixels."""
        wanted = {3: 0.02, 4: 0.03, 8: -0.02}
        flat, image = self.lenslets({}, 4), self.lenslets(wanted, 5)
        # xx, xy, yx, yy, and the image that such a camera takes.
        seen = {(1, 0, 0, 1): lambda p: p, (-1, 0, 0, 1): lambda p: p[:, ::-1], (1, 0, 0, -1): lambda p: p[::-1], (-1, 0, 0, -1): lambda p: p[::-1, ::-1],
                (0, 1, 1, 0): lambda p: p.T, (0, -1, -1, 0): lambda p: p[::-1, ::-1].T, (0, -1, 1, 0): lambda p: p[::-1].T, (0, 1, -1, 0): lambda p: p[:, ::-1].T}
        config = {"modulator": "fixed", "camera": {"roi": {"width": 272, "height": 272}}, "sensor": {"charge": 0, "grid": "square"},
                  "array": {"pupil_mm": 1.35}, "tracking": {"mode_count": 14}}
        optics, path = {"focal_length_mm": 7.0, "camera_pitch_um": 5.3}, self.folder / "array.json"
        worst = 0.0
        for direction, view in seen.items():
            path.write_text(json.dumps(config | {"optics": optics | {"px_per_cycle": [157.5 * one for one in direction]}}))
            files = [self.save(name, np.ascontiguousarray(view(pixels))) for name, pixels in (("flat.png", flat), ("image.png", image))]
            by = {}
            for tracker in ("lg", "fit"):
                (line,) = self.measure(files[1], reference=files[0], more=("--config", path, "--tracker", tracker))
                self.assertTrue(line["valid"], (direction, tracker, line))
                by[tracker] = dict(zip(line["j"], line["coefficients"]))
            for j, waves in wanted.items():
                self.assertAlmostEqual(by["fit"][j], waves, delta=0.001, msg=f"{direction}: j = {j}")
            differences = [abs(by["fit"][j] - by["lg"][j]) for j in by["fit"] if j > 2]
            worst = max(worst, *differences)
            self.assertLess(max(differences), 0.001, (direction, by))
        print(f"\n  eight directions: fit and lg differ by {worst:.5f} wave at most")
        path.write_text(json.dumps(config | {"optics": optics | {"px_per_cycle": [156.9, -13.7, 13.7, 156.9]}}))  # 5 degrees
        (line,) = self.ovws("measure", "--model-reference", "--config", path, files[1], status=1)
        self.assertIn("optics.px_per_cycle", json.dumps(line))

    def test_an_array_that_is_turned_in_the_image_is_refused(self):
        path = self.folder / "array.json"
        path.write_text(json.dumps({"modulator": "fixed", "camera": {"roi": {"width": 272, "height": 272}}, "sensor": {"charge": 0, "grid": "square"},
                                    "array": {"pupil_mm": 1.35}, "tracking": {"mode_count": 14},
                                    "optics": {"focal_length_mm": 7.0, "camera_pitch_um": 5.3}}))
        wanted = {3: 0.02, 4: 0.03, 8: -0.02}
        for turn_deg in (0.4, 0.8, 2.0, -5.0):
            files = [self.save(name, self.lenslets(modes, 6, turn_deg=turn_deg)) for name, modes in (("flat.png", {}), ("image.png", wanted))]
            for zero in (("--reference", files[0]), ("--model-reference",)):
                # The array that is not turned comes first: it must not speak for the next image.
                straight = [self.save("straight.png", self.lenslets(wanted, 7))] if len(zero) == 1 else []
                words = ("measure", *zero, "--config", path, "--tracker", "lg", *straight, files[1])
                *before, line = self.ovws(*words, status=0 if turn_deg == 0.4 else 1)
                for good in before + ([line] if turn_deg == 0.4 else []):
                    self.assertTrue(good["valid"], good)
                    modes = dict(zip(good["j"], good["coefficients"]))
                    self.assertLess(max(abs(modes[j] - waves) for j, waves in wanted.items()), 0.0015)
                if turn_deg != 0.4:
                    self.assertIn(f"turned by {turn_deg:.1f} degrees", json.dumps(line))

    def test_split_spots_are_measured(self):
        drawn = random.Random(2)
        waves = {j: drawn.gauss(0.0, 1.0) for j in range(3, 19)}
        scale = 0.5 / sum(v * v for v in waves.values()) ** 0.5
        osa = {(n * (n + 2) + m) // 2: (n, m) for n in range(6) for m in range(-n, n + 1, 2)}
        modes = ";".join(f"{osa[j][0]},{osa[j][1]}:{scale * v:.6f}" for j, v in waves.items())
        split = self.farfield("split.png", modes, 12, "--read-noise", 30)
        (line,) = self.measure(split)
        error = sum((value - scale * waves.get(j, 0.0)) ** 2 for j, value in zip(line["j"], line["coefficients"])) ** 0.5
        print(f"\n  split: {line['tracked']} of 19 found, error of all modes {error:.4f} wave")
        self.assertGreaterEqual(line["tracked"], 18)
        self.assertIsNotNone(line["sigma"][0])
        self.assertLess(error, 0.005)
        (line,) = self.ovws("measure", "--reference", split, self.farfield("flat.png"), status=1)
        self.assertIn("not found", json.dumps(line))

    def test_the_model_is_a_reference_too(self):
        (line,) = self.measure(self.farfield("defocus.png", "2,0:0.2"))
        self.assert_mode(line, {4: 0.2})

    def test_fit_reads_large_modes(self):
        """Without noise: the error of all modes, root sum square, waves."""
        modes, waves = {3: "2,-2", 4: "2,0", 7: "3,-1", 9: "3,3", 12: "4,0", 14: "4,4"}, 0.3
        images = [self.farfield(f"{j}.png", f"{mode}:{waves}", 12, "--noise-free", "--peak", 9000) for j, mode in modes.items()]
        flat = self.farfield("flat.png", "", 12, "--noise-free", "--peak", 9000)
        for line, j in zip(self.measure(*images, reference=flat, more=("--tracker", "fit")), modes):
            error = sum((value - (waves if k == j else 0.0)) ** 2 for k, value in zip(line["j"], line["coefficients"])) ** 0.5
            self.assertLess(error, 0.001)

    def test_a_saved_operator_of_the_daemon_becomes_slopes(self):
        image, config = self.farfield("image.png", "2,-2:0.05"), self.folder / "saved.json"
        config.write_text(json.dumps({"tracking": {"tracker": "lg", "operator": "measured"}}))
        (slopes,) = self.measure(image, more=("--tracker", "lg"))
        (line,) = self.measure(image, more=("--config", config))
        self.assertEqual((line["operator"], line["operator_in_force"], line["coefficients"]), ("measured", "slopes", slopes["coefficients"]))
        self.assertIn("running daemon", line["operator_reason"])
        done = subprocess.run([OVWS, "measure", "--model-reference", "--config", config, image, image], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertEqual((done.returncode, done.stderr), (0, "ovws: the operator is slopes, not measured: only a running daemon has the measured matrix\n"))

    def test_refined_it_is_right_to_a_few_thousandths(self):
        camera = ("--refine", "--electrons-per-dn", 10000 / 4095, "--black-level", 2, "--read-noise", 6)
        image = self.farfield("both.png", "2,-2:0.4;3,1:-0.3")
        (line,) = self.measure(image, more=camera)
        errors = [value - {3: 0.4, 8: -0.3}.get(j, 0.0) for j, value in zip(line["j"], line["coefficients"])]
        print(f"\n  refined: root sum square of all errors {np.sqrt(np.sum(np.square(errors))):.4f} wave, chi2 per pixel {line['refined']['chi2_per_pixel']:.2f}")
        self.assertLess(np.sqrt(np.sum(np.square(errors))), 0.001)
        self.assertAlmostEqual(line["refined"]["chi2_per_pixel"], 1.0, delta=0.2)

    def uneven(self, name, modes, amplitudes, scale=None):
        """Writes the default bench's image (hexagonal, 5 across) with an amplitude per subaperture; returns the scale in electrons."""
        hologram = self.folder / "hologram.png"
        self.ovws("hologram", "--modes", modes, "-o", hologram)
        grey = np.asarray(Image.open(hologram)).astype(float)
        x, y = (np.arange(n) - (n - 1) / 2 for n in reversed(grey.shape))
        pitch = 768 / 5
        centres = [((i - (n - 1) / 2) * pitch, row * pitch * np.sqrt(0.75)) for row, n in zip(range(-2, 3), (3, 4, 5, 4, 3)) for i in range(n)]
        nearest = np.argmin([(x[None, :] - cx) ** 2 + (y[:, None] - cy) ** 2 for cx, cy in centres], axis=0)
        field = np.asarray(amplitudes)[nearest] * np.exp(2j * np.pi * grey / 256)
        px_per_cycle = 632e-9 * 0.2 / (19e-6 * 3.45e-6)
        at = (np.arange(512) - 255.5) / px_per_cycle
        u, v = 200 / 1280 + at, 20 / 768 + at
        light = np.abs(np.exp(-2j * np.pi * np.outer(v, y)) @ field @ np.exp(-2j * np.pi * np.outer(x, u))) ** 2
        scale = scale or 3000 / light.max()
        rng = np.random.default_rng(len(modes))
        electrons = rng.poisson(scale * light) + rng.normal(0.0, 5.0, light.shape)
        return self.save(name, np.clip(np.round(electrons * 4095 / 10000 + 32), 0, 4095).astype(np.uint16)), scale

    def test_amplitudes_fitted_explain_uneven_light_and_better_the_modes(self):
        amplitudes = 1.0 + np.random.default_rng(4).uniform(-0.14, 0.14, 19)
        shown = {3: 0.3, 8: 0.2}
        flat, scale = self.uneven("flat.png", "", amplitudes)
        image, _ = self.uneven("both.png", "2,-2:0.3;3,1:0.2", amplitudes, scale)
        camera = ("--refine", "--electrons-per-dn", 10000 / 4095, "--black-level", 32, "--read-noise", 5.1)
        for reference in (None, flat):
            (line,) = self.measure(image, reference=reference, more=(*camera, "--spot-amplitudes"))
            self.assertTrue(line["valid"], line)
            error = np.sqrt(np.sum(np.square([value - shown.get(j, 0.0) for j, value in zip(line["j"], line["coefficients"])])))
            chi2 = line["refined"]["chi2_per_pixel"]
            print(f"\n  against {'a reference' if reference else 'the model'}: all errors {error:.5f} wave, chi2 per pixel {chi2:.3f}")
            self.assertLess(error, 0.001)
            self.assertLess(chi2, 1.3)
            found = np.asarray(line["refined"]["amplitudes"])
            self.assertLess(np.abs(found - amplitudes / np.sqrt(np.mean(amplitudes ** 2))).max(), 0.02)
        done = subprocess.run([OVWS, "measure", "--model-reference", "--spot-amplitudes", image], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(done.returncode, 2, done.stderr)

    def test_every_tracker_of_a_bright_spot(self):
        config = self.folder / "bright.json"
        config.write_text(json.dumps({"sensor": {"charge": 0}}))
        image = self.farfield("bright.png", "2,-2:0.2", 12, "--config", config)
        flat = self.farfield("flat.png", "", 12, "--config", config)
        for tracker in ("centroid", "thresholded", "weighted", "lg", "lg_contour", "fit"):
            with self.subTest(tracker):
                (line,) = self.measure(image, reference=flat, more=("--config", config, "--tracker", tracker))
                self.assertTrue(line["valid"])
                self.assertEqual(line["tracker"], tracker)
                self.assertAlmostEqual(line["coefficients"][2], 0.2, delta=0.03)

    def test_bad_images_are_lost_or_refused_and_never_measured(self):
        good = np.asarray(Image.open(self.farfield("good.png", "", 8)))
        rng = np.random.default_rng(1)
        stripe = good.copy()
        stripe[240:260] = 255
        bad = {"black": np.zeros_like(good), "white": np.full_like(good, 255), "noise": rng.integers(0, 255, good.shape, dtype=np.uint8),
               "tiny": np.zeros((1, 1), np.uint8), "narrow": good[:, :40].copy(), "stripe": stripe}
        for name, pixels in bad.items():
            with self.subTest(name):
                path = self.save(name + ".png", pixels)
                line, *why = self.ovws("measure", "--model-reference", path, status=None)
                self.assertEqual(["no spots" in str(one) and str(path) in str(one) for one in why], [True] * (line["tracked"] == 0))
                wrong = [s for s in line["spots"] if s["x"] is not None and self.off(line, s) > 6.0]
                print(f"\n  {name}: {line['tracked']} of 19, valid {line['valid']}")
                self.assertEqual(wrong, [])
                if name != "stripe":
                    self.assertFalse(line["valid"])
                    self.assertEqual(set(line["coefficients"]), {None})
                    self.assert_not_refined(path)

    def test_damage_of_a_tiff_is_said_and_nothing_of_it_is_measured(self):
        good, path = Image.open(self.farfield("good.png", "", 8)), self.folder / "damaged.tif"
        good.save(path, compression="tiff_lzw")
        data = bytearray(path.read_bytes())
        data[len(data) // 2:len(data) // 2 + 40] = b"\xff" * 40
        path.write_bytes(data)
        self.assertIn("is damaged: ", str(self.ovws("measure", "--model-reference", path, status=1)))
        good.save(path, save_all=True, append_images=[good] * 4)
        os.truncate(path, int(0.55 * path.stat().st_size))
        said = self.ovws("measure", "--model-reference", path, status=1)
        self.assertTrue(all(line.get("valid", True) for line in said), said)
        self.assertIn("is damaged: ", str(said[-1]))

    def assert_not_refined(self, path):
        done = subprocess.run([OVWS, "--json", "measure", "--model-reference", "--refine", path], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        for line in map(json.loads, done.stdout.splitlines()):
            self.assertFalse(line.get("valid", False), line)

    def off(self, line, spot):
        """Distance of a spot from its position in the good image, px."""
        if not hasattr(self, "truth"):
            self.truth = self.measure(self.folder / "good.png")[0]["spots"]
        there = self.truth[spot["i"]]
        return float(np.hypot(spot["x"] - there["x"], spot["y"] - there["y"]))

    def test_a_missing_spot_and_hot_cores_are_survived(self):
        path = self.farfield("good.png", "2,-2:0.2")
        pixels = np.asarray(Image.open(path)).astype(np.uint16)
        flat = self.farfield("flat.png", "")
        (whole,) = self.measure(path, reference=flat)
        (line,) = self.measure(self.without("without.png", pixels, whole["spots"][9:10]), reference=flat)
        self.assertIsNone(line["spots"][9]["x"])
        self.assert_mode(line, {3: 0.2})
        hot = pixels.copy()
        for s in whole["spots"]:
            hot[round(s["y"]), round(s["x"])] = 4095
        (line,) = self.measure(self.save("hot.png", hot), reference=flat)
        self.assertGreaterEqual(line["tracked"], 15)
        for before, after in zip(whole["spots"], line["spots"]):
            if after["x"] is not None:
                self.assertLess(np.hypot(after["x"] - before["x"], after["y"] - before["y"]), 1.5)

    def without(self, name, pixels, spots):
        """The image without these spots of its measured line."""
        pixels = pixels.copy()
        for spot in spots:
            x, y = round(spot["x"]), round(spot["y"])
            pixels[y - 25:y + 26, x - 25:x + 26] = 2
        return self.save(name, pixels)

    def test_missing_spots_are_the_reason_and_a_wrong_reference_is_named(self):
        flat = self.farfield("flat.png")
        pixels = np.asarray(Image.open(flat)).astype(np.uint16)
        (whole,) = self.measure(flat, reference=flat)
        few = self.without("few.png", pixels, whole["spots"][:5])
        config = self.folder / "five.json"
        config.write_text(json.dumps({"tracking": {"tracker": "lg", "mode_count": 5}}))
        by = (OVWS, "measure", "--config", config, "--reference")
        done = subprocess.run([*by, flat, few], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        print("\n" + done.stdout)
        self.assertIn("14 of 19 spots, NOT VALID", done.stdout)
        self.assertIn("5 of 19 spots are missing", done.stdout)
        self.assertNotIn("explains", done.stdout)
        done = subprocess.run([*by, few, flat], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        print(done.stderr)
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"reference: {few}, for {flat}: these spots are not found in the reference image: 0, 1, 2, 3, 4", done.stderr)

    def test_a_rotated_image_is_no_confident_wrong_number(self):
        pixels = np.asarray(Image.open(self.farfield("good.png", "2,-2:0.4", 8)))
        line, *_ = self.ovws("measure", "--model-reference", self.save("rotated.png", np.rot90(pixels).copy()), status=None)
        print(f"\n  rotated by 90 degrees: {line['tracked']} of 19, valid {line['valid']}, residual {line['fit_residual_px']}")
        self.assertFalse(line["valid"])

    def test_what_is_no_grey_picture_is_refused_and_the_others_are_measured(self):
        good = self.farfield("good.png")
        colour = self.save("colour.png", np.zeros((20, 20, 3), np.uint8))
        text = self.folder / "text.png"
        text.write_text("no picture")
        lines = self.ovws("measure", "--model-reference", colour, text, self.folder / "nowhere.png", good, status=1)
        self.assertEqual(sum("error" in line or "reason" in str(line) for line in lines[:3]), 3, lines[:3])
        for line, path in zip(lines, (colour, text, "nowhere.png")):
            self.assertIn(str(path), str(line))
        self.assertTrue(lines[3]["valid"])

    def test_a_reference_is_asked_for(self):
        self.ovws("measure", self.farfield("good.png"), status=2)


if __name__ == "__main__":
    unittest.main(verbosity=2)
