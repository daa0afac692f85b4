"""A small client of ovwsd: calls over a DEALER socket, streams over a SUB socket. Needs only pyzmq."""
import itertools
import json
import os
import time

import zmq


class ClientError(Exception):
    """Nobody answered, or the daemon answered with an error (then `code` and `data` hold it)."""

    def __init__(self, text, code=None, data=None):
        super().__init__(text)
        self.code = code
        self.data = data or {}


def use_keys(socket, key=None, server_key=None):
    """Keys of a client for a daemon that asks for them: `key` is a file of `ovws keygen`, `server_key` the daemon's public key
    (default: "server_key" in that file). Without both: $OVWS_KEY and $OVWS_SERVER_KEY. Returns whether there are any."""
    key = key or os.environ.get("OVWS_KEY")
    if not key:
        return False
    with open(key, encoding="utf-8") as file:
        keys = json.load(file)
    server_key = server_key or os.environ.get("OVWS_SERVER_KEY") or keys.get("server_key")
    if not server_key:
        raise ClientError(f"the daemon's public key must be given: server_key=…, or \"server_key\" in {key}")
    socket.curve_publickey = keys["public_key"].encode()
    socket.curve_secretkey = keys["secret_key"].encode()
    socket.curve_serverkey = server_key.encode()
    return True


class Client:
    """Calls methods of one daemon; keys as of use_keys. Not for several threads at once."""

    def __init__(self, endpoint="tcp://127.0.0.1:7702", timeout_s=5.0, key=None, server_key=None):
        self.timeout_s = timeout_s
        self._ids = itertools.count(1)
        self._socket = zmq.Context.instance().socket(zmq.DEALER)
        self._socket.linger = 0
        self._hint = "is its key known there, and the server key its own?" if use_keys(self._socket, key, server_key) else "does it ask for a key?"
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
        raise ClientError(f"no answer within {self.timeout_s} s; does the daemon run, and {self._hint}")

    def close(self):
        self._socket.close()


class Stream:
    """Messages of some topics, as dicts; a binary part is under the key "binary". Keys as of use_keys."""

    def __init__(self, topics, endpoint="tcp://127.0.0.1:7701", key=None, server_key=None):
        self._socket = zmq.Context.instance().socket(zmq.SUB)
        self._socket.linger = 0
        self._socket.rcvhwm = 100000
        for topic in topics:
            self._socket.subscribe(topic)
        use_keys(self._socket, key, server_key)
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
