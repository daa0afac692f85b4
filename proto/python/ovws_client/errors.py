"""What can go wrong, as exceptions: every one is a ClientError."""
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

# As in WIRE.md: code -> (what it means, what to do).
CODES = {
    -32700: ("not JSON, or not UTF-8", "mend the text"),
    -32600: ("not a JSON-RPC request; too large, too deep, a key given twice, an empty or too large batch", "mend the request"),
    -32601: ("no such method", "see `nearest`, or `system.describe`"),
    -32602: ("a key or a value is wrong", "mend it; see `field`"),
    -32603: ("an error of the daemon itself", "report it"),
    -32000: ("refused in the present state, or too much waits or is unread", "change the state first; read replies, send smaller batches"),
    -32001: ("a device or resource is not there", "connect it, or wait"),
    -32002: ("a device failed, or answered wrongly", "look at the device"),
    -32003: ("this client may not: its role is `read`, and the method controls (`field` is `method`); or its key was withdrawn",
             "ask for the role, or a key, in the file of `security.clients`"),
}


class ClientError(Exception):
    """Anything that this package raises. `code` and `data` are those of the daemon's error, None and {} if there was none."""

    def __init__(self, text: str, code: int | None = None, data: Mapping[str, Any] | None = None) -> None:
        super().__init__(text)
        self.code = code
        self.data: dict[str, Any] = dict(data or {})


class NoAnswer(ClientError):
    """Nothing came in time: no reply, or no message of a stream."""


class NotUnderstood(ClientError):
    """A message of a form that this client does not know."""


class Refused(ClientError):
    """The daemon answered with an error; the text is its own."""

    def __init__(self, what: str, error: Mapping[str, Any]) -> None:
        super().__init__(f"{what}: {error['message']}", int(error["code"]), error.get("data"))

    @property
    def field(self) -> str:
        """Dotted path of the key at fault; may be empty."""
        return str(self.data.get("field", ""))

    @property
    def reason(self) -> str:
        """What is wrong, and what to do about this very case."""
        return str(self.data.get("reason", ""))

    @property
    def meaning(self) -> str:
        """What the code means."""
        return CODES[self.code][0] if self.code in CODES else f"error {self.code}"

    @property
    def what_to_do(self) -> str:
        """What to do about errors of this code."""
        return CODES[self.code][1] if self.code in CODES else "report it"

    @property
    def limits(self) -> tuple[float, float] | None:
        """(smallest, largest) that is allowed, in the unit of `field`, if a value was out of range."""
        return (self.data["min"], self.data["max"]) if "min" in self.data and "max" in self.data else None

    @property
    def nearest(self) -> str | None:
        """The known name nearest to an unknown one, if one is near."""
        return self.data.get("nearest")


class JobFailed(Refused):
    """A job ended otherwise than `done`: the error is its own; `state` is `failed` or `cancelled`."""

    def __init__(self, report: Mapping[str, Any]) -> None:
        reason = f"it was {report['state']}"
        super().__init__(f"job {report['job']} ({report['kind']})",
                         report["error"] or {"code": -32000, "message": reason, "data": {"field": "", "reason": reason}})
        self.state = str(report["state"])


class Lost(ClientError):
    """Before `message` something was lost, and the subscriber asked to be told by an exception. The next message can be taken as usual."""

    def __init__(self, message: Any, frames: int) -> None:
        super().__init__(f"before {message.topic} {message.seq} {message.lost_messages} messages were lost on the way here, "
                         f"and {frames} frames on the way to the daemon")
        self.message = message
        self.messages: int = message.lost_messages
        self.frames = frames
