/// Field tables of the streams' messages.
#pragma once

#include "core/base/pixels.hpp"
#include "proto/messages.hpp"
#include "proto/recording.hpp"
#include "proto/tables/camera.hpp"
#include "proto/tables/corrector.hpp"
#include "proto/tables/frame_terms.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/status.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

inline constexpr const char* kSeqMeaning =
    "sequence number of this topic's messages, from 0; a gap means lost messages";
inline constexpr auto kUnit = constant("unit", "wave", "unit of coefficients and wavefronts");
inline constexpr auto kBasis =
    constant("basis", kBasisName, "OSA/ANSI Zernike modes, RMS-normalised, over the pupil circle");
inline constexpr auto kOrientation =
    constant("orientation", kOrientationName,
             "x along columns, y down along rows; theta from +x towards +y");

/// An array of numbers that are all encoded as null unless `valid`.
template <class T>
struct NumbersOrNull {
  std::span<const T> values;
  bool valid = false;
  std::size_t count = values.size();
};
template <class T>
struct Wire<NumbersOrNull<T>> {
  static Json to_json(const NumbersOrNull<T>& numbers) {
    Json out = Json::array();
    for (std::size_t k = 0; k < numbers.count; ++k) {
      out.push_back(numbers.valid ? ovws::to_json(numbers.values[k]) : Json());
    }
    return out;
  }
  static Json schema(SchemaParts&, const FieldInfo& field) {
    Json number{{"type", {"number", "null"}}};
    if (std::isfinite(field.bounds.min)) number["minimum"] = field.bounds.min;
    return {{"type", "array"}, {"items", std::move(number)}};
  }
};

template <>
inline constexpr auto kTable<FrameMessage> = Fields{
    "FrameMessage",
    field<&FrameMessage::seq>(kSeqMeaning),
    field<&FrameMessage::frame_id>(kFrameIdMeaning),
    field<&FrameMessage::gap>("frames lost since the previous message"),
    field<&FrameMessage::t_device_ns>("camera's own timestamp, unchanged, nanoseconds"),
    field<&FrameMessage::t_arrival_ns>(kArrivalMeaning),
    field<&FrameMessage::t_publish_ns>(kPublishMeaning),
    field<&FrameMessage::latency_us>("publish minus arrival by the monotonic clock, microseconds",
                                     Bounds::at_least(0)),
    field<&FrameMessage::hologram_id>(kFrameHologramMeaning),
    field<&FrameMessage::settled>(
        "whether the SLM showed the sensor, settled, during the whole exposure"),
    field<&FrameMessage::pattern>(kPatternMeaning, kPatternBounds),
    field<&FrameMessage::charge>("topological charge of the hologram", limits::kCharge),
    field<&FrameMessage::tracker>("tracker used").among(kNames<TrackerKind>),
    field<&FrameMessage::subapertures>("number of subapertures", Bounds::at_least(0)),
    field<&FrameMessage::tracked>("number of spots found in this frame", Bounds::at_least(0)),
    field<&FrameMessage::valid>(
        "true only if the frame is settled, a reference is active, enough spots were found to "
        "determine the modes, and a wavefront of these modes explains their positions"),
    computed(
        "verdict", [](auto& m) { return wire_name(m.verdict); },
        "valid, or the first reason why the frame is not, in this order")
        .among(kNames<Verdict>),
    kUnit,
    field<&FrameMessage::wavelength_nm>("wavelength, nanometres", limits::kWavelengthNm),
    kBasis,
    kOrientation,
    computed(
        "rms_waves", [](auto& m) { return m.valid ? m.rms_waves : std::nullopt; },
        "root sum square of the coefficients without piston and tilts, waves; null if not valid",
        Bounds::at_least(0)),
    field<&FrameMessage::fit_residual_px>(
        "RMS of the displacements that the modes do not explain, camera pixels; given even if the "
        "frame is not valid because it is too large",
        Bounds::at_least(0)),
    field<&FrameMessage::gain_db>(
        "gain of this frame, dB; null: unknown, or the camera has no gain in dB", limits::kGainDb),
    field<&FrameMessage::gain_raw>("gain of this frame in device-specific steps; null: unknown, or "
                                   "the camera has its gain in dB"),
    field<&FrameMessage::exposure_us>("exposure time of this frame, microseconds; null: unknown",
                                      limits::kExposureUs),
    field<&FrameMessage::saturated>("fraction of spots with a saturated pixel", {0, 1}),
    computed(
        "loop", [](auto& m) { return std::string_view(m.loop_closed ? "closed" : "open"); },
        "whether the loop is closed")
        .among(texts<"open", "closed">),
    field<&FrameMessage::reference_introduced_rms_waves>(
        "RMS of the introduced aberration that the reference contains and coefficients therefore "
        "exclude, waves; 0: none",
        Bounds::at_least(0))};

template <>
inline constexpr auto kTable<WavefrontMessage> =
    Fields{"Wavefront",
           constant("schema", "ovws.wavefront/1", "schema and version of this message"),
           based<FrameMessage>(),
           field<&WavefrontMessage::j>("OSA/ANSI indices of the coefficients, without piston",
                                       {1, kMaxZernikeIndex}),
           computed(
               "coefficients",
               [](auto& m) {
                 return NumbersOrNull<float>{m.coefficients, m.valid};
               },
               "present aberration minus the reference, RMS-normalised waves, as many as j; all "
               "null if not valid"),
           computed(
               "sigma",
               [](auto& m) {
                 return NumbersOrNull<float>{m.sigma, m.valid && m.fitted};
               },
               "standard errors of the coefficients, RMS-normalised waves; all null if the frame "
               "was measured by the positions of its spots only"),
           field<&WavefrontMessage::branch_points>(
               "phase singularities of the incoming light, each [x, y, charge]: x and y in pupil "
               "radii from the pupil's centre along the SLM's axes, charge 1 or -1; empty: none "
               "recognised. A frame with a branch point is not valid")};
template <>
struct Rules<WavefrontMessage> {
  static Json schema();
};

inline constexpr auto kFloats = constant("dtype", "<f4", kDtypeMeaning);

inline constexpr std::array<std::string_view, 6> kSpotColumns{"x",     "y",    "ref_x",
                                                              "ref_y", "peak", "quality"};
inline constexpr std::array<std::string_view, 6> kSpotColumnUnits{"px", "px", "px",
                                                                  "px", "DN", "1"};
template <>
inline constexpr auto kTable<SpotsMessage> =
    Fields{"Spots",
           constant("schema", "ovws.spots/1", "schema and version of this message"),
           based<FrameMessage>(),
           computed(
               "shape",
               [](auto& m) {
                 return Shape{int(m.spots.size()), int(kSpotColumns.size())};
               },
               "shape of the binary part: [N, 6]"),
           kFloats,
           computed(
               "columns", [](const SpotsMessage&) { return kSpotColumns; },
               "x, y: spot position; ref_x, ref_y: reference position, both in camera pixels of "
               "the region of interest; peak: brightest pixel; quality: contrast; NaN: lost spot "
               "or no reference"),
           computed(
               "column_units", [](const SpotsMessage&) { return kSpotColumnUnits; },
               "units of the columns: camera pixels; camera grey levels; 1 for quality, 0 to 1")};

template <>
inline constexpr auto kTable<CorrectorMessage> =
    Fields{"Corrector",
           constant("schema", "ovws.corrector/1", "schema and version of this message"),
           based<FrameMessage>(),
           field<&CorrectorMessage::matrix>(kCorrectorMatrixMeaning, Bounds::at_least(1)),
           computed(
               "shape", [](auto& m) { return std::array{int(m.commands.size())}; },
               "shape of the binary part: [actuators]; [0], and no binary part, if not valid"),
           kFloats};

template <>
inline constexpr auto kTable<ImageMessage> =
    Fields{"Image",
           constant("schema", "ovws.image/1", "schema and version of this message"),
           field<&ImageMessage::seq>(kSeqMeaning),
           field<&ImageMessage::frame_id>(kFrameIdMeaning),
           field<&ImageMessage::t_arrival_ns>(kArrivalMeaning),
           field<&ImageMessage::hologram_id>(kFrameHologramMeaning),
           field<&ImageMessage::pattern>(kPatternMeaning, kPatternBounds),
           kOrientation,
           computed(
               "shape",
               [](auto& m) {
                 return Shape{m.image.height, m.image.width};
               },
               "shape of the binary part: [rows, columns]"),
           computed(
               "dtype",
               [](auto& m) {
                 const bool bytes = traits_of(m.image.format).layout == PixelLayout::bytes;
                 return std::string_view(bytes ? "<u1" : "<u2");
               },
               kDtypeMeaning)
               .among(texts<"<u1", "<u2">),
           computed(
               "pixel_format", [](auto& m) { return m.image.format; }, "GenICam name"),
           computed("significant_bits", [](auto& m) { return significant_bits(m.image.format); },
                    "significant bits of each pixel, LSB-aligned", {8, 16})};

template <>
inline constexpr auto kTable<PhaseMessage> =
    Fields{"Phase",
           constant("schema", "ovws.phase/1", "schema and version of this message"),
           field<&PhaseMessage::seq>(kSeqMeaning),
           field<&PhaseMessage::frame_id>(kFrameIdMeaning),
           field<&PhaseMessage::t_arrival_ns>(kArrivalMeaning),
           field<&PhaseMessage::hologram_id>(kFrameHologramMeaning),
           kOrientation,
           field<&PhaseMessage::valid>("whether the wavefront that it shows is valid"),
           kUnit,
           field<&PhaseMessage::wavelength_nm>("wavelength, nanometres", limits::kWavelengthNm),
           computed(
               "shape",
               [](auto& m) {
                 return Shape{m.waves->height, m.waves->width};
               },
               "shape of the binary part: [rows, columns]"),
           kFloats};

/// Root sum square of the coefficients without piston and tilts, waves; none if not valid.
std::optional<double> rms_waves(const RefinedMessage& message);
template <>
inline constexpr auto kTable<RefinedMessage> = Fields{
    "Refined",
    constant("schema", "ovws.refined/1", "schema and version of this message"),
    field<&RefinedMessage::seq>(kSeqMeaning),
    field<&RefinedMessage::frame_id>("camera's frame number, as in wavefront"),
    field<&RefinedMessage::t_arrival_ns>(kArrivalMeaning),
    field<&RefinedMessage::t_publish_ns>(kPublishMeaning),
    field<&RefinedMessage::hologram_id>("number of the hologram on the SLM during the whole "
                                        "exposure of this frame, whatever is shown now"),
    field<&RefinedMessage::charge>("topological charge of this frame's hologram", limits::kCharge),
    field<&RefinedMessage::valid>("true only if the fit found a minimum, there was enough light to "
                                  "determine the modes, and the model explains the pixels"),
    computed(
        "reason", [](auto& m) { return m.valid ? std::string() : m.reason; },
        "why it is not valid; null if valid")
        .or_null(),
    computed(
        "against", [](auto& m) { return m.against_reference ? "reference" : "model"; },
        "origin of the coefficients: reference, the refined image of the reference; model, the "
        "ideal sensor, if there is no reference")
        .among(texts<"reference", "model">),
    kUnit,
    field<&RefinedMessage::wavelength_nm>("wavelength, nanometres", limits::kWavelengthNm),
    kBasis,
    kOrientation,
    computed(
        "rms_waves", rms_waves,
        "root sum square of the coefficients without piston and tilts, waves; null if not valid",
        Bounds::at_least(0)),
    field<&RefinedMessage::gain_db>("gain of this frame, dB; null: the camera has no gain in dB",
                                    limits::kGainDb)
        .or_null(),
    field<&RefinedMessage::gain_raw>(
        "gain of this frame in device-specific steps; null: the camera has its gain in dB")
        .or_null(),
    field<&RefinedMessage::exposure_us>("exposure time of this frame, microseconds",
                                        limits::kExposureUs),
    field<&RefinedMessage::j>(
        "OSA/ANSI indices of the coefficients, without piston, as in wavefront",
        {1, kMaxZernikeIndex}),
    computed(
        "coefficients",
        [](auto& m) {
          return NumbersOrNull<double>{m.coefficients, m.valid, m.j.size()};
        },
        "present aberration minus the reference, RMS-normalised waves, as many as j; all null if "
        "not valid"),
    computed(
        "sigma",
        [](auto& m) {
          return NumbersOrNull<double>{m.sigma, m.valid, m.j.size()};
        },
        "standard errors of the coefficients, including those of the reference, waves, as many as "
        "j; all null if not valid",
        Bounds::at_least(0)),
    inlined(&RefinedMessage::fit),
    field<&RefinedMessage::duration_ms>("duration of the fit, milliseconds", Bounds::at_least(0))};
template <>
struct Rules<RefinedMessage> {
  static Json schema();
};

template <>
inline constexpr auto kTable<RefinedMessage::Fit> = [] {
  using F = RefinedMessage::Fit;
  return Fields{
      "RefinedFit",
      field<&F::chi2_per_pixel>("chi-squared per pixel with the stated noise: about 1 if the model "
                                "explains the frame; null if no minimum was found",
                                Bounds::at_least(0)),
      field<&F::peak_e>("brightest pixel of the model above the background, electrons"),
      field<&F::background_e>("background of a pixel above the black level, electrons"),
      field<&F::iterations>(
          "number of renderings; 0: those of an earlier frame are exact for this one, too",
          Bounds::at_least(0))};
}();

template <>
inline constexpr NamesOf kNames<Severity> = texts<"info", "warning", "error">;

template <>
inline constexpr auto kTable<EventMessage> =
    Fields{"Event",
           constant("schema", "ovws.event/1", "schema and version of this message"),
           field<&EventMessage::seq>(kSeqMeaning),
           field<&EventMessage::t_ns>(kTimeMeaning),
           field<&EventMessage::kind>("subject of the event: state, camera, slm, job, …"),
           field<&EventMessage::severity>("severity of the event"),
           field<&EventMessage::text>("message for the user, one sentence"),
           field<&EventMessage::data>("data for programs; its structure depends on the kind")};

/// Message of the stream `status`. The result of `system.status` lacks its `schema` and `seq`.
struct StreamedStatus {
  StatusMessage status;
};
template <>
inline constexpr auto kTable<StreamedStatus> = Fields{
    "StreamedStatus", constant("schema", "ovws.status/1", "schema and version of this message"),
    computed(
        "seq", [](auto& streamed) { return streamed.status.seq; }, kSeqMeaning),
    inlined(&StreamedStatus::status)};

}  // namespace ovws
