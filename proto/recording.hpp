/// What a recording holds, whatever file it is in: RECORDING.md says the same to people.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include "core/base/pixel_format.hpp"

namespace ovws {

constexpr const char* kRecordingSchema = "ovws.recording/1";
/// A reader takes memory for pictures by what the file says of their size.
constexpr std::size_t kMostRecordedPictureBytes = 128 << 20;
/// More than these a recording does not take, and a reader not read.
constexpr std::uint64_t kMostRecordedFrames = 1 << 24;  // nine hours at 500 a second
constexpr std::uint64_t kMostRecordedDocuments = 1 << 20;
constexpr std::uint64_t kMostRecordedTextBytes = 1 << 30;  // of all documents

/// One row of `frames`. Times in ns, `…_mono_ns` by CLOCK_MONOTONIC of the recording machine.
struct RecordedFrame {
  std::uint64_t frame_id = 0, gap = 0;
  std::uint64_t hologram_id = 0, plan_id = 0;
  std::int64_t t_device_ns = 0, t_arrival_ns = 0, t_arrival_mono_ns = 0;
  std::int64_t t_tracked_mono_ns = 0, t_reconstructed_mono_ns = 0;
  double gain_db = 0.0, exposure_us = 0.0;  ///< 0 unless settings_known
  /// NaN unless settings_known, or if the camera has its gain in dB; of such without, gain_db is
  /// NaN
  double gain_raw = std::numeric_limits<double>::quiet_NaN();
  double fit_residual_px = 0.0, rms_waves = 0.0;
  float saturated = 0.0F;
  std::uint32_t tracked = 0;
  std::uint64_t first_spot = 0, first_coefficient = 0;
  std::uint32_t spots = 0, coefficients = 0;
  std::int64_t picture = -1;         ///< its number in `pictures`; -1: it has none
  std::uint64_t dropped_before = 0;  ///< published since the row before, and not in this file
  std::uint8_t picture_dropped = 0;  ///< it was to have one, and the disk could not follow
  std::uint8_t still = 0, settled = 0, settings_known = 0, determined = 0, explained = 0, valid = 0;
  std::uint8_t searched = 0;  ///< its spots were looked for in the whole image, too
  std::uint8_t left_justified_bits = 0;
};

/// One row of `spots`: SpotFix, and where it was looked for at first (SpotStart).
struct RecordedSpot {
  float x = 0.0F, y = 0.0F, peak = 0.0F, quality = 0.0F, level = 0.0F, noise = 0.0F;
  double start_x = 0.0, start_y = 0.0;
  std::uint8_t fresh = 0;
};

/// One row of `documents`: a part of `text`, JSON, in force from a frame on.
struct RecordedDocument {
  std::array<char, 16> kind{};    ///< "plan", "reference", …
  std::array<char, 64> sha256{};  ///< of the text, hexadecimal
  std::uint64_t from_frame = 0;   ///< row of `frames`
  std::uint64_t first_byte = 0, bytes = 0;
};

/// The one row of `summary`.
struct RecordedSummary {
  std::uint64_t frames = 0, frames_dropped = 0;
  std::uint64_t pictures = 0, pictures_dropped = 0;
  std::int64_t t_written_ns = 0;  ///< UTC
  std::uint8_t ended = 0;         ///< 0: it goes on, or was cut off
};

/// Attributes of the file.
struct RecordingHeader {
  std::int64_t t_begin_ns = 0;  ///< UTC
  std::string program;          ///< that wrote it
  PixelFormat format = PixelFormat::mono8;
  std::string vendor, model, serial;  ///< of the camera; empty: not known
  double frame_rate_hz = 100.0;       ///< as set at the begin
  int x = 0, y = 0;                   ///< of the region on the camera's sensor
  int width = 0, height = 0;          ///< of a picture, pixels
  int pictures_every = 1;             ///< 0: there are none
  double wavelength_nm = 632.0;
};

/// How a row's number is kept; text is of fixed length, NUL-padded.
enum class FieldType : std::uint8_t { u8, u32, u64, i64, f32, f64, text16, text64 };

struct RecordedField {
  const char* name;
  FieldType type;
  std::size_t offset;
  const char* unit;  ///< "": a number or a truth
};

#define OVWS_FIELD(row, name, type, unit)             \
  RecordedField {                                     \
#name, FieldType::type, offsetof(row, name), unit \
  }

inline constexpr std::array kFrameFields{
    OVWS_FIELD(RecordedFrame, frame_id, u64, ""),
    OVWS_FIELD(RecordedFrame, gap, u64, "frames"),
    OVWS_FIELD(RecordedFrame, hologram_id, u64, ""),
    OVWS_FIELD(RecordedFrame, plan_id, u64, ""),
    OVWS_FIELD(RecordedFrame, t_device_ns, i64, "ns"),
    OVWS_FIELD(RecordedFrame, t_arrival_ns, i64, "ns"),
    OVWS_FIELD(RecordedFrame, t_arrival_mono_ns, i64, "ns"),
    OVWS_FIELD(RecordedFrame, t_tracked_mono_ns, i64, "ns"),
    OVWS_FIELD(RecordedFrame, t_reconstructed_mono_ns, i64, "ns"),
    OVWS_FIELD(RecordedFrame, gain_db, f64, "dB"),
    OVWS_FIELD(RecordedFrame, exposure_us, f64, "us"),
    OVWS_FIELD(RecordedFrame, gain_raw, f64, ""),
    OVWS_FIELD(RecordedFrame, fit_residual_px, f64, "px"),
    OVWS_FIELD(RecordedFrame, rms_waves, f64, "wave"),
    OVWS_FIELD(RecordedFrame, saturated, f32, ""),
    OVWS_FIELD(RecordedFrame, tracked, u32, "spots"),
    OVWS_FIELD(RecordedFrame, first_spot, u64, "row of spots"),
    OVWS_FIELD(RecordedFrame, first_coefficient, u64, "row of coefficients"),
    OVWS_FIELD(RecordedFrame, spots, u32, "rows of spots"),
    OVWS_FIELD(RecordedFrame, coefficients, u32, "rows of coefficients"),
    OVWS_FIELD(RecordedFrame, picture, i64, "row of pictures"),
    OVWS_FIELD(RecordedFrame, dropped_before, u64, "frames"),
    OVWS_FIELD(RecordedFrame, picture_dropped, u8, ""),
    OVWS_FIELD(RecordedFrame, still, u8, ""),
    OVWS_FIELD(RecordedFrame, settled, u8, ""),
    OVWS_FIELD(RecordedFrame, settings_known, u8, ""),
    OVWS_FIELD(RecordedFrame, determined, u8, ""),
    OVWS_FIELD(RecordedFrame, explained, u8, ""),
    OVWS_FIELD(RecordedFrame, valid, u8, ""),
    OVWS_FIELD(RecordedFrame, searched, u8, ""),
    OVWS_FIELD(RecordedFrame, left_justified_bits, u8, "bits"),
};

inline constexpr std::array kSpotFields{
    OVWS_FIELD(RecordedSpot, x, f32, "px"),       OVWS_FIELD(RecordedSpot, y, f32, "px"),
    OVWS_FIELD(RecordedSpot, peak, f32, "DN"),    OVWS_FIELD(RecordedSpot, quality, f32, ""),
    OVWS_FIELD(RecordedSpot, level, f32, "DN"),   OVWS_FIELD(RecordedSpot, noise, f32, "DN"),
    OVWS_FIELD(RecordedSpot, start_x, f64, "px"), OVWS_FIELD(RecordedSpot, start_y, f64, "px"),
    OVWS_FIELD(RecordedSpot, fresh, u8, ""),
};

inline constexpr std::array kDocumentFields{
    OVWS_FIELD(RecordedDocument, kind, text16, ""),
    OVWS_FIELD(RecordedDocument, sha256, text64, ""),
    OVWS_FIELD(RecordedDocument, from_frame, u64, "row of frames"),
    OVWS_FIELD(RecordedDocument, first_byte, u64, "byte of text"),
    OVWS_FIELD(RecordedDocument, bytes, u64, "bytes"),
};

inline constexpr std::array kSummaryFields{
    OVWS_FIELD(RecordedSummary, frames, u64, "frames"),
    OVWS_FIELD(RecordedSummary, frames_dropped, u64, "frames"),
    OVWS_FIELD(RecordedSummary, pictures, u64, "pictures"),
    OVWS_FIELD(RecordedSummary, pictures_dropped, u64, "pictures"),
    OVWS_FIELD(RecordedSummary, t_written_ns, i64, "ns"),
    OVWS_FIELD(RecordedSummary, ended, u8, ""),
};

#undef OVWS_FIELD

/// How many numbers a row of `pictures`' rows has: pixels, or bytes where several share one.
int picture_columns(PixelFormat format, int width);
/// Bytes of one of these numbers: 1 or 2.
int picture_word_bytes(PixelFormat format);

}  // namespace ovws
