"""A job of the daemon: the result of methods that return at once."""
from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from typing import Any, Protocol

from .errors import JobFailed, NoAnswer
from .values import number


class JobClient(Protocol):
    """What a job needs of a client."""

    def job_get(self, job: int) -> Any:
        """State of a job."""

    def job_cancel(self, job: int) -> Any:
        """Cancels a job."""


class Job(dict[str, int]):
    """A job, {"job": number}, and its client. `wait` returns its result:

        client.reference_take(frames=100).wait(progress=True)
    """

    def __init__(self, client: JobClient, result: Mapping[str, int]) -> None:
        super().__init__(result)
        self._client = client

    def report(self) -> dict[str, Any]:
        """State and progress, as `job.get`."""
        report: dict[str, Any] = self._client.job_get(self["job"])
        return report

    def cancel(self) -> dict[str, Any]:
        """Cancels the job, as `job.cancel`."""
        report: dict[str, Any] = self._client.job_cancel(self["job"])
        return report

    def wait(self, timeout_s: float = 600.0, progress: bool = False) -> Any:
        """Waits for the end of the job and returns its result. Raises JobFailed if it failed or was cancelled, NoAnswer if it has not ended
        within `timeout_s` seconds (the job continues; `cancel` ends it). A lost answer is asked for again until then. With `progress`, shows progress and time left on standard error."""
        timeout_s = number("timeout_s", timeout_s, 0.0)
        begun = time.monotonic()
        line = ProgressLine() if progress else None
        try:
            while (report := self._report_until(begun + timeout_s))["state"] == "running":
                if line is not None:
                    line.show(report)
                if time.monotonic() > begun + timeout_s:
                    raise NoAnswer(f"job {self['job']} ({report['kind']}) has not ended within {timeout_s} s")
                time.sleep(0.05)
            if line is not None:
                line.show(report)
        finally:
            if line is not None:
                line.end()
        if report["state"] != "done":
            raise JobFailed(report)
        return report["result"]

    def _report_until(self, end: float) -> dict[str, Any]:
        """The report, asked for until there is an answer; raises NoAnswer after `end`, by the monotonic clock."""
        while True:
            try:
                return self.report()
            except NoAnswer:
                if time.monotonic() > end:
                    raise
                time.sleep(0.05)


class ProgressLine:
    """One line on standard error that is written again whenever it changes: a bar, the progress in percent, and the time left."""

    WIDTH = 30

    def __init__(self) -> None:
        self._begun = time.monotonic()
        self._shown = ""

    def show(self, report: Mapping[str, Any]) -> None:
        """Shows the progress of a job."""
        done = float(report["progress"])
        full = round(self.WIDTH * done)
        seconds = time.monotonic() - self._begun
        if report["state"] != "running":
            rest = f"{report['state']} after {seconds:.0f} s"
        else:
            rest = f"{seconds * (1.0 - done) / done:.0f} s left" if done > 0.02 else ""
        text = f"{report['kind']} [{'#' * full}{'.' * (self.WIDTH - full)}] {100.0 * done:3.0f} % {rest}"
        if text != self._shown:
            sys.stderr.write("\r" + text.ljust(len(self._shown)))
            sys.stderr.flush()
            self._shown = text

    def end(self) -> None:
        """Ends the line."""
        sys.stderr.write("\n")
        sys.stderr.flush()
