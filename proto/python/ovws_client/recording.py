"""A recording of the daemon, as numpy arrays. Needs h5py (Debian: python3-h5py)."""
import contextlib
import hashlib
import json

import h5py
import numpy

SCHEMA = "ovws.recording/1"


FRAME_FIELDS = ("frame_id", "t_arrival_ns", "plan_id", "first_spot", "spots", "first_coefficient", "coefficients", "picture",
                "left_justified_bits", "valid", "settings_known")


class RecordingError(ValueError):
    """The file is damaged: the text says where."""


@contextlib.contextmanager
def reading(what):
    """Whatever a damaged file makes HDF5, numpy or a missing name raise becomes a RecordingError."""
    try:
        yield
    except ValueError:
        raise
    except (LookupError, TypeError, AttributeError, OSError, RuntimeError, ArithmeticError, MemoryError) as error:
        raise RecordingError(f"{what}: damaged or missing ({type(error).__name__}: {error})") from error


class Recording:
    """A file of `record.start`: while it is written, after its end, and after a kill of the daemon; to see what was added
    meanwhile, open another Recording. What is damaged is a RecordingError, here or where it is read.

        with Recording("run-1.h5") as run:
            good = run.frames["valid"] == 1
            print(run.modes(0), run.coefficients()[good].mean(axis=0))
    """

    def __init__(self, path):
        # The way of SWMR, or HDF5 refuses a file whose writer was killed.
        self.file = h5py.File(path, "r", libver="latest", swmr=True)
        try:
            with reading("attributes"):
                if self.attributes.get("schema") != SCHEMA:
                    raise ValueError(f"{path}: not a recording of schema {SCHEMA}")
            #: One row a frame: `frame_id`, `t_arrival_ns`, `valid`, `picture`, …; fields and units are in RECORDING.md.
            self.frames = self._rows("frames")
            with reading("frames"):  # where the stream has null, the file has 0
                valid, explained = self.frames["valid"] != 0, self.frames["explained"] != 0
                self.frames["rms_waves"][~valid] = numpy.nan
                self.frames["fit_residual_px"][~valid & explained] = numpy.nan
        except ValueError:
            self.close()
            raise

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
        with reading("summary"):
            row = self.file["summary"][0]
            return {name: int(row[name]) for name in row.dtype.names}

    def picture(self, frame):
        """The camera's picture of that row of `frames`, or None. Packed pixels come as their bytes, row by row."""
        with reading(f"picture of frame {frame}"):
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
        with reading(f"plan of frame {frame}"):
            wanted = int(self.frames["plan_id"][frame])
            found = [plan for plan in self.documents("plan") if plan["plan_id"] == wanted]
        if not found:
            raise RecordingError(f"plan {wanted}: is not in the file")
        return found[-1]

    def documents(self, kind):
        """All of a kind, in their order: "configuration", "camera", "plan", "operator", "reference", "calibration", "slm"."""
        for row in self._rows("documents", "kind", "sha256", "first_byte", "bytes"):
            if row["kind"] == kind.encode():
                yield json.loads(self._text(row))

    def document(self, kind, sha256):
        """The one that a plan names."""
        for row in self._rows("documents", "kind", "sha256", "first_byte", "bytes"):
            if row["kind"] == kind.encode() and row["sha256"] == sha256.encode():
                return json.loads(self._text(row))
        raise RecordingError(f"{kind} {sha256}: is not in the file")

    def _text(self, row):
        with reading(f"document {row['sha256'].decode(errors='replace')}"):
            first = int(row["first_byte"])
            text = self.file["text"][first:first + int(row["bytes"])].tobytes()
            if hashlib.sha256(text).hexdigest() != row["sha256"].decode(errors="replace"):
                raise LookupError("its checksum is another")
            return text

    def _rows(self, name, *fields):
        with reading(name):
            rows = self.file[name][:]
            for field in fields or FRAME_FIELDS:
                rows[field]
            return rows

    def _parts(self, table, first, count, frame):
        with reading(table):
            if frame is not None:
                begin, size = int(self.frames[first][frame]), int(self.frames[count][frame])
                return self._slice(table, begin, size)
            counts = numpy.unique(self.frames[count])
            if len(counts) > 1:
                raise ValueError(f"{table}: {counts[0]} to {counts[-1]} a frame; ask frame by frame")
            width = int(counts[0]) if len(counts) else 0
            return self._slice(table, 0, width * len(self.frames)).reshape(len(self.frames), width)

    def _slice(self, table, begin, size):
        if begin < 0 or begin + size > len(self.file[table]):
            raise LookupError(f"its rows end at {len(self.file[table])}, before {begin + size}")
        return self.file[table][begin:begin + size]
