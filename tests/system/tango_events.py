"""Subscribes to change events of a Tango device and prints each as JSON, with the time of its attribute and the time since the start of the
subscription, seconds: tango_events.py DEVICE ATTRIBUTE...

Then it prints "subscribed" on standard error, and collects until its standard input ends.

A process of its own: a client of PyTango 9.3 can crash after ten seconds if the device is in no database.
"""
import json
import os
import sys
import threading
import time

import tango


def main():
    device, *names = sys.argv[1:]
    proxy, lock, begin = tango.DeviceProxy(device), threading.Lock(), time.monotonic()

    def pushed(event):
        with lock:
            value = None if event.err else event.attr_value.value
            name = event.attr_name.split("/")[-1].split("#")[0]
            value = str(tango.DevState.values[value]) if name == "state" and value is not None else value.tolist() if hasattr(value, "tolist") else value
            quality = "ERROR" if event.err else str(event.attr_value.quality).removeprefix("ATTR_")
            stamp = None if event.err else event.attr_value.time.totime()
            print(json.dumps({"name": name, "value": value, "quality": quality, "time": stamp, "after_s": time.monotonic() - begin}), flush=True)

    for name in names:
        proxy.subscribe_event(name, tango.EventType.CHANGE_EVENT, pushed)
    print("subscribed", file=sys.stderr, flush=True)
    sys.stdin.read()
    os._exit(0)


if __name__ == "__main__":
    main()
