"""The disk of the state directory is read-only or lost parts of files: reported with a remedy, and all else works."""
import json
import random
import subprocess

from case import PATIENCE_S, PROGRAM_PATIENCE_S, main
from disk_case import RUNS, DiskCase

CUTS = 12


class Disk(DiskCase):
    def test_a_second_daemon_does_not_share_the_folder(self):
        before = self.files()
        second = subprocess.run([self.bench.programs / "ovwsd", "--config", "ovwsd.json"], cwd=self.bench.directory,
                                capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(second.returncode, 1, second.stderr)
        self.assertIn("another daemon uses", second.stdout + second.stderr)
        self.assertEqual(self.files(), before)
        self.assertEqual(self.restart().count("another daemon uses"), 0)

    def test_read_only(self):
        def remount(how):
            subprocess.run(["mount", "-o", f"remount,{how}", self.state], check=True)

        before = self.check(lambda: remount("ro"), lambda: remount("rw"), r"\S*/state/.*: Read-only file system: .*mount it for writing", sets_aside=False)
        self.assertTrue(before["reference.get"]["taken"])
        remount("ro")
        for method in ("reference.clear", "calibration.clear", "lut.clear", "registration.clear"):
            known = self.known()
            self.assertIn("mount it for writing", self.refused(method).data["reason"])
            self.assertEqual(self.known(), known)

    def test_files_that_are_cut_off(self):
        random.seed(5)
        for method, params, _ in RUNS:
            self.run_job(method, params)
        names = sorted(self.files())
        self.assertEqual(len(names), 4, names)
        for cut in range(CUTS):
            path = self.state / names[cut % len(names)]
            whole = path.read_bytes()
            left = whole[:random.randrange(len(whole))]
            with self.subTest(file=path.name, bytes=len(left), of=len(whole)):
                path.write_bytes(left)
                log = self.restart()
                self.assertIn(f"{path.name} is not used, and left as it is: it is ", log)
                self.assertEqual(log.count("is not used, and left as it is"), 1, log)
                self.assertEqual(path.read_bytes(), left)
                self.assertIsNotNone(self.stream("wavefront").next(PATIENCE_S))
            path.write_bytes(whole)
        print(f"\n  {CUTS} files cut off: {json.dumps(names)}")


if __name__ == "__main__":
    main()
