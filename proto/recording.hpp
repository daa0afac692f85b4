/// Layout of a recording, independent of the file format. RECORDING.md documents it for users.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include "core/base/pixel_format.hpp"

namespace ovws {

constexpr const char* kRecordingSchema = "ovws.recording/2";
/// What coefficients and positions mean, in every message, recording and export.
constexpr const char* kBasisName = "zernike-osa-rms";       ///< in waves of the laser
constexpr const char* kOrientationName = "x-right-y-down";  ///< of image and pupil
/// Limit of one image: a reader allocates memory by the size stated in the file.
constexpr std::size_t kMaxRecordedImageBytes = 128 << 20;
/// Limits that both the recorder and the reader enforce.
constexpr std::uint64_t kMaxRecordedFrames = 1 << 24;     // nine hours at 500 frames/s
constexpr std::uint64_t kMaxRecordedDocuments = 1 << 20;  // 20 hours of a closed loop at 14 steps/s
constexpr std::uint64_t kMaxRecordedTextBytes = std::uint64_t{4} << 30;  // all documents together

/// One row of `frames`. Times in ns, `…_mono_ns` by CLOCK_MONOTONIC of the recording machine.
struct RecordedFrame {
  std::uint64_t frame_id = 0, gap = 0;
  std::uint64_t hologram_id = 0, plan_id = 0;
  std::int64_t t_device_ns = 0, t_arrival_ns = 0, t_arrival_mono_ns = 0;
  std::int64_t t_tracked_mono_ns = 0, t_reconstructed_mono_ns = 0;
  double gain_db = 0.0, exposure_us = 0.0;  ///< 0 unless settings_known
  /// NaN if the settings are unknown or the camera reports its gain in dB. A camera without a gain
  /// in dB has gain_db NaN.
  double gain_raw = std::numeric_limits<double>::quiet_NaN();
  double fit_residual_px = 0.0, rms_waves = 0.0;
  float saturated = 0.0F;
  std::uint32_t tracked = 0;
  /// Its row of `spots` and of `coefficients`.
  std::uint64_t first_spot = 0, first_coefficient = 0;
  std::uint32_t spots = 0, coefficients = 0;  ///< how many columns, or rows
  std::int64_t picture = -1;                  ///< row of the image in `pictures`; -1: no image
  std::uint64_t dropped_before = 0;  ///< frames since the previous row that are not in this file
  std::uint8_t picture_dropped = 0;  ///< 1: its image was dropped because the disk was too slow
  std::uint8_t still = 0, settled = 0, settings_known = 0, determined = 0, explained = 0, valid = 0;
  /// Bit 0: the whole image was searched for spots. Bit k: its part of the k-th further light
  /// source was.
  std::uint8_t searched = 0;
  std::uint8_t left_justified_bits = 0;
};

/// One cell of `spots` and `beam_spots`: SpotFix, and the position where its search began
/// (SpotStart).
struct RecordedSpot {
  float x = 0.0F, y = 0.0F, peak = 0.0F, quality = 0.0F, level = 0.0F, noise = 0.0F;
  double start_x = 0.0, start_y = 0.0;
  std::uint8_t fresh = 0;
};

/// One row of the dataset `documents`: where a JSON document lies in the dataset `text`, and the
/// first frame that it applies to.
struct RecordedDocument {
  std::array<char, 16> kind{};    ///< "plan", "reference", …
  std::array<char, 64> sha256{};  ///< SHA-256 of the document's text, hexadecimal
  std::uint64_t from_frame = 0;   ///< row of `frames`
  std::uint64_t first_byte = 0, bytes = 0;
};

/// The one row of `summary`.
struct RecordedSummary {
  std::uint64_t frames = 0, frames_dropped = 0;
  std::uint64_t pictures = 0, pictures_dropped = 0;
  std::uint64_t documents_dropped = 0;
  std::int64_t t_written_ns = 0;  ///< UTC
  std::uint8_t ended = 0;         ///< 0: still being written, or cut off
};

/// Attributes of the file.
struct RecordingHeader {
  std::int64_t t_begin_ns = 0;  ///< UTC
  std::string program;          ///< program that wrote the file
  PixelFormat format = PixelFormat::mono8;
  std::string vendor, model, serial;  ///< of the camera; empty: unknown
  double frame_rate_hz = 100.0;       ///< as set when the recording began
  int x = 0, y = 0;                   ///< corner of the region on the camera's sensor
  int width = 0, height = 0;          ///< of an image, pixels
  int pictures_every = 1;             ///< 0: no images
  double wavelength_nm = 632.0;
};

/// Storage type of a field. Text has a fixed length and is NUL-padded.
enum class FieldType : std::uint8_t { u8, u32, u64, i64, f32, f64, text16, text64 };

struct RecordedField {
  const char* name;
  FieldType type;
  std::size_t offset;
  const char* unit;  ///< "": a count, an id or a flag
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
    OVWS_FIELD(RecordedSummary, documents_dropped, u64, "documents"),
    OVWS_FIELD(RecordedSummary, t_written_ns, i64, "ns"),
    OVWS_FIELD(RecordedSummary, ended, u8, ""),
};

#undef OVWS_FIELD

/// Bytes per element of an image in `pictures`: 1 or 2.
inline int image_word_bytes(PixelFormat format) {
  return traits_of(format).layout == PixelLayout::words ? 2 : 1;
}
/// Elements per row of an image in `pictures`: pixels, or bytes for packed formats.
inline int image_columns(PixelFormat format, int width) {
  return int(row_bytes(format, width)) / image_word_bytes(format);
}

}  // namespace ovws
