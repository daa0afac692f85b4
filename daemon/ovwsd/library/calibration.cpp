#include "daemon/ovwsd/library/calibration.hpp"

#include <algorithm>
#include <cmath>

#include "core/wavefront/reconstructor.hpp"
#include "daemon/ovwsd/library/origin.hpp"
#include "daemon/ovwsd/library/shapes_file.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/tables/calibration.hpp"
#include "proto/tables/time.hpp"

namespace ovws {
namespace {

constexpr int kMaxCalibratedSpots = 1 << 12;

/// A calibration's file. Matrices are float32 in base64, column by column; the conversion is exact,
/// because interaction_matrix already rounds all values to floats.
struct CalibrationFile {
  Calibration calibration;
  int spots = 0;
  std::string slopes, standard_error;
  std::shared_ptr<const Json> shapes;
};

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

}  // namespace

template <>
inline constexpr auto kTable<InteractionMatrix> =
    Fields{"MatrixFile",
           field<&InteractionMatrix::source>("run: measured by the daemon; set: given"),
           field("amplitudes_waves", &InteractionMatrix::amplitude_waves, "pokes of the modes",
                 {0.0, limits::kGivenPokeWaves.max})
               .sized(0, kMaxZernikeIndex)
               .mandatory(),
           field<&InteractionMatrix::modes_j>("modes", {1, kMaxZernikeIndex})
               .sized(0, kMaxZernikeIndex)
               .unlike()
               .mandatory(),
           field<&InteractionMatrix::lost_spots>("lost spots", {0, kMaxCalibratedSpots - 1})
               .sized(0, kMaxCalibratedSpots)
               .unlike()
               .mandatory(),
           field<&InteractionMatrix::dropped>("modes without a column")
               .sized(0, kMaxZernikeIndex)
               .mandatory(),
           field<&InteractionMatrix::drift_px>("drift, camera pixels", {0.0, 1e6}).mandatory(),
           field<&InteractionMatrix::drift_noise_px>("noise of drift_px", {0.0, 1e6}).mandatory()};

template <>
inline constexpr auto kTable<Calibration> = Fields{
    "Calibration",
    inlined(&Calibration::matrix),
    field<&Calibration::frames>("averaged frames", limits::kPokeFrames).mandatory(),
    field<&Calibration::t_taken_ns>(kTimeMeaning).mandatory(),
    time_text("t_taken", &Calibration::t_taken_ns),
    field<&Calibration::amplitude_waves>("requested poke", limits::kGivenPokeWaves).mandatory(),
    field<&Calibration::origin>("bench and settings").mandatory()};

template <>
inline constexpr auto kTable<CalibrationFile> =
    Fields{"CalibrationFile",
           inlined(&CalibrationFile::calibration),
           field<&CalibrationFile::spots>("number of spots", {1, kMaxCalibratedSpots}).mandatory(),
           field<&CalibrationFile::slopes>("poke matrix").mandatory(),
           field<&CalibrationFile::standard_error>("standard errors of slopes").mandatory(),
           field<&CalibrationFile::shapes>("measured shapes of the spots; null: none")};

template <>
struct Rules<CalibrationFile> {
  static void check(const CalibrationFile& file, ObjectReader& reader) {
    const InteractionMatrix& matrix = file.calibration.matrix;
    if (matrix.amplitude_waves.size() != matrix.modes_j.size()) {
      return reader.fault("amplitudes_waves", "must have one value for each mode");
    }
    const auto exists = [&file](int spot) { return spot < file.spots; };
    if (!std::ranges::all_of(matrix.lost_spots, exists)) {
      reader.fault("lost_spots", "must be numbers of existing spots");
    }
  }
};

ModeOperator mode_operator_of(const MeasuredCalibration& measured) {
  const InteractionMatrix& matrix = measured.matrix;
  return {OperatorKind::measured, matrix.modes_j, matrix.slopes, measured.shapes};
}

nlohmann::json calibration_content(const Calibration& calibration) {
  const InteractionMatrix& matrix = calibration.matrix;
  CalibrationFile file{calibration, matrix.spots(), matrix_text(matrix.slopes),
                       matrix_text(matrix.standard_error), nullptr};
  if (calibration.shapes) {
    file.shapes = std::make_shared<const Json>(shapes_content(*calibration.shapes));
  }
  return to_json(file);
}

Result<Calibration> calibration_from(const nlohmann::json& content) {
  auto file = decode<CalibrationFile>(content);
  if (!file) return fail(file.error());
  Calibration& calibration = file->calibration;
  InteractionMatrix& matrix = calibration.matrix;
  const Eigen::Index rows = 2 * file->spots, cols = Eigen::Index(matrix.modes_j.size());
  auto slopes = matrix_from("slopes", file->slopes, rows, cols);
  if (!slopes) return fail(slopes.error());
  auto error = matrix_from("standard_error", file->standard_error, rows, cols);
  if (!error) return fail(error.error());
  if (cols == 0 || determined_modes(*slopes) != int(cols)) {
    return fail(Errc::invalid, "slopes", "do not determine the modes");
  }
  matrix.slopes = std::move(*slopes);
  matrix.standard_error = std::move(*error);
  if (file->shapes) {
    auto shapes = shapes_from(*file->shapes, file->spots, matrix.modes_j);
    if (!shapes) return fail(shapes.error());
    calibration.shapes = std::make_shared<const MeasuredShapes>(std::move(*shapes));
  }
  auto parsed = parse_origin(*calibration.origin);
  if (!parsed) return fail(parsed.error());
  calibration.key = std::move(parsed->key);
  calibration.mode_operator = mode_operator_of(calibration);
  return std::move(calibration);
}

}  // namespace ovws
