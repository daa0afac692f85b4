"""Stands in for the part of p4p that ovws_bridges.epics uses, where p4p cannot be had: PVs that keep what is posted. There is no network."""
import sys
import types

import numpy as np


class Typed:
    """A normative type: checks values as p4p does when it packs them."""

    def __init__(self, code="d", display=False, control=False):
        self.code = code

    def check(self, value):
        """Raises an exception for a value that p4p cannot pack."""
        if self.code[0] == "a":
            np.asarray(value, {"d": float, "l": np.int64}[self.code[1]])
        else:
            {"d": float, "l": int, "?": bool}[self.code](value)


class NDArray(Typed):
    """An image."""

    def check(self, value):
        assert np.asarray(value).ndim == 2 and np.asarray(value).dtype.char in "BHfd", np.asarray(value).dtype


class SharedPV:
    """A PV that keeps its value and its alarm."""

    def __init__(self, nt, initial, handler=None):
        self.nt, self.handler, self.stamp = nt, handler, None
        self.value = initial["value"] if isinstance(initial, dict) else initial
        alarm = initial["alarm"] if isinstance(initial, dict) else {"severity": 0, "message": ""}
        self.severity, self.message = alarm["severity"], alarm["message"]
        nt.check(self.value)

    def current(self):
        """The value."""
        return self.value

    def post(self, value, timestamp=None, severity=None, message=None):
        """Keeps a value, or of a dict its alarm alone."""
        if isinstance(value, dict):
            severity, message = value["alarm"]["severity"], value["alarm"]["message"]
        else:
            self.nt.check(value)
            self.value = value
        self.stamp = timestamp or self.stamp
        self.message = self.message if message is None else message
        self.severity = self.severity if severity is None else severity  # last: tests wait for it


class Operation:
    """A client's put."""

    def __init__(self, value):
        self._value, self.error, self.ended = value, None, False

    def value(self):
        """What p4p unpacks: the value is in `raw.value`."""
        return types.SimpleNamespace(raw=types.SimpleNamespace(value=self._value))

    def done(self, error=None):
        """Ends it."""
        self.error, self.ended = error, True


def install():
    """Makes `import p4p` find the stand-in."""
    modules = {name: types.ModuleType(name) for name in ("p4p", "p4p.nt", "p4p.server", "p4p.server.thread")}
    modules["p4p.nt"].NTScalar, modules["p4p.nt"].NTNDArray = Typed, NDArray
    modules["p4p.server"].Server = None
    modules["p4p.server.thread"].SharedPV = SharedPV
    sys.modules |= modules
