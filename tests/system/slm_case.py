"""A bench whose SLM the daemon measures, compared with the twin's truth."""
from case import BenchCase


class SlmCase(BenchCase):
    daemon_config = {"stream": {"image_rate_hz": 0}}

    def start_daemon(self):
        if "state" not in self.daemon_config:
            self.daemon_config = self.daemon_config | {"state": {"directory": str(self.bench.directory / "state")}}
        super().start_daemon()

    def judge(self, pattern="sensor"):
        return self.twin.call("twin.get", {"judge": pattern})

    def restart(self):
        self.bench.stop("ovwsd")
        self.start_daemon()
        self.wait_until("running")
