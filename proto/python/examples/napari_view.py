"""Live camera image and wavefront in napari, for a number of images (napari_view.py 500); prints their size if napari is not installed."""
import sys
import time

import numpy as np

from ovws_client import Client, Image, Phase


class Layers:
    """The two newest pictures of a daemon, as layers of a viewer."""

    def __init__(self, viewer):
        self.viewer = viewer

    def show(self, message):
        """Shows an image or a wavefront; napari redraws a layer when its data are set."""
        name, data = ("camera, DN", message.pixels) if isinstance(message, Image) else ("wavefront, waves", message.waves)
        if name not in self.viewer.layers:
            scale = {} if isinstance(message, Image) else {"colormap": "twilight", "translate": (0, 1.1 * data.shape[1])}
            self.viewer.add_image(np.array(data), name=name, **scale)
        else:
            self.viewer.layers[name].data = np.array(data)
            self.viewer.layers[name].reset_contrast_limits()


class Printed(dict):
    """Stands in for a viewer where napari is not installed."""

    layers = property(lambda self: self)

    def add_image(self, data, name, **_):
        print(f"{name}: {data.shape[1]} x {data.shape[0]}")
        self[name] = type("Layer", (), {"data": data, "reset_contrast_limits": lambda self: None})()


def messages(count):
    """The newest images and wavefronts in turn, without those that the viewer was too slow for."""
    with Client() as client, client.subscribe(Image) as images, client.subscribe(Phase) as phases:
        for k in range(count):
            if (message := (images, phases)[k % 2].newest(timeout_s=5.0)) is None:
                return
            yield message
            time.sleep(0.02)


count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
try:
    import napari
    from napari.qt.threading import thread_worker
except ImportError:
    layers = Layers(Printed())
    for message in messages(count):
        layers.show(message)
else:
    layers = Layers(napari.Viewer(title="wavefront sensor"))
    thread_worker(messages, connect={"yielded": layers.show})(count)
    napari.run()
