/// Field tables of the streams' messages.
#pragma once

#include "core/base/pixels.hpp"
#include "proto/messages.hpp"
#include "proto/tables/camera.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/status.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

inline constexpr const char* kSeqMeaning =
    "number of this topic's message, from 0: a hole is a loss";
inline constexpr const char* kFrameIdMeaning = "camera's frame number";
inline constexpr const char* kArrivalMeaning =
    "frame complete in the daemon, UNIX epoch UTC, nanoseconds";
inline constexpr const char* kPublishMeaning = "message built, UNIX epoch UTC, nanoseconds";
inline constexpr const char* kFrameHologramMeaning =
    "hologram on the SLM during the whole exposure; 0: none known";
inline constexpr auto kUnit = constant("unit", "wave", "unit of coefficients and wavefronts");
inline constexpr auto kBasis = constant(
    "basis", "zernike-osa-rms", "OSA/ANSI Zernike modes, RMS-normalised, over the pupil circle");
inline constexpr auto kOrientation =
    constant("orientation", "x-right-y-down",
             "x along columns, y down along rows; theta from +x towards +y");

/// An array of numbers that are all encoded as null unless `known`.
template <class T>
struct IfKnown {
  std::span<const T> values;
  bool known = false;
  std::size_t count = values.size();
};
template <class T>
struct Wire<IfKnown<T>> {
  static Json to_json(const IfKnown<T>& numbers) {
    Json out = Json::array();
    for (std::size_t k = 0; k < numbers.count; ++k) {
      out.push_back(numbers.known ? ovws::to_json(numbers.values[k]) : Json());
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
struct Table<FrameMessage> {
  using M = FrameMessage;
  static constexpr const char* kName = "FrameMessage";
  static constexpr auto kFields = Fields{
      field("seq", &M::seq, kSeqMeaning),
      field("frame_id", &M::frame_id, kFrameIdMeaning),
      field("gap", &M::gap, "frames lost since the message before"),
      field("t_device_ns", &M::t_device_ns, "camera's own stamp, as given, nanoseconds"),
      field("t_arrival_ns", &M::t_arrival_ns, kArrivalMeaning),
      field("t_publish_ns", &M::t_publish_ns, kPublishMeaning),
      field("latency_us", &M::latency_us,
            "publish minus arrival by the monotonic clock, microseconds", Bounds::at_least(0)),
      field("hologram_id", &M::hologram_id, kFrameHologramMeaning),
      field("settled", &M::settled, "false while the hologram was changing"),
      field("charge", &M::charge, "topological charge of the hologram", limits::kCharge),
      field("tracker", &M::tracker, "tracker used").among([] { return tracker_names(); }),
      field("subapertures", &M::subapertures, "how many there are", Bounds::at_least(0)),
      field("tracked", &M::tracked, "how many were found in this frame", Bounds::at_least(0)),
      field("valid", &M::valid,
            "true only if settled, referenced, enough spots were found to determine the modes, and "
            "a wavefront of these modes explains where they are"),
      kUnit,
      field("wavelength_nm", &M::wavelength_nm, "length of one wave, nanometres",
            limits::kWavelengthNm),
      kBasis,
      kOrientation,
      computed<M>(
          "rms_waves", [](const M& m) { return m.valid ? m.rms_waves : std::nullopt; },
          "root sum square of the coefficients without piston and tilts, waves; null if not valid",
          Bounds::at_least(0)),
      field(
          "fit_residual_px", &M::fit_residual_px,
          "RMS of what the modes do not explain, camera pixels; also of a frame that is not valid "
          "because of it",
          Bounds::at_least(0)),
      field("gain_db", &M::gain_db,
            "of this very frame, dB; null if not known, or if the camera has no gain in dB",
            limits::kGainDb),
      field("gain_raw", &M::gain_raw,
            "of this very frame, in steps of the camera's own; null if not known, or if the camera "
            "has its gain in dB"),
      field("exposure_us", &M::exposure_us, "of this very frame, microseconds; null if not known",
            limits::kExposureUs),
      field("saturated", &M::saturated, "fraction of spots holding a saturated pixel", {0, 1}),
      computed<M>(
          "loop", [](const M& m) { return std::string_view(m.loop_closed ? "closed" : "open"); },
          "whether the correction follows the measurement")
          .among(open_or_closed),
      field("reference_introduced_rms_waves", &M::reference_introduced_rms_waves,
            "introduced aberration that the reference holds, so that coefficients do not, "
            "RMS-normalised waves; 0: none",
            Bounds::at_least(0))};
};

template <>
struct Table<WavefrontMessage> {
  using M = WavefrontMessage;
  static constexpr const char* kName = "Wavefront";
  static Json rules();
  static constexpr auto kFields = Fields{
      constant("schema", "ovws.wavefront/1", "form of this message"), based<FrameMessage>(),
      field("j", &M::j, "OSA/ANSI indices of the coefficients, without piston",
            {1, kMaxZernikeIndex}),
      computed<M>(
          "coefficients",
          [](const M& m) {
            return IfKnown<float>{m.coefficients, m.valid};
          },
          "the aberration present minus the reference, waves RMS, as many as j; all null if not "
          "valid")};
};

/// Shape of a binary part: rows, columns.
using Shape = std::array<int, 2>;
inline constexpr const char* kDtypeMeaning = "of the binary part, little-endian, as numpy names it";
inline constexpr auto kFloats = constant("dtype", "<f4", kDtypeMeaning);

template <>
struct Table<SpotsMessage> {
  using M = SpotsMessage;
  static constexpr const char* kName = "Spots";
  static constexpr std::array<std::string_view, 6> kColumns{"x",     "y",    "ref_x",
                                                            "ref_y", "peak", "quality"};
  static constexpr std::array<std::string_view, 6> kColumnUnits{"px", "px", "px", "px", "DN", "1"};
  static constexpr auto kFields = Fields{
      constant("schema", "ovws.spots/1", "form of this message"),
      based<FrameMessage>(),
      computed<M>(
          "shape",
          [](const M& m) {
            return Shape{int(m.spots.size()), int(kColumns.size())};
          },
          "[N, 6] of the binary part"),
      kFloats,
      computed<M>(
          "columns", [](const M&) { return kColumns; },
          "x, y: the spot; ref_x, ref_y: its reference; camera pixels of the region of interest; "
          "NaN: lost or no reference"),
      computed<M>(
          "column_units", [](const M&) { return kColumnUnits; },
          "camera pixels; camera grey levels; quality 0 to 1")};
};

template <>
struct Table<ImageMessage> {
  using M = ImageMessage;
  static constexpr const char* kName = "Image";
  static constexpr auto kFields = Fields{
      constant("schema", "ovws.image/1", "form of this message"),
      field("seq", &M::seq, kSeqMeaning),
      field("frame_id", &M::frame_id, kFrameIdMeaning),
      field("t_arrival_ns", &M::t_arrival_ns, kArrivalMeaning),
      field("hologram_id", &M::hologram_id, kFrameHologramMeaning),
      kOrientation,
      computed<M>(
          "shape",
          [](const M& m) {
            return Shape{m.image.height, m.image.width};
          },
          "[rows, columns] of the binary part"),
      computed<M>(
          "dtype",
          [](const M& m) {
            const bool bytes = traits_of(m.image.format).layout == PixelLayout::bytes;
            return std::string_view(bytes ? "<u1" : "<u2");
          },
          kDtypeMeaning)
          .among([] {
            return std::vector<std::string>{"<u1", "<u2"};
          }),
      computed<M>(
          "pixel_format", [](const M& m) { return m.image.format; }, "GenICam name"),
      computed<M>("significant_bits", [](const M& m) { return significant_bits(m.image.format); },
                  "of each pixel, right-justified", {8, 16})};
};

template <>
struct Table<PhaseMessage> {
  using M = PhaseMessage;
  static constexpr const char* kName = "Phase";
  static constexpr auto kFields =
      Fields{constant("schema", "ovws.phase/1", "form of this message"),
             field("seq", &M::seq, kSeqMeaning),
             field("frame_id", &M::frame_id, kFrameIdMeaning),
             field("t_arrival_ns", &M::t_arrival_ns, kArrivalMeaning),
             field("hologram_id", &M::hologram_id, kFrameHologramMeaning),
             kOrientation,
             field("valid", &M::valid, "as of the wavefront that it shows"),
             kUnit,
             field("wavelength_nm", &M::wavelength_nm, "length of one wave, nanometres",
                   limits::kWavelengthNm),
             computed<M>(
                 "shape",
                 [](const M& m) {
                   return Shape{m.waves->height, m.waves->width};
                 },
                 "[rows, columns] of the binary part"),
             kFloats};
};

template <>
struct Table<RefinedMessage> {
  using M = RefinedMessage;
  static constexpr const char* kName = "Refined";
  static std::optional<double> rms_waves(const M& m);
  static Json rules();
  static constexpr auto kFields = Fields{
      constant("schema", "ovws.refined/1", "form of this message"),
      field("seq", &M::seq, kSeqMeaning),
      field("frame_id", &M::frame_id, "camera's frame number, as in wavefront"),
      field("t_arrival_ns", &M::t_arrival_ns, kArrivalMeaning),
      field("t_publish_ns", &M::t_publish_ns, kPublishMeaning),
      field("hologram_id", &M::hologram_id,
            "hologram on the SLM during the whole exposure of this frame, whatever is shown since"),
      field("charge", &M::charge, "topological charge of this frame's hologram", limits::kCharge),
      field("valid", &M::valid,
            "true only if a minimum was found, there was light enough to tell the modes, and the "
            "model explains the pixels"),
      computed<M>(
          "reason", [](const M& m) { return m.valid ? std::string() : m.reason; },
          "why not valid, in plain words; null if valid")
          .or_null(),
      computed<M>(
          "against", [](const M& m) { return m.against_reference ? "reference" : "model"; },
          "what the coefficients count from: the refined picture of the reference, or, without a "
          "reference, the ideal sensor's model")
          .among([] {
            return std::vector<std::string>{"reference", "model"};
          }),
      kUnit,
      field("wavelength_nm", &M::wavelength_nm, "length of one wave, nanometres",
            limits::kWavelengthNm),
      kBasis,
      kOrientation,
      computed<M>(
          "rms_waves", rms_waves,
          "root sum square of the coefficients without piston and tilts, waves; null if not "
          "valid",
          Bounds::at_least(0)),
      field("gain_db", &M::gain_db, "of this very frame, dB; null if the camera has no gain in dB",
            limits::kGainDb)
          .or_null(),
      field("gain_raw", &M::gain_raw,
            "of this very frame, in steps of the camera's own; null if it has its gain in dB")
          .or_null(),
      field("exposure_us", &M::exposure_us, "of this very frame, microseconds",
            limits::kExposureUs),
      field("j", &M::j, "OSA/ANSI indices of the coefficients, without piston, as in wavefront",
            {1, kMaxZernikeIndex}),
      computed<M>(
          "coefficients",
          [](const M& m) {
            return IfKnown<double>{m.coefficients, m.valid, m.j.size()};
          },
          "the aberration present minus the reference, waves RMS, as many as j; all null if not "
          "valid"),
      computed<M>(
          "sigma",
          [](const M& m) {
            return IfKnown<double>{m.sigma, m.valid, m.j.size()};
          },
          "standard errors of the coefficients, the reference's included, waves, as many as j; all "
          "null if not valid",
          Bounds::at_least(0)),
      inlined(&M::fit),
      field("duration_ms", &M::duration_ms, "of the fit, milliseconds", Bounds::at_least(0))};
};

template <>
struct Table<RefinedMessage::Fit> {
  using F = RefinedMessage::Fit;
  static constexpr const char* kName = "RefinedFit";
  static constexpr auto kFields = Fields{
      field("chi2_per_pixel", &F::chi2_per_pixel,
            "misfit in units of the noise stated: about 1 if the model explains the frame; null if "
            "no minimum was found",
            Bounds::at_least(0)),
      field("peak_e", &F::peak_e, "the model's brightest pixel above the background, electrons"),
      field("background_e", &F::background_e, "a pixel, above the black level, electrons"),
      field("iterations", &F::iterations, "of the fit", Bounds::at_least(0))};
};

template <>
struct Names<Severity> {
  static const std::vector<std::string>& all() {
    static const std::vector<std::string> names{"info", "warning", "error"};
    return names;
  }
};

template <>
struct Table<EventMessage> {
  using M = EventMessage;
  static constexpr const char* kName = "Event";
  static constexpr auto kFields =
      Fields{constant("schema", "ovws.event/1", "form of this message"),
             field("seq", &M::seq, kSeqMeaning),
             field("t_ns", &M::t_ns, kTimeMeaning),
             field("kind", &M::kind, "what it is about: state, camera, slm, job, …"),
             field("severity", &M::severity, "how bad it is"),
             field("text", &M::text, "one sentence for a person"),
             field("data", &M::data, "for programs; its shape depends on the kind")};
};

/// `status` as it is published; `system.status` is the same without `schema` and `seq`.
struct StreamedStatus {
  StatusMessage status;
};
template <>
struct Table<StreamedStatus> {
  static constexpr const char* kName = "StreamedStatus";
  static constexpr auto kFields = Fields{
      constant("schema", "ovws.status/1", "form of this message"),
      computed<StreamedStatus>(
          "seq", [](const StreamedStatus& streamed) { return streamed.status.seq; }, kSeqMeaning),
      inlined(&StreamedStatus::status)};
};

}  // namespace ovws
