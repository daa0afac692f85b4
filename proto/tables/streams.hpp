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
    "sequence number of this topic's messages, from 0; a gap means lost messages";
inline constexpr const char* kFrameIdMeaning = "camera's frame number";
inline constexpr const char* kArrivalMeaning =
    "frame complete in the daemon, UNIX epoch UTC, nanoseconds";
inline constexpr const char* kPublishMeaning = "message built, UNIX epoch UTC, nanoseconds";
inline constexpr const char* kFrameHologramMeaning =
    "number of the hologram on the SLM during the whole exposure; 0: unknown";
inline constexpr auto kUnit = constant("unit", "wave", "unit of coefficients and wavefronts");
inline constexpr auto kBasis = constant(
    "basis", "zernike-osa-rms", "OSA/ANSI Zernike modes, RMS-normalised, over the pupil circle");
inline constexpr auto kOrientation =
    constant("orientation", "x-right-y-down",
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
struct Table<FrameMessage> {
  using M = FrameMessage;
  static constexpr const char* kName = "FrameMessage";
  static constexpr auto kFields = Fields{
      field("seq", &M::seq, kSeqMeaning),
      field("frame_id", &M::frame_id, kFrameIdMeaning),
      field("gap", &M::gap, "frames lost since the previous message"),
      field("t_device_ns", &M::t_device_ns, "camera's own timestamp, unchanged, nanoseconds"),
      field("t_arrival_ns", &M::t_arrival_ns, kArrivalMeaning),
      field("t_publish_ns", &M::t_publish_ns, kPublishMeaning),
      field("latency_us", &M::latency_us,
            "publish minus arrival by the monotonic clock, microseconds", Bounds::at_least(0)),
      field("hologram_id", &M::hologram_id, kFrameHologramMeaning),
      field("settled", &M::settled,
            "whether the SLM showed the sensor, settled, during the whole exposure"),
      field("charge", &M::charge, "topological charge of the hologram", limits::kCharge),
      field("tracker", &M::tracker, "tracker used").among([] { return tracker_names(); }),
      field("subapertures", &M::subapertures, "number of subapertures", Bounds::at_least(0)),
      field("tracked", &M::tracked, "number of spots found in this frame", Bounds::at_least(0)),
      field("valid", &M::valid,
            "true only if the frame is settled, a reference is active, enough spots were found to "
            "determine the modes, and a wavefront of these modes explains their positions"),
      kUnit,
      field("wavelength_nm", &M::wavelength_nm, "wavelength, nanometres", limits::kWavelengthNm),
      kBasis,
      kOrientation,
      computed<M>(
          "rms_waves", [](const M& m) { return m.valid ? m.rms_waves : std::nullopt; },
          "root sum square of the coefficients without piston and tilts, waves; null if not valid",
          Bounds::at_least(0)),
      field("fit_residual_px", &M::fit_residual_px,
            "RMS of the displacements that the modes do not explain, camera pixels; also for a "
            "frame that is not valid because of it",
            Bounds::at_least(0)),
      field("gain_db", &M::gain_db,
            "gain of this frame, dB; null: unknown, or the camera has no gain in dB",
            limits::kGainDb),
      field("gain_raw", &M::gain_raw,
            "gain of this frame in device-specific steps; null: unknown, or the camera has its "
            "gain in dB"),
      field("exposure_us", &M::exposure_us,
            "exposure time of this frame, microseconds; null: unknown", limits::kExposureUs),
      field("saturated", &M::saturated, "fraction of spots with a saturated pixel", {0, 1}),
      computed<M>(
          "loop", [](const M& m) { return std::string_view(m.loop_closed ? "closed" : "open"); },
          "whether the loop is closed")
          .among(open_or_closed),
      field("reference_introduced_rms_waves", &M::reference_introduced_rms_waves,
            "RMS of the introduced aberration that the reference contains and coefficients "
            "therefore exclude, waves; 0: none",
            Bounds::at_least(0))};
};

template <>
struct Table<WavefrontMessage> {
  using M = WavefrontMessage;
  static constexpr const char* kName = "Wavefront";
  static Json rules();
  static constexpr auto kFields =
      Fields{constant("schema", "ovws.wavefront/1", "schema and version of this message"),
             based<FrameMessage>(),
             field("j", &M::j, "OSA/ANSI indices of the coefficients, without piston",
                   {1, kMaxZernikeIndex}),
             computed<M>(
                 "coefficients",
                 [](const M& m) {
                   return NumbersOrNull<float>{m.coefficients, m.valid};
                 },
                 "present aberration minus the reference, RMS-normalised waves, as many as j; "
                 "all null if not valid"),
             computed<M>(
                 "sigma",
                 [](const M& m) {
                   return NumbersOrNull<float>{m.sigma, m.valid && m.fitted};
                 },
                 "standard errors of the coefficients, RMS-normalised waves; all null if the frame "
                 "was measured by the positions of its spots only")};
};

/// Shape of a binary part: rows, columns.
using Shape = std::array<int, 2>;
inline constexpr const char* kDtypeMeaning = "NumPy dtype of the binary part, little-endian";
inline constexpr auto kFloats = constant("dtype", "<f4", kDtypeMeaning);

template <>
struct Table<SpotsMessage> {
  using M = SpotsMessage;
  static constexpr const char* kName = "Spots";
  static constexpr std::array<std::string_view, 6> kColumns{"x",     "y",    "ref_x",
                                                            "ref_y", "peak", "quality"};
  static constexpr std::array<std::string_view, 6> kColumnUnits{"px", "px", "px", "px", "DN", "1"};
  static constexpr auto kFields = Fields{
      constant("schema", "ovws.spots/1", "schema and version of this message"),
      based<FrameMessage>(),
      computed<M>(
          "shape",
          [](const M& m) {
            return Shape{int(m.spots.size()), int(kColumns.size())};
          },
          "shape of the binary part: [N, 6]"),
      kFloats,
      computed<M>(
          "columns", [](const M&) { return kColumns; },
          "x, y: spot position; ref_x, ref_y: reference position, both in camera pixels of the "
          "region of interest; peak: brightest pixel; quality: contrast; NaN: lost spot or no "
          "reference"),
      computed<M>(
          "column_units", [](const M&) { return kColumnUnits; },
          "units of the columns: camera pixels; camera grey levels; 1 for quality, 0 to 1")};
};

template <>
struct Table<ImageMessage> {
  using M = ImageMessage;
  static constexpr const char* kName = "Image";
  static constexpr auto kFields = Fields{
      constant("schema", "ovws.image/1", "schema and version of this message"),
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
          "shape of the binary part: [rows, columns]"),
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
                  "significant bits of each pixel, LSB-aligned", {8, 16})};
};

template <>
struct Table<PhaseMessage> {
  using M = PhaseMessage;
  static constexpr const char* kName = "Phase";
  static constexpr auto kFields = Fields{
      constant("schema", "ovws.phase/1", "schema and version of this message"),
      field("seq", &M::seq, kSeqMeaning),
      field("frame_id", &M::frame_id, kFrameIdMeaning),
      field("t_arrival_ns", &M::t_arrival_ns, kArrivalMeaning),
      field("hologram_id", &M::hologram_id, kFrameHologramMeaning),
      kOrientation,
      field("valid", &M::valid, "whether the wavefront that it shows is valid"),
      kUnit,
      field("wavelength_nm", &M::wavelength_nm, "wavelength, nanometres", limits::kWavelengthNm),
      computed<M>(
          "shape",
          [](const M& m) {
            return Shape{m.waves->height, m.waves->width};
          },
          "shape of the binary part: [rows, columns]"),
      kFloats};
};

template <>
struct Table<RefinedMessage> {
  using M = RefinedMessage;
  static constexpr const char* kName = "Refined";
  static std::optional<double> rms_waves(const M& m);
  static Json rules();
  static constexpr auto kFields = Fields{
      constant("schema", "ovws.refined/1", "schema and version of this message"),
      field("seq", &M::seq, kSeqMeaning),
      field("frame_id", &M::frame_id, "camera's frame number, as in wavefront"),
      field("t_arrival_ns", &M::t_arrival_ns, kArrivalMeaning),
      field("t_publish_ns", &M::t_publish_ns, kPublishMeaning),
      field("hologram_id", &M::hologram_id,
            "number of the hologram on the SLM during the whole exposure of this frame, whatever "
            "is shown now"),
      field("charge", &M::charge, "topological charge of this frame's hologram", limits::kCharge),
      field("valid", &M::valid,
            "true only if the fit found a minimum, there was enough light to determine the modes, "
            "and the model explains the pixels"),
      computed<M>(
          "reason", [](const M& m) { return m.valid ? std::string() : m.reason; },
          "why it is not valid; null if valid")
          .or_null(),
      computed<M>(
          "against", [](const M& m) { return m.against_reference ? "reference" : "model"; },
          "origin of the coefficients: reference, the refined image of the reference; model, the "
          "ideal sensor, if there is no reference")
          .among([] {
            return std::vector<std::string>{"reference", "model"};
          }),
      kUnit,
      field("wavelength_nm", &M::wavelength_nm, "wavelength, nanometres", limits::kWavelengthNm),
      kBasis,
      kOrientation,
      computed<M>(
          "rms_waves", rms_waves,
          "root sum square of the coefficients without piston and tilts, waves; null if not "
          "valid",
          Bounds::at_least(0)),
      field("gain_db", &M::gain_db, "gain of this frame, dB; null: the camera has no gain in dB",
            limits::kGainDb)
          .or_null(),
      field("gain_raw", &M::gain_raw,
            "gain of this frame in device-specific steps; null: the camera has its gain in dB")
          .or_null(),
      field("exposure_us", &M::exposure_us, "exposure time of this frame, microseconds",
            limits::kExposureUs),
      field("j", &M::j, "OSA/ANSI indices of the coefficients, without piston, as in wavefront",
            {1, kMaxZernikeIndex}),
      computed<M>(
          "coefficients",
          [](const M& m) {
            return NumbersOrNull<double>{m.coefficients, m.valid, m.j.size()};
          },
          "present aberration minus the reference, RMS-normalised waves, as many as j; all null if "
          "not valid"),
      computed<M>(
          "sigma",
          [](const M& m) {
            return NumbersOrNull<double>{m.sigma, m.valid, m.j.size()};
          },
          "standard errors of the coefficients, including those of the reference, waves, as many "
          "as j; all null if not valid",
          Bounds::at_least(0)),
      inlined(&M::fit),
      field("duration_ms", &M::duration_ms, "duration of the fit, milliseconds",
            Bounds::at_least(0))};
};

template <>
struct Table<RefinedMessage::Fit> {
  using F = RefinedMessage::Fit;
  static constexpr const char* kName = "RefinedFit";
  static constexpr auto kFields = Fields{
      field("chi2_per_pixel", &F::chi2_per_pixel,
            "chi-squared per pixel with the stated noise: about 1 if the model explains the frame; "
            "null if no minimum was found",
            Bounds::at_least(0)),
      field("peak_e", &F::peak_e, "brightest pixel of the model above the background, electrons"),
      field("background_e", &F::background_e,
            "background of a pixel above the black level, electrons"),
      field("iterations", &F::iterations, "number of iterations of the fit", Bounds::at_least(0))};
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
      Fields{constant("schema", "ovws.event/1", "schema and version of this message"),
             field("seq", &M::seq, kSeqMeaning),
             field("t_ns", &M::t_ns, kTimeMeaning),
             field("kind", &M::kind, "subject of the event: state, camera, slm, job, …"),
             field("severity", &M::severity, "severity of the event"),
             field("text", &M::text, "message for the user, one sentence"),
             field("data", &M::data, "data for programs; its structure depends on the kind")};
};

/// `status` as it is published; `system.status` is the same without `schema` and `seq`.
struct StreamedStatus {
  StatusMessage status;
};
template <>
struct Table<StreamedStatus> {
  static constexpr const char* kName = "StreamedStatus";
  static constexpr auto kFields = Fields{
      constant("schema", "ovws.status/1", "schema and version of this message"),
      computed<StreamedStatus>(
          "seq", [](const StreamedStatus& streamed) { return streamed.status.seq; }, kSeqMeaning),
      inlined(&StreamedStatus::status)};
};

}  // namespace ovws
