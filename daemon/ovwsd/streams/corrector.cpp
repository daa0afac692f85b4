#include "daemon/ovwsd/streams/corrector.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr const char* kKind = "corrector";

/// Modes for a message, such as "j = 1 to 4, 7".
std::string listed_modes(const std::vector<int>& modes_j) {
  std::string text = "j = ";
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    const std::size_t first = k;
    while (k + 1 < modes_j.size() && modes_j[k + 1] == modes_j[k] + 1) ++k;
    if (first > 0) text += ", ";
    text += std::to_string(modes_j[first]);
    if (k > first) text += fmt::format(" to {}", modes_j[k]);
  }
  return text;
}

std::string misfit(const CorrectorMatrix& matrix, const std::vector<int>& modes_j) {
  if (matrix.modes_j == modes_j) return {};
  return fmt::format(
      "the corrector's matrix is for the modes {}, but the sensor now measures {}: set another one "
      "with corrector.set, or restore the sensor's settings",
      listed_modes(matrix.modes_j), listed_modes(modes_j));
}

}  // namespace

Result<void> Corrector::set(const CorrectorSet& given, const std::string& bytes,
                            std::vector<int> modes_j) {
  if (given.shape[1] != int(modes_j.size())) {
    return fail(Errc::invalid, "shape",
                fmt::format("has {} modes, but the sensor measures {}: give a column for each of "
                            "modes_j, see sensor.get",
                            given.shape[1], modes_j.size()));
  }
  auto matrix = std::make_shared<CorrectorMatrix>();
  matrix->values.resize(std::size_t(given.shape[0]) * modes_j.size());
  const std::size_t due = sizeof(float) * matrix->values.size();
  if (bytes.size() != due) {
    return fail(
        Errc::invalid, "matrix",
        fmt::format("the binary frame after the JSON has {} bytes, but shape needs {}: send "
                    "the matrix as float32, by rows",
                    bytes.size(), due));
  }
  std::memcpy(matrix->values.data(), bytes.data(), due);
  // Larger values could make infinite commands.
  const auto is_finite = [](float value) { return std::abs(value) <= 1e30F; };
  const auto bad = std::find_if_not(matrix->values.begin(), matrix->values.end(), is_finite);
  if (bad != matrix->values.end()) {
    return fail(Errc::invalid, "matrix",
                fmt::format("the value of actuator {} is {}: give numbers from -1e30 to 1e30",
                            std::size_t(bad - matrix->values.begin()) / modes_j.size(), *bad));
  }
  matrix->number = ++sets_;
  matrix->actuators = given.shape[0];
  matrix->t_set_ns = utc_ns();
  matrix->modes_j = std::move(modes_j);
  events_.emit(
      kKind, Severity::info,
      fmt::format("frames give commands for {} actuators (corrector.set)", matrix->actuators),
      {{"matrix", matrix->number}, {"actuators", matrix->actuators}, {"active", true}});
  use(std::move(matrix));
  return {};
}

void Corrector::clear() {
  if (known_.get() == nullptr) return;
  use(nullptr);
  events_.emit(kKind, Severity::info, "frames give no commands any more (corrector.clear)",
               {{"matrix", nullptr}, {"active", false}});
}

void Corrector::use(Shared matrix) {
  known_.set(matrix);
  latest_.write(std::move(matrix));
}

KnownCorrector Corrector::report(const std::vector<int>& modes_j) const {
  const Shared matrix = known_.get();
  if (!matrix) {
    KnownCorrector none;
    none.reason = "there is no matrix: give one with corrector.set";
    return none;
  }
  return {matrix->number, matrix->actuators, matrix->modes_j, matrix->t_set_ns,
          misfit(*matrix, modes_j)};
}

void Corrector::sensor_changed(const std::vector<int>& modes_j) {
  const Shared matrix = known_.get();
  const bool fitted = matrix && matrix->modes_j == measured_j_;
  measured_j_ = modes_j;
  if (!matrix) return;
  const std::string reason = misfit(*matrix, modes_j);
  if (reason.empty() == fitted) return;
  events_.emit(kKind, fitted ? Severity::warning : Severity::info,
               fitted ? "frames give no commands: " + reason
                      : "frames give commands again: the sensor measures the matrix's modes",
               {{"matrix", matrix->number}, {"active", !fitted}});
}

const CorrectorMatrix* Corrector::matrix() {
  latest_.update();
  return latest_.value().get();
}

std::span<const float> Corrector::commands(const CorrectorMatrix& matrix,
                                           const FrameRecord& record) {
  if (!record.valid || record.pattern >= 0 || record.plan->modes_j != matrix.modes_j) return {};
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto modes = Eigen::Index(matrix.modes_j.size());
  const Eigen::Map<const RowMajor> values(matrix.values.data(), matrix.actuators, modes);
  const Eigen::Map<const Eigen::VectorXf> coefficients(record.coefficients.data(), modes);
  Eigen::Map<Eigen::VectorXf> commands(commands_.data(), matrix.actuators);
  commands.noalias() = values * coefficients;
  return {commands_.data(), std::size_t(matrix.actuators)};
}

}  // namespace ovws
