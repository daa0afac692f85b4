#include "daemon/ovwsd/record/point_document.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "daemon/ovwsd/library/shapes_file.hpp"
#include "daemon/shared/slm_files.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/optics.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr double kMaxWaves = 1000.0;  // limit of a mode; a recording that exceeds it is damaged

/// Field coefficients of each subaperture as JSON: real and imaginary parts in turn.
json numbers(const std::vector<SensorField::LocalField>& fields) {
  json all = json::array();
  for (const SensorField::LocalField& field : fields) {
    json& one = all.emplace_back(json::array());
    for (const std::complex<double>& value : field) {
      one.push_back(value.real());
      one.push_back(value.imag());
    }
  }
  return all;
}

/// Checks an operating point. Errc::invalid, field "path": its parts are inconsistent or out of
/// range.
Result<void> check_point(const OperatingPoint& point, std::size_t modes, std::size_t spots) {
  const auto as_many = [spots](std::size_t count) { return count == 0 || count == spots; };
  const auto moderate = [](double waves) { return std::abs(waves) < kMaxWaves; };
  const auto known = [&](const Mode& mode) {
    return mode.j >= 0 && mode.j <= kMaxZernikeIndex && moderate(mode.waves);
  };
  const bool fits =
      std::all_of(point.fixed.begin(), point.fixed.end(), known) &&
      std::all_of(point.waves.begin(), point.waves.end(), moderate) &&
      point.waves.size() == modes && point.reference_waves.size() == modes &&
      point.fixed.size() <= std::size_t(kMaxZernikeIndex) &&
      std::all_of(point.corrected_at.begin(), point.corrected_at.end(), moderate) &&
      (point.corrected_at.empty() || point.corrected_at.size() == modes) &&
      point.levels_dn.size() == spots && as_many(point.deviations.offsets_px.size()) &&
      as_many(point.deviations.fields.size()) && moderate(point.higher_waves) &&
      point.higher_waves >= 0.0 && point.estimates >= 1 && point.estimates <= kMaxSpotEstimates;
  if (fits) return {};
  return fail(Errc::invalid, "path",
              "the recording is damaged: numbers in its operating point are out of range or do not "
              "belong together; use an intact copy");
}

OperatingPoint point_from(const json& content) {
  OperatingPoint point;
  point.waves = content.at("waves").get<std::vector<double>>();
  point.reference_waves = content.at("reference_waves").get<std::vector<double>>();
  point.fixed = modes_from(content.at("fixed"));
  for (const json& offset : content.at("offsets_px")) {
    point.deviations.offsets_px.push_back({offset.at(0).get<double>(), offset.at(1).get<double>()});
  }
  for (const json& numbers : content.value("fields", json::array())) {
    SensorField::LocalField& field = point.deviations.fields.emplace_back();
    for (std::size_t k = 0; k < field.size(); ++k) {
      field[k] = {numbers.at(2 * k).get<double>(), numbers.at(2 * k + 1).get<double>()};
    }
  }
  point.corrected_at = content.value("corrected_at", std::vector<double>{});
  point.noise.constant_dn2 = content.at("noise_constant_dn2").get<double>();
  point.noise.per_dn = content.at("noise_per_dn").get<double>();
  point.lit = content.at("lit").get<int>();
  point.levels_dn = content.at("levels_dn").get<std::vector<double>>();
  point.ceiling_dn = content.at("ceiling_dn").get<double>();
  point.estimates = content.at("estimates").get<int>();
  point.max_excess = content.at("max_excess").get<double>();
  point.measured = content.value("measured", false);
  point.higher_waves = content.value("higher_waves", 0.0);
  return point;
}

/// Checks that measured spots belong to the frames of a plan.
Result<void> check_shapes(const MeasuredShapes& shapes, const MeasurementPlan& plan) {
  if (shapes.modes_j == plan.modes_j && shapes.lit() == plan.spots.lit &&
      shapes.are_inside(plan.roi.width, plan.roi.height)) {
    return {};
  }
  return fail(Errc::invalid, "path",
              "the recording's calibration does not fit its frames: its modes, its image size or "
              "its colour filters differ");
}

}  // namespace

std::vector<Mode> modes_from(const json& all) {
  std::vector<Mode> modes;
  for (const json& mode : all) {
    modes.push_back({mode.at("j").get<int>(), mode.at("waves").get<double>()});
  }
  return modes;
}

json point_content(const OperatingPoint& point, const std::vector<int>& modes_j,
                   const SensorSnapshot& sensor, const Roi& roi) {
  json model{{"sensor", to_json(sensor.sensor)},
             {"slm", to_json(sensor.slm->hologram.slm)},
             {"optics", to_json(sensor.optics)},
             {"width", roi.width},
             {"height", roi.height},
             {"j", modes_j}};
  return {{"model", std::move(model)},
          {"measured", point.measured},
          {"waves", point.waves},
          {"reference_waves", point.reference_waves},
          {"fixed", to_json(point.fixed)},
          {"offsets_px", to_json(point.deviations.offsets_px)},
          {"fields", numbers(point.deviations.fields)},
          {"corrected_at", point.corrected_at},
          {"noise_constant_dn2", point.noise.constant_dn2},
          {"noise_per_dn", point.noise.per_dn},
          {"lit", point.lit},
          {"levels_dn", point.levels_dn},
          {"ceiling_dn", point.ceiling_dn},
          {"estimates", point.estimates},
          {"max_excess", point.max_excess},
          {"higher_waves", point.higher_waves}};
}

Result<std::shared_ptr<const FrameFit>> PointReader::read(const json& content,
                                                          const MeasurementPlan& plan,
                                                          const CalibrationText& calibration) {
  const std::vector<int>& modes_j = plan.modes_j;
  const json& model = content.at("model");
  const bool is_for = model.at("width").get<int>() == plan.roi.width &&
                      model.at("height").get<int>() == plan.roi.height &&
                      model.at("j").get<std::vector<int>>() == modes_j;
  if (!is_for) {
    return fail(Errc::invalid, "path",
                "the recording's operating point does not fit its frames: its modes or its image "
                "size differ");
  }
  OperatingPoint point = point_from(content);
  const bool calibrated = point.measured || !point.corrected_at.empty();
  if (calibrated) {
    if (auto used = use_shapes(calibration, plan); !used) return fail(used.error());
  }
  if (!point.measured) {
    if (auto used = use_model(content, plan); !used) return fail(used.error());
  }
  const std::size_t spots = calibrated ? shapes_->spots.size() : std::size_t(renderer_->spots());
  if (auto fits = check_point(point, modes_j.size(), spots); !fits) return fail(fits.error());
  if (point.measured) {
    return std::make_shared<const FrameFit>(std::move(point), shapes_->spots, modes_j);
  }
  if (auto used = use_bench(content, point); !used) return fail(used.error());
  const auto rendered = renderer_->render(point.waves, point.fixed);
  return std::make_shared<const FrameFit>(std::move(point), rendered, modes_j);
}

/// Reads the calibration's spots, unless they are those of the last document.
Result<void> PointReader::use_shapes(const CalibrationText& text, const MeasurementPlan& plan) {
  if (!shapes_ || text.sha256 != shapes_sha256_) {
    shapes_.reset();
    const json calibration = text.read();
    const int spots = calibration.at("spots").get<int>();
    const auto leading_j = calibration.at("modes_j").get<std::vector<int>>();
    auto shapes = shapes_from(calibration.at("shapes"), spots, leading_j);
    if (!shapes) {
      return fail(Errc::invalid, "path", "the recording's calibration " + shapes.error().reason);
    }
    shapes_ = std::move(*shapes);
    shapes_sha256_ = text.sha256;
  }
  return check_shapes(*shapes_, plan);
}

/// Gives the renderer the deviations and the correction of a document, unless it has them.
Result<void> PointReader::use_bench(const json& content, const OperatingPoint& point) {
  std::string key = content.at("offsets_px").dump() + content.value("fields", json()).dump();
  const bool corrected = !point.corrected_at.empty();
  if (corrected) key += content.at("corrected_at").dump() + shapes_sha256_;
  if (key == bench_key_) return {};
  bench_key_.clear();
  renderer_->set_deviations(point.deviations);
  if (corrected) {
    auto correction = int(shapes_->spots.size()) == renderer_->spots()
                          ? SpotCorrection::make(*renderer_, *shapes_, point.corrected_at)
                          : std::nullopt;
    if (!correction) {
      return fail(Errc::invalid, "path",
                  "the recording's calibration cannot have corrected its templates: use an intact "
                  "copy");
    }
    renderer_->set_correction(std::move(correction));
  }
  bench_key_ = std::move(key);
  return {};
}

/// Makes the renderer, unless it is that of the last document.
Result<void> PointReader::use_model(const json& content, const MeasurementPlan& plan) {
  const json& model = content.at("model");
  std::string key = model.dump() + lit_content(plan.spots.lit).dump();
  if (renderer_ && key == renderer_key_) return {};
  renderer_.reset();
  bench_key_.clear();
  auto sensor = decode<SensorConfig>(model.at("sensor"));
  if (!sensor) return fail(sensor.error());
  if (auto read = load_masks(*sensor); !read) return fail(read.error());
  const auto slm = decode<SlmGeometry>(model.at("slm"));
  if (!slm) return fail(slm.error());
  const auto optics = decode<OpticsConfig>(model.at("optics"));
  if (!optics) return fail(optics.error());
  auto made =
      SpotRenderer::make(*sensor, *slm, *optics, model.at("width").get<int>(),
                         model.at("height").get<int>(), plan.modes_j, {.lit = plan.spots.lit});
  if (!made) return fail(made.error());
  renderer_ = std::make_unique<SpotRenderer>(std::move(*made));
  renderer_key_ = std::move(key);
  return {};
}

}  // namespace ovws
