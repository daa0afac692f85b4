"""Accounts for every frame: it is published, or the daemon counts it as lost."""
import time
from itertools import pairwise

from case import wait_for

COUNTERS = ("frames_lost", "frames_incomplete", "frames_unplanned", "frames_unexpected", "frames_dropped")
LAST_NUMBER = 65535  # of the twin's frames, which are numbered from 1
MOST_REPORTED = 2048


class Account:
    """Compares the frames that the twin sends from now on with the messages about them. A busy machine may lose frames, but each of
    them must be in the `gap` of the next message and in the daemon's counters.

    `daemon`, `twin`: clients; `stream`: a subscription to `wavefront` for this object alone."""

    def __init__(self, daemon, twin, stream):
        self._daemon, self._twin, self._stream = daemon, twin, stream
        self._newest = None  # number of the newest frame in `sent`
        self.sent, self.messages = {}, []  # what the twin reports of each frame, by its time stamp; the messages
        self._counted_before = None
        wait_for(self._begin, what="a frame beside which none was lost")

    def counters(self):
        return self._daemon.call("system.status")["counters"]

    def counted(self):
        """Frames lost or dropped so far, by the daemon's counters."""
        counters = self.counters()
        return sum(counters[name] for name in COUNTERS)

    def _begin(self):
        """Takes the next message as the first one; returns it if the twin still remembers its frame, and the counters are the same before and
        after it."""
        self._ask()
        if self._newest is None:
            return None  # the twin has not sent a frame yet
        before = self.counted()
        self._stream.drain()
        first = self._stream.next(1.0)
        self.messages = [first] if first else []
        self._counted_before = before
        same = self.counted() == before
        self._ask()
        return first if first and same and first["t_device_ns"] in self.sent else None

    def _ask(self):
        """Takes what the twin reports of the frames since the last question: at most MOST_REPORTED at once."""
        while sent := self._twin.call("twin.get", {"sent_after": self._newest} if self._newest else {})["sent"]:
            self.sent.update((frame["t_ns"], frame) for frame in sent)
            self._newest = sent[-1]["frame_id"]
            if len(sent) < MOST_REPORTED:
                return

    def hear(self):
        """Takes the messages that have arrived. Call it at least once a minute: the twin remembers its last 16384 frames."""
        begun_ns = time.time_ns()
        while (message := self._stream.next(0.0)) is not None:
            self.messages.append(message)
            if message["t_device_ns"] > begun_ns:
                break  # on a busy machine they may come as fast as they are read
        self._ask()

    def lost(self):
        """Frames lost between the messages heard so far."""
        return sum(message["gap"] for message in self.messages[1:])

    def check(self, test):
        """Checks that every frame is published or counted."""
        def agree():
            self.hear()
            return self.lost() == self.counted() - self._counted_before
        wait_for(agree, what="a sum of `gap` that is what the counters have risen by")
        for before, message in pairwise(self.messages):
            test.assertEqual(message["seq"], before["seq"] + 1, "a message is missing")
            first, second = (self.sent[one["t_device_ns"]]["frame_id"] for one in (before, message))
            test.assertEqual((second - first) % LAST_NUMBER - 1, message["gap"], message)
        counters = self.counters()
        print(f"  {len(self.messages)} frames published, {self.lost()} lost, {counters['frames_late']} late")
