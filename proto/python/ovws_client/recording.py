"""A recording of the daemon, as numpy arrays. Needs h5py (Debian: python3-h5py)."""
import json

import h5py
import numpy

SCHEMA = "ovws.recording/1"


class Recording:
    """A file of `record.start`: while it is written, after its end, and after a kill of the daemon; what is added
    meanwhile is seen by a Recording that is opened anew.

        with Recording("run-1.h5") as run:
            good = run.frames["valid"] == 1
            print(run.modes(0), run.coefficients()[good].mean(axis=0))
    """

    def __init__(self, path):
        # The way of SWMR, or HDF5 refuses a file whose writer was killed.
        self.file = h5py.File(path, "r", libver="latest", swmr=True)
        if self.attributes.get("schema") != SCHEMA:
            self.close()
            raise ValueError(f"{path}: not a recording of schema {SCHEMA}")
        #: One row a frame: `frame_id`, `t_arrival_ns`, `valid`, `picture`, …; fields and units are in RECORDING.md.
        self.frames = self.file["frames"][:]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self.file.close()

    @property
    def attributes(self):
        """Of the file: `pixel_format`, `wavelength_nm`, `t_begin_ns`, …"""
        return {key: value.decode(errors="replace") if isinstance(value, bytes) else value for key, value in self.file.attrs.items()}

    @property
    def summary(self):
        """{"frames", "frames_dropped", "pictures", "pictures_dropped", "t_written_ns", "ended"}"""
        row = self.file["summary"][0]
        return {name: int(row[name]) for name in row.dtype.names}

    def picture(self, frame):
        """The camera's picture of that row of `frames`, or None. Packed pixels come as their bytes, row by row."""
        number = int(self.frames["picture"][frame])
        return None if number < 0 else self.file["pictures"][number] >> int(self.frames["left_justified_bits"][frame])

    def spots(self, frame=None):
        """Of that frame, one row a subaperture: `x`, `y`, `peak`, `quality`, `level`, `noise`, `start_x`, `start_y`, `fresh`.
        Of all, frames x subapertures; a ValueError if their number changed meanwhile."""
        return self._parts("spots", "first_spot", "spots", frame)

    def coefficients(self, frame=None):
        """Waves, in the order of `modes`: of that frame, or of all, frames x modes. NaN where they are not determined;
        good are those of frames that are `valid`."""
        return self._parts("coefficients", "first_coefficient", "coefficients", frame)

    def modes(self, frame):
        """OSA/ANSI indices of that frame's coefficients."""
        return self.document("operator", self.plan(frame)["operator"])["j"]

    def plan(self, frame):
        """What that frame was measured with."""
        wanted = int(self.frames["plan_id"][frame])
        return next(plan for plan in reversed(list(self.documents("plan"))) if plan["plan_id"] == wanted)

    def documents(self, kind):
        """All of a kind, in their order: "configuration", "camera", "plan", "operator", "reference", "calibration", "slm"."""
        for row in self.file["documents"][:]:
            if row["kind"] == kind.encode():
                yield json.loads(self._text(row))

    def document(self, kind, sha256):
        """The one that a plan names."""
        for row in self.file["documents"][:]:
            if row["kind"] == kind.encode() and row["sha256"] == sha256.encode():
                return json.loads(self._text(row))
        raise KeyError(f"{kind} {sha256}")

    def _text(self, row):
        first = int(row["first_byte"])
        return self.file["text"][first:first + int(row["bytes"])].tobytes()

    def _parts(self, table, first, count, frame):
        if frame is not None:
            begin = int(self.frames[first][frame])
            return self.file[table][begin:begin + int(self.frames[count][frame])]
        counts = numpy.unique(self.frames[count])
        if len(counts) > 1:
            raise ValueError(f"{table}: {counts[0]} to {counts[-1]} a frame; ask frame by frame")
        width = int(counts[0]) if len(counts) else 0
        return self.file[table][:width * len(self.frames)].reshape(len(self.frames), width)
