"""HTML for notebooks: images, wavefront maps and tables of modes. No library is needed; text is escaped."""
from __future__ import annotations

import base64
import html
import struct
import zlib
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Colours from blue (low) over white (zero) to red (high), for signed values.
_LOW, _ZERO, _HIGH = np.array([33, 102, 172]), np.array([247, 247, 247]), np.array([178, 24, 43])
_CELL = 'style="text-align:right;padding:0 8px"'


def png(pixels: NDArray[np.uint8]) -> bytes:
    """Encodes grey levels (rows, columns) or colours (rows, columns, 3) as PNG."""
    rows, columns = pixels.shape[:2]
    colour_type = 0 if pixels.ndim == 2 else 2
    raw = np.zeros((rows, 1 + pixels[0].size), np.uint8)  # each row begins with its filter type, 0
    raw[:, 1:] = pixels.reshape(rows, -1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", columns, rows, 8, colour_type, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw.tobytes(), 6)) + chunk(b"IEND", b"")


def img(pixels: NDArray[np.uint8], caption: str) -> str:
    """An image with its caption."""
    data = base64.b64encode(png(pixels)).decode()
    return f'<figure><img alt="{html.escape(caption)}" src="data:image/png;base64,{data}"/><figcaption>{html.escape(caption)}</figcaption></figure>'


def grey(pixels: NDArray[Any], significant_bits: int) -> NDArray[np.uint8]:
    """Camera pixels as eight bits of grey; full scale is white."""
    return (pixels >> max(0, significant_bits - 8)).astype(np.uint8)


def signed(values: NDArray[Any], scale: float) -> NDArray[np.uint8]:
    """Colours of values from -scale to scale; NaN is white."""
    part = np.nan_to_num(np.clip(values / scale if scale > 0.0 else values * 0.0, -1.0, 1.0))[..., None]
    colours = np.where(part < 0.0, _ZERO + part * (_ZERO - _LOW), _ZERO + part * (_HIGH - _ZERO))
    colours[np.isnan(values)] = 255
    return colours.astype(np.uint8)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of texts."""
    lines = ["".join(f"<th {_CELL}>{html.escape(text)}</th>" for text in head)]
    lines += ["".join(f"<td {_CELL}>{html.escape(text)}</td>" for text in row) for row in rows]
    return "<table>" + "".join(f"<tr>{line}</tr>" for line in lines) + "</table>"


def wavefront(title: str, names: Sequence[str], coefficients_waves: NDArray[Any], error_waves: NDArray[Any], phase_waves: NDArray[Any]) -> str:
    """A wavefront: its map over the pupil, and a table of its modes with their standard errors."""
    def text(value: float, form: str) -> str:
        return "" if np.isnan(value) else format(value, form)

    rows = [(name, text(waves, "+.4f"), text(error, ".4f")) for name, waves, error in zip(names, coefficients_waves, error_waves)]
    parts = [f"<p>{html.escape(title)}</p>"]
    known = phase_waves[np.isfinite(phase_waves)]
    if known.size:
        scale = float(np.abs(known).max())
        parts.append(img(signed(phase_waves, scale), f"wavefront, -{scale:.3f} (blue) to +{scale:.3f} waves (red), x right, y down"))
    return "".join(parts) + table(("mode", "waves", "standard error"), rows)
