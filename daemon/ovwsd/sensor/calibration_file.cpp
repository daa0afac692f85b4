#include "daemon/ovwsd/sensor/calibration_file.hpp"

#include <algorithm>
#include <cmath>

#include "core/optics/lattice.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"
#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "daemon/ovwsd/sensor/shapes_file.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"
#include "proto/limits.hpp"
#include "proto/reader.hpp"
#include "proto/tables/calibration.hpp"
#include "proto/tables/time.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr int kMaxCalibratedSpots = 1 << 12;

/// Base64 of the column-major matrix as 32-bit floats. The conversion is exact, because
/// interaction_matrix already rounds all values to floats.
std::string matrix_text(const Eigen::MatrixXd& matrix) {
  const Eigen::MatrixXf values = matrix.cast<float>();
  return base64_of({values.data(), std::size_t(values.size())});
}

Result<Eigen::MatrixXd> matrix_from(const char* key, const std::string& text, Eigen::Index rows,
                                    Eigen::Index cols) {
  const auto values = floats_of(text, std::size_t(rows * cols));
  const auto finite = [](float value) { return std::isfinite(value); };
  if (!values || !std::all_of(values->begin(), values->end(), finite)) {
    return fail(
        Errc::invalid, key,
        "must hold a finite number for each mode and each spot's x and y: the file is damaged");
  }
  return Eigen::MatrixXd(
      Eigen::Map<const Eigen::MatrixXf>(values->data(), rows, cols).cast<double>());
}

Result<void> integers(ObjectReader& reader, const char* key, std::vector<int>& out,
                      std::size_t max_count, int min_value, int max_value) {
  std::vector<double> numbers;
  reader.numbers(key, numbers, 0, max_count, min_value, max_value);
  for (const double number : numbers) {
    const bool again = std::find(out.begin(), out.end(), int(number)) != out.end();
    if (number != std::floor(number) || again) {
      return fail(Errc::invalid, key, "must be distinct integers");
    }
    out.push_back(int(number));
  }
  return {};
}

struct EncodedMatrices {
  std::string slopes, standard_error;
  int spots = 0;
  const json* shapes = nullptr;  ///< null: the file has no shapes
};

/// Reads all fields of a calibration file. Leaves the matrices as base64 text and the origin as
/// unparsed JSON.
Result<EncodedMatrices> read_fields(const json& content, Calibration& calibration) {
  EncodedMatrices encoded;
  std::string t_taken;
  InteractionMatrix& matrix = calibration.matrix;
  ObjectReader r(content, "");
  for (const char* key :
       {"frames", "t_taken_ns", "amplitude_waves", "modes_j", "spots", "lost_spots", "dropped",
        "amplitudes_waves", "drift_px", "drift_noise_px", "slopes", "standard_error", "origin"}) {
    r.require(key);
  }
  r.integer("frames", calibration.frames, limits::kPokeFrames.min, limits::kPokeFrames.max);
  r.string("t_taken", t_taken);
  int source = 0;
  r.choice("source", source, kNames<MatrixSource>());
  matrix.source = MatrixSource(source);
  const json* const t_taken_ns = r.raw("t_taken_ns");
  r.number("amplitude_waves", calibration.amplitude_waves, limits::kGivenPokeWaves.min,
           limits::kGivenPokeWaves.max);
  r.numbers("amplitudes_waves", matrix.amplitude_waves, 0, kMaxZernikeIndex, 0.0,
            limits::kGivenPokeWaves.max);
  r.integer("spots", encoded.spots, 1, kMaxCalibratedSpots);
  auto modes = integers(r, "modes_j", matrix.modes_j, kMaxZernikeIndex, 1, kMaxZernikeIndex);
  auto lost =
      integers(r, "lost_spots", matrix.lost_spots, kMaxCalibratedSpots, 0, kMaxCalibratedSpots - 1);
  r.objects("dropped", kMaxZernikeIndex, [&](ObjectReader& one, std::size_t) {
    DroppedMode dropped;
    one.integer("j", dropped.j, 1, kMaxZernikeIndex);
    one.string("reason", dropped.reason);
    matrix.dropped.push_back(std::move(dropped));
  });
  r.number("drift_px", matrix.drift_px, 0.0, 1e6);
  r.number("drift_noise_px", matrix.drift_noise_px, 0.0, 1e6);
  r.string("slopes", encoded.slopes);
  r.string("standard_error", encoded.standard_error);
  if (r.has("shapes")) encoded.shapes = r.raw("shapes");
  const json* const origin = r.raw("origin");
  if (auto read = r.finish(); !read) return fail(read.error());
  for (const Result<void>* const part : {&modes, &lost}) {
    if (!*part) return fail(part->error());
  }
  if (matrix.amplitude_waves.size() != matrix.modes_j.size()) {
    return fail(Errc::invalid, "amplitudes_waves", "must have one value for each mode");
  }
  for (const int spot : matrix.lost_spots) {
    if (spot >= encoded.spots)
      return fail(Errc::invalid, "lost_spots", "must be numbers of existing spots");
  }
  if (!t_taken_ns->is_number_integer())
    return fail(Errc::invalid, "t_taken_ns", "must be a time in nanoseconds");
  if (!origin->is_object()) return fail(Errc::invalid, "origin", "must be an object");
  calibration.t_taken_ns = t_taken_ns->get<std::int64_t>();
  calibration.origin = std::make_shared<const json>(*origin);
  return encoded;
}

}  // namespace

std::string CalibrationKind::name(const Calibration& calibration) const {
  const json& origin = *calibration.origin;
  return sha256_hex(identity_of(origin) + json_text(origin["registration"])).substr(0, 16);
}

std::string CalibrationKind::obstacle(Calibration& calibration) const {
  const ReferenceKey& key = calibration.key.sensor;
  std::string why =
      bench->obstacle(*calibration.origin, key, std::size_t(calibration.matrix.spots()));
  if (!why.empty()) return why;
  const auto lattice = make_lattice(key.sensor, bench->config().slm.geometry);
  if (!lattice) return lattice.error().reason;
  ModeOperator model =
      slope_operator(*lattice, key.sensor, key.tracking, calibration.key.px_per_cycle);
  if (calibration.shapes) {
    OpticsConfig optics = bench->config().optics;
    optics.registered = calibration.key.px_per_cycle;
    optics.centre_px = calibration.key.base_px - Vec2{double(key.roi.x), double(key.roi.y)};
    auto made = displacement_operator(key.sensor, bench->config().slm.geometry, optics, key.roi,
                                      calibration.shapes->lit(), model.modes_j);
    if (!made) return made.error().reason;
    model = std::move(*made);
  }
  calibration.comparison = compare(calibration.matrix, model);
  return {};
}

json calibration_content(const Calibration& calibration) {
  const InteractionMatrix& matrix = calibration.matrix;
  json dropped = json::array();
  for (const DroppedMode& one : matrix.dropped) {
    dropped.push_back({{"j", one.j}, {"reason", one.reason}});
  }
  return {{"source", kNames<MatrixSource>()[std::size_t(matrix.source)]},
          {"frames", calibration.frames},
          {"t_taken_ns", calibration.t_taken_ns},
          {"t_taken", utc_text(calibration.t_taken_ns)},
          {"amplitude_waves", calibration.amplitude_waves},
          {"amplitudes_waves", matrix.amplitude_waves},
          {"modes_j", matrix.modes_j},
          {"spots", matrix.spots()},
          {"lost_spots", matrix.lost_spots},
          {"dropped", dropped},
          {"drift_px", matrix.drift_px},
          {"drift_noise_px", matrix.drift_noise_px},
          {"slopes", matrix_text(matrix.slopes)},
          {"standard_error", matrix_text(matrix.standard_error)},
          {"shapes", calibration.shapes ? shapes_content(*calibration.shapes) : json()},
          {"origin", *calibration.origin}};
}

Result<Calibration> calibration_from(const json& content, const Config& config) {
  Calibration calibration;
  const auto encoded = read_fields(content, calibration);
  if (!encoded) return fail(encoded.error());
  InteractionMatrix& matrix = calibration.matrix;
  const Eigen::Index rows = 2 * encoded->spots, cols = Eigen::Index(matrix.modes_j.size());
  auto slopes = matrix_from("slopes", encoded->slopes, rows, cols);
  if (!slopes) return fail(slopes.error());
  auto error = matrix_from("standard_error", encoded->standard_error, rows, cols);
  if (!error) return fail(error.error());
  if (cols == 0 || determined_modes(*slopes) != int(cols)) {
    return fail(Errc::invalid, "slopes", "do not determine the modes");
  }
  matrix.slopes = std::move(*slopes);
  matrix.standard_error = std::move(*error);
  if (encoded->shapes != nullptr && !encoded->shapes->is_null()) {
    auto shapes = shapes_from(*encoded->shapes, encoded->spots, matrix.modes_j);
    if (!shapes) return fail(shapes.error());
    calibration.shapes = std::make_shared<const MeasuredShapes>(std::move(*shapes));
  }
  const auto parsed = ReferenceBench::parse(*calibration.origin);
  if (!parsed) return fail(parsed.error());
  calibration.key = calibration_key(parsed->calibrated, config.optics, config.slm.geometry,
                                    parsed->registration, (*calibration.origin)["camera"]);
  calibration.key.slm = calibration.origin->value("slm", json());
  calibration.mode_operator = mode_operator_of(calibration);
  return calibration;
}

}  // namespace ovws
