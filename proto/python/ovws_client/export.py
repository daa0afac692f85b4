"""Export of recordings to FITS and NumPy files; `ovws export` writes CSV and PNG files.

    python3 -m ovws_client.export run-1.h5 --npz run-1.npz --fits run-1.fits [--pictures]

FITS (needs astropy; Debian: python3-astropy) follows the Adaptive Optics Telemetry standard (AOT 1.0) as far as it applies: AOT_TIME,
AOT_DETECTORS and AOT_WAVEFRONT_SENSORS with the images that they refer to. The other mandatory tables exist without rows, because a
bench has no telescope, sky or stars. The modal coefficients and their standard errors, for which AOT has no place, are in extra images,
COEFFICIENTS and SIGMA. Each file states the meaning of its numbers: BASIS, ORIENT, WAVELEN and PIXBASE in FITS, and members of the
archive for NumPy.
"""
import argparse
import contextlib
import datetime
import io
import os
import unicodedata

import numpy

from .recording import Recording, RecordingError, reading

EMPTY_TABLES = ("AOT_ATMOSPHERIC_PARAMETERS", "AOT_ABERRATIONS", "AOT_TELESCOPES", "AOT_SCORING_CAMERAS", "AOT_WAVEFRONT_CORRECTORS", "AOT_LOOPS")


def good(run, waves):
    """Coefficients or standard errors, frames x modes; NaN in frames that are not valid."""
    waves = waves.copy()
    waves[run.frames["valid"] == 0] = numpy.nan
    return waves


@contextlib.contextmanager
def _output(path):
    """Context manager: a binary file that replaces `path` at the end. A failure leaves the old file, and raises OSError that names it. What is
    not a file, such as a pipe or a symbolic link, is written in place."""
    in_place = os.path.lexists(path) and (os.path.islink(path) or not os.path.isfile(path))
    part = path if in_place else f"{path}.part"
    try:
        with open(part, "wb") as out:
            yield out
        if not in_place:
            os.replace(part, path)
    except BaseException as error:
        if not in_place:
            with contextlib.suppress(OSError):
                os.remove(part)
        if isinstance(error, OSError):
            raise OSError(error.errno, f"{path} cannot be written: {error.strerror or error}") from error
        raise


def to_npz(run, path):
    """Writes the arrays `frames`, `spots`, `coefficients`, `sigma_waves` and `j`, and what they mean: `unit` and `basis` of coefficients and
    standard errors, `wavelength_nm`, `orientation` of image and pupil, and `first_pixel`, the coordinate of the first pixel's centre. Raises
    RecordingError if the recording is damaged, OSError if the file cannot be written."""
    with reading("recording"):
        attributes = run.attributes
        arrays = {"frames": run.frames, "spots": run.spots(), "coefficients": good(run, run.coefficients()),
                  "sigma_waves": good(run, run.sigma_waves()), "j": numpy.array(run.modes(0)), "unit": numpy.array("wave"), "first_pixel": numpy.array(0),
                  **{name: numpy.array(attributes[name]) for name in ("wavelength_nm", "basis", "orientation")}}
    packed = io.BytesIO()  # numpy leaves an archive open that it cannot write
    numpy.savez_compressed(packed, **arrays)
    with _output(path) as out:
        out.write(packed.getbuffer())


def _table(fits, name, columns):
    return fits.BinTableHDU.from_columns([fits.Column(name=key, format=form, unit=unit, array=value) for key, form, unit, value in columns], name=name)


def _ascii(text):
    """The text for FITS, which has ASCII only: letters without their accents, `?` for other characters."""
    plain = "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c))
    return plain.encode("ascii", "replace").decode()


def _rows(values):
    """Packs arrays of different lengths, one per row."""
    values = list(values)
    rows = numpy.empty(len(values), dtype=object)
    rows[:] = values
    return rows


def _time(ns):
    return datetime.datetime.fromtimestamp(ns * 1e-9, datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%S.%f")[:-3]


def _exposure_s(frames):
    """Exposure time in seconds; NaN if it is unknown or not the same in all frames."""
    known = numpy.unique(frames["exposure_us"][frames["settings_known"] != 0])
    return known[0] * 1e-6 if len(known) == 1 else numpy.nan


def _tables(fits, run, pictures):
    frames, attributes, plan = run.frames, run.attributes, run.plan(0)
    text = lambda value: numpy.array([value])
    shown = frames[frames["picture"] >= 0]
    times = {"frames": frames} | ({"pictures": shown} if pictures else {})
    yield _table(fits, "AOT_TIME", [
        ("UID", "16A", None, numpy.array(list(times))),
        ("TIMESTAMPS", "QD()", "s", _rows(rows["t_arrival_ns"] * 1e-9 for rows in times.values())),
        ("FRAME_NUMBERS", "QK()", "count", _rows(rows["frame_id"].astype(numpy.int64) for rows in times.values()))])
    for name in EMPTY_TABLES:
        yield _table(fits, name, [("UID", "16A", None, numpy.array([], dtype="U16"))])
    yield _table(fits, "AOT_SOURCES", [("UID", "16A", None, text("laser")), ("TYPE", "32A", None, text("Natural Guide Star"))])
    yield _table(fits, "AOT_DETECTORS", [
        ("UID", "16A", None, text("camera")),
        ("TYPE", "64A", None, text(_ascii(f"{attributes['camera_vendor']} {attributes['camera_model']}"))),
        ("PIXEL_INTENSITIES", "32A", None, text("INTREF<PICTURES>" if pictures else "")),
        ("INTEGRATION_TIME", "D", "s", numpy.array([_exposure_s(frames)])),
        ("FRAME_RATE", "D", "Hz", numpy.array([attributes["frame_rate_hz"]]))])
    yield _table(fits, "AOT_WAVEFRONT_SENSORS", [
        ("UID", "16A", None, text("sensor")),
        ("TYPE", "32A", None, text("Shack-Hartmann")),
        ("SOURCE_UID", "32A", None, text("ROWREF<laser>")),
        ("DIMENSIONS", "K", "count", numpy.array([2])),
        ("N_VALID_SUBAPERTURES", "K", "count", numpy.array([len(plan["predicted_px"])])),
        ("MEASUREMENTS", "32A", None, text("INTREF<SPOTS>")),
        ("REF_MEASUREMENTS", "32A", None, text("INTREF<REFERENCE>" if plan["reference_px"] else "")),
        ("SUBAPERTURE_INTENSITIES", "32A", None, text("INTREF<LEVELS>")),
        ("WAVELENGTH", "D", "m", numpy.array([attributes["wavelength_nm"] * 1e-9])),
        ("DETECTOR_UID", "32A", None, text("ROWREF<camera>"))])
    yield _table(fits, "AOT_WAVEFRONT_SENSORS_SHACK_HARTMANN", [
        ("UID", "16A", None, text("sensor")),
        ("CENTROIDING_ALGORITHM", "64A", None, text(f"{plan['tracker']}, vortices of charge {plan['charge']}"))])


def _images(fits, run, pictures):
    def image(name, data, unit, times="frames"):
        hdu = fits.ImageHDU(numpy.ascontiguousarray(data), name=name)
        hdu.header["BUNIT"] = unit
        hdu.header["ORIENT"] = (attributes["orientation"], "axes of image and pupil")
        if unit == "pix":
            hdu.header["PIXBASE"] = (0, "coordinate of the first pixel's centre")
        if times:
            hdu.header["TIME_UID"] = f"ROWREF<{times}>"
        return hdu

    spots, plan, attributes = run.spots(), run.plan(0), run.attributes
    yield image("SPOTS", numpy.stack([spots["x"], spots["y"]], axis=1), "pix")
    yield image("LEVELS", spots["level"], "count")
    if plan["reference_px"]:
        yield image("REFERENCE", numpy.array(plan["reference_px"]).T, "pix", times=None)
    for name, waves in (("COEFFICIENTS", run.coefficients()), ("SIGMA", run.sigma_waves())):
        modal = image(name, good(run, waves), "")
        modal.header["BASIS"] = (attributes["basis"], "in waves of WAVELEN, RMS-normalised")
        modal.header["WAVELEN"] = (attributes["wavelength_nm"] * 1e-9, "[m]")
        modal.header["MODES"] = " ".join(str(j) for j in run.modes(0))
        yield modal
    if pictures:
        yield image("PICTURES", numpy.stack([run.picture(frame) for frame in numpy.flatnonzero(run.frames["picture"] >= 0)]), "count", times="pictures")


def _check(run, pictures):
    used = set(run.frames["plan_id"].tolist())
    if missing := used - {plan["plan_id"] for plan in run.documents("plan")}:
        raise RecordingError(f"plan {min(missing)}: is not in the file")
    plans = [plan for plan in run.documents("plan") if plan["plan_id"] in used]
    stays = {
        "subapertures": lambda plan: len(plan["predicted_px"]), "charge": lambda plan: plan["charge"], "tracker": lambda plan: plan["tracker"],
        "reference": lambda plan: plan["reference_px"], "modes": run.modes_of}
    for what, of in stays.items():
        if any(of(plan) != of(plans[0]) for plan in plans):
            raise ValueError(f"{what}: changed during the recording, but AOT supports one constant sensor only")
    if pictures and not (run.frames["picture"] >= 0).any():
        raise ValueError("pictures: the recording has none")
    packed = run.attributes["pixel_format"].lower()
    if pictures and packed.endswith(("p", "packed")):
        raise ValueError(f"pictures: pixels of {run.attributes['pixel_format']} share bytes, which FITS does not support")


def to_fits(run, path, pictures=False):
    """Writes a FITS file. Raises ValueError if the sensor or its reference changed during the recording, which AOT cannot represent, or if
    images are requested and there are none, or only packed ones; RecordingError if the recording is damaged; OSError if the file cannot be
    written."""
    from astropy.io import fits
    with reading("recording"):
        _check(run, pictures)
        header = fits.Header()
        header["AOT-VERS"] = "1.0.0"
        header["AO-MODE"] = "SCAO"
        header["TIMESYS"] = "UTC"
        header["DATE-BEG"] = _time(int(run.frames["t_arrival_ns"][0]))
        header["DATE-END"] = _time(int(run.frames["t_arrival_ns"][-1]))
        header["SYS-NAME"] = _ascii(run.attributes["program"])
        header["CONFIG"] = "optical vortex wavefront sensor"
        hdus = fits.HDUList([fits.PrimaryHDU(header=header), *_tables(fits, run, pictures), *_images(fits, run, pictures)])
    with _output(path) as out:
        hdus.writeto(out)


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m ovws_client.export", description="Exports recordings to FITS and NumPy files.")
    parser.add_argument("recording")
    parser.add_argument("--npz", metavar="FILE", help="NumPy archive of arrays")
    parser.add_argument("--fits", metavar="FILE", help="FITS file in the Adaptive Optics Telemetry standard")
    parser.add_argument("--pictures", action="store_true", help="include the camera's images in the FITS file")
    options = parser.parse_args(arguments)
    if not (options.npz or options.fits):
        parser.error("give at least one of --npz and --fits")
    try:
        with Recording(options.recording) as run:
            if not len(run.frames):
                raise ValueError("holds no frames")
            if options.npz:
                to_npz(run, options.npz)
            if options.fits:
                to_fits(run, options.fits, options.pictures)
    except (ValueError, OSError) as error:
        parser.exit(1, f"{options.recording}: {getattr(error, 'strerror', None) or error}\n")


if __name__ == "__main__":
    main()
