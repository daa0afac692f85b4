"""Exceptions of the client; all are derived from ClientError."""
from __future__ import annotations

import copyreg
from collections.abc import Mapping
from typing import Any

REFUSED, UNAVAILABLE = -32000, -32001

# Error codes as in WIRE.md: code -> (meaning, what to do).
CODES = {
    -32700: ("not JSON, or not UTF-8", "fix the text"),
    -32600: ("not a JSON-RPC request; too large, too deep, a key given twice, an empty or too large batch", "fix the request"),
    -32601: ("no such method", "see `nearest`, or `system.describe`"),
    -32602: ("a key or a value is wrong", "fix it; see `field`"),
    -32603: ("internal error of the daemon", "report it"),
    REFUSED: ("refused in the current state, or too many requests are waiting or replies unread",
              "change the state first; read replies, send smaller batches"),
    UNAVAILABLE: ("a device or resource is not available", "connect it, or wait"),
    -32002: ("a device failed, or gave a wrong answer", "check the device"),
    -32003: ("not permitted: the client's role is `read` and the method needs `control` (`field` is `method`), or its key was withdrawn",
             "have the role, or the key, entered in the file of `security.clients`"),
}


class ClientError(Exception):
    """Base of all exceptions of this package. `code` and `data` are those of the daemon's error, or None and {} without one."""

    def __init__(self, text: str, code: int | None = None, data: Mapping[str, Any] | None = None) -> None:
        super().__init__(text)
        self.code = code
        self.data: dict[str, Any] = dict(data or {})

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles text and attributes: subclasses have other parameters than the text, so they cannot be made from it."""
        return copyreg.__newobj__, (type(self), *self.args), self.__dict__


class NoAnswer(ClientError):
    """Time-out: no reply, or no message of a stream."""


class NotUnderstood(ClientError):
    """A message with a schema that this client does not know."""


class Refused(ClientError):
    """The daemon answered with an error; the text is the daemon's."""

    def __init__(self, what: str, error: Mapping[str, Any]) -> None:
        super().__init__(f"{what}: {error['message']}", int(error["code"]), error.get("data"))

    @property
    def field(self) -> str:
        """Dotted path of the invalid key; may be empty."""
        return str(self.data.get("field", ""))

    @property
    def reason(self) -> str:
        """What is wrong in this case, and what to do."""
        return str(self.data.get("reason", ""))

    @property
    def meaning(self) -> str:
        """Meaning of the error code."""
        return CODES[self.code][0] if self.code in CODES else f"error {self.code}"

    @property
    def what_to_do(self) -> str:
        """General remedy for errors of this code."""
        return CODES[self.code][1] if self.code in CODES else "report it"

    @property
    def limits(self) -> tuple[float, float] | None:
        """Allowed (minimum, maximum) in the unit of `field`, if a value was out of range."""
        return (self.data["min"], self.data["max"]) if "min" in self.data and "max" in self.data else None

    @property
    def nearest(self) -> str | None:
        """Suggestion for an unknown name: the nearest known one, if there is one."""
        return self.data.get("nearest")


class JobFailed(Refused):
    """A job failed or was cancelled: `state` is `failed` or `cancelled`, and the error is the job's."""

    def __init__(self, report: Mapping[str, Any]) -> None:
        reason = f"it was {report['state']}"
        super().__init__(f"job {report['job']} ({report['kind']})",
                         report["error"] or {"code": -32000, "message": reason, "data": {"field": "", "reason": reason}})
        self.state = str(report["state"])


class Lost(ClientError):
    """Messages or frames were lost before `message`, in a subscription with on_loss="raise". Iterating may continue."""

    def __init__(self, message: Any, frames: int) -> None:
        super().__init__(f"before {message.topic} {message.seq}, {message.lost_messages} messages were lost on the way to this program "
                         f"and {frames} frames on the way to the daemon")
        self.message = message
        self.messages: int = message.lost_messages
        self.frames = frames
