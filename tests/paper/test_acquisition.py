"""Acquisition study: every spot is found in one noisy image without history."""
import unittest

import case


class Acquisition(case.StudyCase):
    study = "acquisition"
    figures = ("acquisition",)

    def shares(self, tracker, snr, random):
        rows = [row for row in self.rows(tracker=tracker, snr=snr) if row["scene"].startswith("random") == random]
        spots = sum(row["spots"] for row in rows)
        refused, gross = (sum(row[key] for row in rows) / spots for key in ("refused", "gross"))
        what = "0.5 wave RMS random" if random else "2 waves of astigmatism or defocus"
        print(f"\n  {tracker}, SNR {snr:.0f}, {what}: {spots} spots, {refused:.2%} refused, {gross:.2%} wrong")
        return refused, gross

    def test_spots_are_found_and_not_guessed(self):
        for tracker in ("fit", "lg"):
            for snr, most_refused, most_gross in ((2.0, 0.2, 0.01), (5.0, 0.01, 0.0), (22.0, 0.01, 0.0)):
                with self.subTest(tracker=tracker, snr=snr):
                    refused, gross = self.shares(tracker, snr, random=False)
                    self.assertLessEqual(refused, most_refused)
                    self.assertLessEqual(gross, most_gross)

    def test_fit_finds_the_spots_that_many_modes_split(self):
        """Trackers of positions lose or mistake some of them."""
        for snr in (2.0, 5.0, 22.0):
            with self.subTest(snr=snr):
                refused, gross = self.shares("fit", snr, random=True)
                self.assertLessEqual(refused, 0.01)
                self.assertEqual(gross, 0.0)
                self.assertGreater(self.shares("lg", snr, random=True)[0], refused)


if __name__ == "__main__":
    unittest.main(verbosity=2)
