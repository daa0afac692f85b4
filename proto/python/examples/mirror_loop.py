"""A closed loop with a deformable mirror: calibrates its actuators, then removes an aberration. The mirror is that of a twin whose
configuration has "mirror"; for a real one, replace `drive`.

    mirror_loop.py [SECONDS]
"""
import sys

from ovws_client import Client, MirrorLoop, calibrate_mirror, set_matrix

twin = Client("tcp://127.0.0.1:7790")


def drive(actuators):
    """Moves the mirror; returns when it has taken the commands."""
    twin.call("twin.mirror", {"waves": actuators.tolist()})


shown = twin.call("twin.get")["mirror"]
if shown is None:
    raise SystemExit("this twin has no mirror: start it with {\"mirror\": {\"actuators_across\": 9}}, or replace `drive` by your mirror's library")
with Client() as client:
    mirror = calibrate_mirror(client, drive, shown["actuators"], amplitude=0.3, frames=3)
    number = set_matrix(client, mirror.command_matrix())["matrix"]
    loop = MirrorLoop(drive, shown["actuators"], gain=0.4, leak=0.001, limit=2.0, matrix=number)
    twin.call("twin.set", {"aberration": [{"j": 3, "waves": 0.1}, {"j": 7, "waves": -0.05}]})
    print(f"open loop: {client.wavefront(20).rms_waves:.4f} waves RMS")
    loop.run(client, seconds=float(sys.argv[1]) if len(sys.argv) > 1 else 3.0)
    print(f"closed loop, {loop.steps} steps: {client.wavefront(20).rms_waves:.4f} waves RMS")
    client.corrector_clear()
