"""Reader of the daemon's recordings as numpy arrays. Needs h5py (Debian: python3-h5py)."""
import contextlib
import hashlib
import json

import h5py
import numpy

SCHEMA = "ovws.recording/2"

FRAME_FIELDS = ("frame_id", "t_arrival_ns", "plan_id", "first_spot", "spots", "first_coefficient", "coefficients", "picture",
                "left_justified_bits", "valid", "settings_known")


class RecordingError(ValueError):
    """The file is damaged; the text names the part."""


@contextlib.contextmanager
def reading(what):
    """Context manager: exceptions of HDF5 and numpy caused by a damaged file become RecordingError."""
    try:
        yield
    except ValueError:
        raise
    except (LookupError, TypeError, AttributeError, OSError, RuntimeError, ArithmeticError, MemoryError) as error:
        raise RecordingError(f"{what}: damaged or missing ({type(error).__name__}: {error})") from error


def _is_being_written(path):
    """Whether the superblock (HDF5 File Format Specification, version 3) marks the file as open for writing."""
    with open(path, "rb") as file:
        head = file.read(12)
    return len(head) == 12 and bool(head[11] & 1)


class Recording:
    """A recording made by `record.start`; it may still be in progress, or cut off by a kill of the daemon. The view is that of the time of
    opening: to see newer data, open another Recording. Damaged parts raise RecordingError when they are opened or read.

        with Recording("run-1.h5") as run:
            good = run.frames["valid"] == 1
            print(run.modes(0), run.coefficients()[good].mean(axis=0))
    """

    def __init__(self, path):
        # SWMR mode for a file that is being written, or whose writer was killed: HDF5 refuses it otherwise. In that mode it reads damaged
        # metadata again and again, for hours.
        self.file = h5py.File(path, "r", libver="latest", swmr=_is_being_written(path))
        try:
            with reading("attributes"):
                if self.attributes.get("schema") != SCHEMA:
                    raise ValueError(f"{path}: not a recording of schema {SCHEMA}")
            #: One row per frame: `frame_id`, `t_arrival_ns`, `valid`, `picture`, …; RECORDING.md lists fields and units.
            self.frames = self._rows("frames")
            with reading("frames"):  # the file has 0 where the stream has null
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
        """Attributes of the file: `pixel_format`, `wavelength_nm`, `t_begin_ns`, …"""
        return {key: value.decode(errors="replace") if isinstance(value, bytes) else value for key, value in self.file.attrs.items()}

    @property
    def summary(self):
        """Totals of the recording: {"frames", "frames_dropped", "pictures", "pictures_dropped", "documents_dropped", "t_written_ns",
        "ended"}."""
        with reading("summary"):
            row = self.file["summary"][0]
            return {name: int(row[name]) for name in row.dtype.names}

    def picture(self, frame):
        """Camera image of a row of `frames`, or None if it has none. Packed formats are returned as bytes, row by row."""
        with reading(f"picture of frame {frame}"):
            number = int(self.frames["picture"][frame])
            return None if number < 0 else self.file["pictures"][number] >> int(self.frames["left_justified_bits"][frame])

    def spots(self, frame=None):
        """Spots of a frame, one row per subaperture: `x`, `y`, `peak`, `quality`, `level`, `noise`, `start_x`, `start_y`, `fresh`.
        Without `frame`: of all, frames x subapertures; ValueError if their number changed during the recording."""
        return self._parts("spots", "first_spot", "spots", frame)

    def coefficients(self, frame=None):
        """Coefficients in waves, in the order of `modes`: of a frame, or of all, frames x modes. NaN where they are not determined.
        Only those of frames with `valid` set can be trusted."""
        return self._parts("coefficients", "first_coefficient", "coefficients", frame)

    def sigma_waves(self, frame=None):
        """Standard errors of `coefficients`, waves. NaN where positions measured the frame."""
        return self._parts("sigma_waves", "first_coefficient", "coefficients", frame)

    def modes(self, frame):
        """OSA/ANSI indices of a frame's coefficients."""
        return self.modes_of(self.plan(frame))

    def modes_of(self, plan):
        """OSA/ANSI indices of the coefficients of frames of this plan."""
        return plan["modes_j"]

    def plan(self, frame):
        """Measurement plan of a frame: the settings that it was measured with."""
        with reading(f"plan of frame {frame}"):
            wanted = int(self.frames["plan_id"][frame])
            found = [plan for plan in self.documents("plan") if plan["plan_id"] == wanted]
        if not found:
            raise RecordingError(f"plan {wanted}: is not in the file")
        return found[-1]

    def documents(self, kind):
        """All documents of a kind, in order. Kinds: "configuration", "camera", "plan", "operator", "reference", "calibration", "slm"."""
        for row in self._rows("documents", "kind", "sha256", "first_byte", "bytes"):
            if row["kind"] == kind.encode():
                yield json.loads(self._text(row))

    def document(self, kind, sha256):
        """The document of a kind with this checksum, as plans refer to it."""
        for row in self._rows("documents", "kind", "sha256", "first_byte", "bytes"):
            if row["kind"] == kind.encode() and row["sha256"] == sha256.encode():
                return json.loads(self._text(row))
        raise RecordingError(f"{kind} {sha256}: is not in the file")

    def _text(self, row):
        with reading(f"document {row['sha256'].decode(errors='replace')}"):
            first = int(row["first_byte"])
            text = self.file["text"][first:first + int(row["bytes"])].tobytes()
            if hashlib.sha256(text).hexdigest() != row["sha256"].decode(errors="replace"):
                raise LookupError("its checksum differs")
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
                return self._cells(table, int(self.frames[first][frame]), int(self.frames[count][frame]))
            counts = numpy.unique(self.frames[count])
            if len(counts) > 1:
                raise ValueError(f"{table}: {counts[0]} to {counts[-1]} per frame; read them frame by frame")
            width = int(counts[0]) if len(counts) else 0
            if self.file[table].shape[1] < width:
                raise LookupError(f"its columns end at {self.file[table].shape[1]}, before {width}")
            return self._slice(table, 0, len(self.frames))[:, :width]

    def _cells(self, table, row, size):
        """The cells of a frame: columns of one row."""
        if not size <= self.file[table].shape[1]:
            raise LookupError(f"its columns end at {self.file[table].shape[1]}, before {size}")
        return self._slice(table, row, 1)[0, :size]

    def _slice(self, table, begin, size):
        if begin < 0 or begin + size > len(self.file[table]):
            raise LookupError(f"its rows end at {len(self.file[table])}, before {begin + size}")
        return self.file[table][begin:begin + size]
