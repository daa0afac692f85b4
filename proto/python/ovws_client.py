"""A small client of ovwsd: calls over a DEALER socket, streams over a SUB socket. Needs only pyzmq."""
import itertools
import json
import time

import zmq


class ClientError(Exception):
    """Nobody answered, or the daemon answered with an error (then `code` and `data` hold it)."""

    def __init__(self, text, code=None, data=None):
        super().__init__(text)
        self.code = code
        self.data = data or {}


class Client:
    """Calls methods of one daemon. Not for several threads at once."""

    def __init__(self, endpoint="tcp://127.0.0.1:7702", timeout_s=5.0):
        self.timeout_s = timeout_s
        self._ids = itertools.count(1)
        self._socket = zmq.Context.instance().socket(zmq.DEALER)
        self._socket.linger = 0
        self._socket.connect(endpoint)

    def call(self, method, params=None):
        """The method's result; raises ClientError with the daemon's own words."""
        request_id = next(self._ids)
        request = {"jsonrpc": "2.0", "id": request_id, "method": method, "params": params or {}}
        reply = self.exchange(json.dumps(request).encode(), lambda r: isinstance(r, dict) and r.get("id") == request_id)
        if "error" in reply:
            error = reply["error"]
            data = error.get("data") or {}
            raise ClientError(f"{method}: {error['message']}", error["code"], data)
        return reply["result"]

    def exchange(self, request, is_reply=lambda reply: True):
        """Sends bytes as they are and returns the first reply that `is_reply` accepts."""
        self._socket.send(request)
        end = time.monotonic() + self.timeout_s
        while self._socket.poll(max(0, int(1e3 * (end - time.monotonic())))):
            reply = json.loads(self._socket.recv_multipart()[-1])
            if is_reply(reply):
                return reply
        raise ClientError(f"no answer within {self.timeout_s} s")

    def close(self):
        self._socket.close()


class Stream:
    """Messages of some topics, as dicts; a binary part is under the key "binary"."""

    def __init__(self, topics, endpoint="tcp://127.0.0.1:7701"):
        self._socket = zmq.Context.instance().socket(zmq.SUB)
        self._socket.linger = 0
        self._socket.rcvhwm = 100000
        for topic in topics:
            self._socket.subscribe(topic)
        self._socket.connect(endpoint)

    def next(self, timeout_s=1.0):
        """The next message with its "topic", or None."""
        if not self._socket.poll(int(1e3 * timeout_s)):
            return None
        topic, text, *binary = self._socket.recv_multipart()
        message = json.loads(text)
        message["topic"] = topic.decode()
        if binary:
            message["binary"] = binary[0]
        return message

    def drain(self):
        """Throws away what has already arrived."""
        while self.next(0.0) is not None:
            pass

    def close(self):
        self._socket.close()
