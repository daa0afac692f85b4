"""The disk of the state directory fills up: reported with a remedy, and all else works."""
import contextlib

from case import main
from disk_case import DiskCase


class DiskFull(DiskCase):
    def test_full(self):
        filler = self.state / "filler"

        def fill():
            with open(filler, "wb", buffering=0) as file, contextlib.suppress(OSError):
                while True:
                    file.write(bytes(4096))

        self.check(fill, filler.unlink, r"\S*/state/.*: No space left on device: free some space there", sets_aside=True)


if __name__ == "__main__":
    main()
