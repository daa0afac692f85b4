"""A closed loop with a deformable mirror: calibrates its actuators, then removes an aberration. The mirror is simulated on the twin, 69
actuators with Gaussian influence; for a real one, replace `drive`.

    mirror_loop.py [SECONDS]
"""
import sys

import numpy as np

from ovws_client import Client, MirrorLoop, calibrate_mirror, set_matrix, zernike

MODES_J, PITCH, COUPLING = range(1, 15), 0.25, 0.15  # the actuators' distance, pupil radii; the influence on the next one


def influence_waves():
    """The modes j of each actuator at 1, RMS-normalised waves: projections of its influence on the pupil."""
    at = PITCH * np.mgrid[-4:5, -4:5].reshape(2, -1)
    at = at[:, np.argsort(np.hypot(*at), kind="stable")[:69]]
    y, x = np.mgrid[-1:1:101j, -1:1:101j]
    inside = np.hypot(x, y) < 1.0
    shapes = COUPLING ** (((x[inside] - at[0][:, None]) ** 2 + (y[inside] - at[1][:, None]) ** 2) / PITCH**2)
    modes = np.array([zernike(j, x[inside], y[inside]) for j in MODES_J])
    return modes @ shapes.T / inside.sum()


INFLUENCE = influence_waves()
TWIN, HIDDEN = Client("tcp://127.0.0.1:7790"), np.zeros(len(MODES_J))


def drive(actuators):
    """Moves the simulated mirror: the twin shows the hidden aberration and what the mirror adds."""
    waves = HIDDEN + INFLUENCE @ actuators
    TWIN.call("twin.set", {"aberration": [{"j": j, "waves": wave} for j, wave in zip(MODES_J, waves.tolist())]})


with Client() as client:
    mirror = calibrate_mirror(client, drive, actuators=69, amplitude=1.0, frames=3)
    number = set_matrix(client, mirror.command_matrix())["matrix"]
    HIDDEN[2], HIDDEN[6] = 0.1, -0.05  # waves of oblique astigmatism (j = 3) and vertical coma (j = 7)
    loop = MirrorLoop(drive, actuators=69, gain=0.4, leak=0.001, limit=10.0, matrix=number)
    drive(loop.position)
    print(f"open loop: {client.wavefront(20).rms_waves:.4f} waves RMS")
    loop.run(client, seconds=float(sys.argv[1]) if len(sys.argv) > 1 else 3.0)
    print(f"closed loop, {loop.steps} steps: {client.wavefront(20).rms_waves:.4f} waves RMS")
    client.corrector_clear()
