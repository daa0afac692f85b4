/// Values of computed fields that take more than one line.
#include <array>
#include <cmath>
#include <ctime>

#include "core/base/decompositions.hpp"
#include "proto/rpc.hpp"
#include "proto/tables/calibration.hpp"
#include "proto/tables/job.hpp"
#include "proto/tables/record.hpp"
#include "proto/tables/slm.hpp"
#include "proto/tables/streams.hpp"

namespace ovws {
namespace {

std::string milliseconds(double ms) {
  const long tenths = std::lround(10.0 * ms);
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " ms";
}

}  // namespace

std::string utc_text(std::int64_t t_ns) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::time_t seconds = t_ns / kSecond;
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &utc);
  const std::string milliseconds = std::to_string(1000 + t_ns % kSecond / 1'000'000);
  return text.data() + ("." + milliseconds.substr(1)) + "Z";
}

std::string settle_reason(const SettleReport& report) {
  const SettleTime& time = report.time;
  if (report.configured_ms < time.max_ms) {
    return "slm.settle_ms is " + milliseconds(report.configured_ms) +
           ", but the image is stable only after " + milliseconds(time.max_ms) +
           ": frames count as settled too early; set slm.settle_ms to " +
           std::to_string(std::lround(time.proposed_ms));
  }
  if (report.configured_ms < time.worst_ms) {
    return std::to_string(time.outliers) + " changes took up to " + milliseconds(time.worst_ms) +
           ", longer than slm.settle_ms (" + milliseconds(report.configured_ms) +
           "): unless this machine was busy, the SLM's controller is sometimes slower; measure "
           "again, and if it recurs set slm.settle_ms above it";
  }
  return {};
}

std::optional<ErrorReport> job_error(const JobReport& job) {
  if (!job.error) return std::nullopt;
  RpcFailure failure = rpc_failure(*job.error);
  return ErrorReport{int(failure.code), std::move(failure.message), {std::move(failure.data)}};
}

std::optional<std::string> not_plain(const std::optional<std::string>& given) {
  if (!given) return std::nullopt;
  const std::string& name = *given;
  const auto is_letter = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
  };
  const bool plain = !name.empty() && name.size() <= limits::kRecordName && is_letter(name[0]) &&
                     std::all_of(name.begin(), name.end(), [&](char c) {
                       return is_letter(c) || c == '.' || c == '_' || c == '-';
                     });
  if (plain) return std::nullopt;
  return "must be a plain name of at most 100 letters, digits, '.', '_' and '-', the first a "
         "letter or a digit; the folder is set by record.directory";
}

namespace {

/// Schema fragment: "type" of the properties `values`, and of the elements of the arrays
/// `elements`.
Json types(std::initializer_list<std::pair<const char*, const char*>> values,
           std::initializer_list<std::pair<const char*, const char*>> elements) {
  Json properties = Json::object();
  for (const auto& [key, type] : values) properties[key] = {{"type", type}};
  for (const auto& [key, type] : elements) properties[key] = {{"items", {{"type", type}}}};
  return {{"properties", std::move(properties)}};
}

Json if_valid(Json then, Json otherwise) {
  return {{"if", {{"properties", {{"valid", {{"const", true}}}}}}},
          {"then", std::move(then)},
          {"else", std::move(otherwise)}};
}

}  // namespace

Json Rules<WavefrontMessage>::schema() {
  return if_valid(types({}, {{"coefficients", "number"}}),
                  types({{"rms_waves", "null"}}, {{"coefficients", "null"}}));
}

Json Rules<RefinedMessage>::schema() {
  return if_valid(types({{"reason", "null"}, {"chi2_per_pixel", "number"}},
                        {{"coefficients", "number"}, {"sigma", "number"}}),
                  types({{"reason", "string"}}, {{"coefficients", "null"}, {"sigma", "null"}}));
}

std::vector<CalibratedMode> calibrated_modes(const CalibrationReport& report) {
  const InteractionMatrix& matrix = report.matrix;
  const int found = matrix.spots() - int(matrix.lost_spots.size());
  const double by = 1.0 / std::sqrt(2.0 * std::max(1, found));
  std::vector<CalibratedMode> modes;
  for (std::size_t k = 0; k < matrix.modes_j.size(); ++k) {
    const auto column = Eigen::Index(k);
    CalibratedMode mode{matrix.modes_j[k],
                        matrix.amplitude_waves[k],
                        by * matrix.slopes.col(column).norm(),
                        by * matrix.standard_error.col(column).norm(),
                        {},
                        {},
                        {}};
    for (const ModeComparison& one : report.comparison.modes) {
      if (one.j != mode.j) continue;
      mode.factor = one.factor;
      mode.factor_standard_error = one.factor_standard_error;
      mode.correlation = one.correlation;
    }
    modes.push_back(mode);
  }
  return modes;
}

std::vector<double> singular_values_of(const CalibrationReport& report) {
  const Eigen::VectorXd values = singular_values(report.matrix.slopes);
  return {values.begin(), values.end()};
}

}  // namespace ovws
