"""Wire format and keys, shared by the blocking and the asyncio client."""
from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import zmq

from .errors import ClientError, Refused
from .methods import WAITS_S
from .values import plain

CONTROL = "tcp://127.0.0.1:7702"
NUMBERS = "tcp://127.0.0.1:7701"
IMAGES = "tcp://127.0.0.1:7703"
MAX_DEPTH = 8  # of params that are looked into
KeyFile = str | os.PathLike[str]


def use_keys(socket: zmq.Socket[Any], key: KeyFile | None = None, server_key: str | None = None) -> bool:
    """Sets CURVE keys for a daemon that requires them. `key`: a file written by `ovws keygen` (default: $OVWS_KEY). `server_key`: the
    daemon's public key (default: $OVWS_SERVER_KEY, then "server_key" in that file). Returns whether keys were set."""
    key = key or os.environ.get("OVWS_KEY")
    if not key:
        return False
    try:
        keys = json.loads(Path(key).read_text(encoding="utf-8"))
        server_key = server_key or os.environ.get("OVWS_SERVER_KEY") or keys.get("server_key")
        if not server_key:
            raise ClientError(f"the daemon's public key must be given: server_key=…, or \"server_key\" in {key}")
        socket.curve_publickey = keys["public_key"].encode()
        socket.curve_secretkey = keys["secret_key"].encode()
        socket.curve_serverkey = server_key.encode()
    except (OSError, ValueError, LookupError, TypeError, AttributeError, zmq.ZMQError) as error:
        raise ClientError(f"key file {key}, or server_key: {type(error).__name__}: {error}; make a key file with `ovws keygen`") from error
    return True


def key_hint(with_keys: bool) -> str:
    """Hint for the message of a time-out."""
    return "are this client's key and the server key correct?" if with_keys else "does it require a key?"


def _plain(value: object) -> object:
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} cannot be encoded as JSON")


def _encoded(value: object) -> str:
    return json.dumps(value, default=_plain, allow_nan=False)


def _unsendable(name: str, value: object, depth: int = 0) -> str:
    """Name and text of the first value within `value` that JSON cannot represent; empty if there is none."""
    try:
        _encoded(value)
        return ""
    except (TypeError, ValueError):
        parts: Iterable[tuple[str, object]] = ()
        if isinstance(value, Mapping):
            parts = ((f"{name}.{key}".lstrip("."), each) for key, each in value.items())
        elif isinstance(value, (list, tuple)) or isinstance(value, np.ndarray) and value.ndim:
            parts = ((f"{name}[{k}]", each) for k, each in enumerate(value))
        found = (text for part in parts if depth < MAX_DEPTH and (text := _unsendable(*part, depth + 1)))
        return next(found, f"{name}: {plain(value)!r}")


def request_text(request_id: int, method: str, params: Mapping[str, object] | None) -> bytes:
    """Encodes a request, which may contain numpy numbers and arrays. Raises ValueError for NaN and infinity, which JSON cannot represent, and
    TypeError for other values; the text names the param."""
    try:
        return _encoded({"jsonrpc": "2.0", "id": request_id, "method": method, "params": params or {}}).encode()
    except (TypeError, ValueError) as error:
        kind = TypeError if isinstance(error, TypeError) else ValueError
        raise kind(f"{method}: {_unsendable('', params)} cannot be sent: {error}") from None


def daemon_waits_s(method: str, params: Mapping[str, object] | None) -> float:
    """How long the daemon may take by the request's own `timeout_s`, or the method's default, before it answers."""
    waits = plain(params.get("timeout_s")) if isinstance(params, Mapping) else None  # the daemon refuses other params
    return float(waits) if isinstance(waits, (int, float)) else WAITS_S.get(method, 0.0)


def reply_parts(frames: Sequence[bytes]) -> tuple[Any, bytes]:
    """The JSON of a reply, decoded, and its binary frame, which may be empty."""
    return json.loads(frames[0]), frames[1] if len(frames) > 1 else b""


def result_of(method: str, reply: Mapping[str, Any]) -> Any:
    """Result of a reply; raises Refused if the reply is an error."""
    if "error" in reply:
        raise Refused(method, reply["error"])
    return reply["result"]
