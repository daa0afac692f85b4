/// Field tables of pictures that clients show, and of images that they grab.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/pixels.hpp"
#include "proto/tables/camera.hpp"
#include "proto/tables/frame_terms.hpp"
#include "proto/tables/modes.hpp"

namespace ovws {

/// What the pixels of a client's picture are: phase in waves (float32), or grey levels (8 bit).
enum class PictureType { phase, grey };
template <>
inline constexpr NamesOf kNames<PictureType> = texts<"<f4", "<u1">;

constexpr double kLeaseS = 10.0;  ///< of a presentation whose client gives none

/// Params of `slm.present`; the picture itself is the request's binary frame.
struct SlmPresent {
  std::optional<int> job;
  std::optional<double> lease_s;  ///< none: as before, or kLeaseS
  std::vector<int> shape;         ///< rows, columns; empty: no picture
  PictureType type = PictureType::phase;
  bool correction = true, flatness = true, lut = true;
  bool inside_pupil = false;
};
template <>
inline constexpr auto kTable<SlmPresent> = Fields{
    "SlmPresent",
    field<&SlmPresent::job>(
        "number of the presentation that this picture belongs to, from the first one's result; "
        "null: begins a presentation",
        limits::kJob),
    field<&SlmPresent::lease_s>(
        "time after which the sensor's hologram returns unless another request comes, seconds; 0: "
        "at once; null: that of the request before, at first 10",
        limits::kLeaseS),
    field<&SlmPresent::shape>(
        "[rows, columns] of the picture, which must be those of the SLM; left out, without a "
        "binary frame: the picture stays, and the lease begins again",
        limits::kSlmSizePx)
        .sized(2, 2),
    field("dtype", &SlmPresent::type,
          "<f4: phase, waves; <u1: grey levels, of which g means g/256 wave"),
    field<&SlmPresent::correction>("whether to subtract the correction, inside the pupil"),
    field<&SlmPresent::flatness>("whether to add the flatness map"),
    field<&SlmPresent::lut>("whether to show phases through the look-up table; false: phase "
                            "g/256 wave is shown as grey level g"),
    field<&SlmPresent::inside_pupil>("whether only the pupil shows the picture, and the rest of "
                                     "the SLM phase 0")};

/// Result of `slm.present`.
struct PresentReport {
  int job = 0;
  std::uint64_t hologram_id = 0;
  std::optional<std::int64_t> t_settled_ns, t_lease_ns;
};
template <>
inline constexpr auto kTable<PresentReport> = Fields{
    "PresentReport", field<&PresentReport::job>("number of the presentation, a job", limits::kJob),
    field<&PresentReport::hologram_id>("number of the hologram that shows the picture"),
    field<&PresentReport::t_settled_ns>(
        "when the SLM had settled to the picture, ns since the UNIX epoch, UTC; null: the request "
        "had no picture"),
    field<&PresentReport::t_lease_ns>(
        "when the sensor's hologram returns unless another request comes, ns since the UNIX epoch, "
        "UTC; null: it returns now")};

/// Part of a camera's image.
struct ImagePart {
  int x = 0, y = 0, width = 1, height = 1;
};
template <>
inline constexpr auto kTable<ImagePart> =
    Fields{"ImagePart", field<&ImagePart::x>("left edge, pixels of the image", limits::kRoiOffset),
           field<&ImagePart::y>("top edge, pixels of the image", limits::kRoiOffset),
           field<&ImagePart::width>("width, pixels", limits::kRoiSize).mandatory(),
           field<&ImagePart::height>("height, pixels", limits::kRoiSize).mandatory()};

/// Params of `camera.grab`.
struct CameraGrab {
  std::optional<std::int64_t> after_hologram;
  int frames = 1;
  bool average = false;
  std::optional<ImagePart> region;
  double timeout_s = 10.0;
};
template <>
inline constexpr auto kTable<CameraGrab> = Fields{
    "CameraGrab",
    field<&CameraGrab::after_hologram>(
        "number of a hologram: only frames that were exposed wholly under it, settled; null: "
        "frames whose exposure began after the request",
        {1, 9007199254740991.0}),
    field<&CameraGrab::frames>("number of frames", limits::kGrabFrames),
    field<&CameraGrab::average>("true: their mean, as float32"),
    field<&CameraGrab::region>("part of the image; null: the whole image"),
    field<&CameraGrab::timeout_s>("longest time to wait for the frames, seconds",
                                  limits::kGrabTimeoutS)};

/// One frame of `camera.grab`.
struct GrabStamp {
  std::uint64_t frame_id = 0;
  std::uint64_t hologram_id = 0;
  bool settled = false;
  std::optional<int> pattern;
  std::int64_t t_device_ns = 0, t_arrival_ns = 0;
  double exposure_us = 0.0, gain_db = 0.0, gain_raw = kUnknownGain;
};
template <>
inline constexpr auto kTable<GrabStamp> =
    Fields{"GrabStamp",
           field<&GrabStamp::frame_id>(kFrameIdMeaning),
           field<&GrabStamp::hologram_id>(kFrameHologramMeaning),
           field<&GrabStamp::settled>(
               "whether the hologram had settled during the whole exposure, and of a "
               "sequence the pattern is certain"),
           field<&GrabStamp::pattern>(kPatternMeaning, kPatternBounds),
           field<&GrabStamp::t_device_ns>("the camera's own timestamp, ns; 0: it has none"),
           field<&GrabStamp::t_arrival_ns>(kArrivalMeaning),
           field<&GrabStamp::exposure_us>("exposure time of this frame, microseconds",
                                          limits::kExposureUs),
           field<&GrabStamp::gain_db>("gain of this frame, dB; null: the camera has no gain in dB",
                                      limits::kGainDb)
               .or_null(),
           field<&GrabStamp::gain_raw>(
               "gain of this frame in device-specific steps; null: the camera has its gain in dB")
               .or_null()};

/// Result of `camera.grab`; the pixels are the reply's binary frame.
struct GrabReport {
  std::vector<GrabStamp> frames;
  std::array<int, 3> shape{};
  bool average = false;
  PixelFormat format = PixelFormat::mono8;

  /// Bytes of one pixel in the binary frame.
  std::size_t pixel_bytes() const {
    if (average) return sizeof(float);
    return traits_of(format).layout == PixelLayout::bytes ? 1 : 2;
  }
};
template <>
inline constexpr auto kTable<GrabReport> = Fields{
    "GrabReport",
    field<&GrabReport::frames>("the frames, in the order of the camera"),
    field<&GrabReport::average>("whether the binary frame is their mean"),
    field<&GrabReport::shape>("shape of the binary frame: [images, rows, columns]"),
    computed(
        "dtype",
        [](auto& report) {
          constexpr std::array<std::string_view, 5> kTypes{"", "<u1", "<u2", "", "<f4"};
          return kTypes[report.pixel_bytes()];
        },
        kDtypeMeaning)
        .among(texts<"<u1", "<u2", "<f4">),
    field("pixel_format", &GrabReport::format, "GenICam name"),
    computed("significant_bits", [](auto& report) { return significant_bits(report.format); },
             "significant bits of each pixel, LSB-aligned", {8, 16})};

}  // namespace ovws
