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
        """Positions alone lose spots that many modes split; fit does not."""
        for tracker, most_split in (("fit", 0.01), ("lg", 0.2), ("matched", 0.2)):
            for snr, most_refused, most_gross in ((2.0, 0.2, 0.01), (5.0, 0.01, 0.0), (22.0, 0.01, 0.0)):
                for random in (False, True):
                    with self.subTest(tracker=tracker, snr=snr, random=random):
                        refused, gross = self.shares(tracker, snr, random)
                        self.assertLessEqual(refused, max(most_refused, most_split if random else 0.0))
                        self.assertLessEqual(gross, most_gross)


if __name__ == "__main__":
    unittest.main(verbosity=2)
