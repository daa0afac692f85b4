#include "daemon/ovwsd/record/recorded_plan.hpp"

#include <algorithm>
#include <exception>
#include <nlohmann/json.hpp>

#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/library/shapes_file.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"
#include "proto/names.hpp"
#include "proto/tables/optics.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr int kMaxSide = 1 << 16;

tl::unexpected<Error> unfit(const std::string& reason) {
  return fail(Errc::invalid, "path", "a plan of the recording " + reason);
}

/// Points from JSON; null is an unknown coordinate, NaN.
std::vector<Vec2> points(const json& all) {
  const auto value = [](const json& number) {
    return number.is_null() ? NAN : number.get<double>();
  };
  std::vector<Vec2> out;
  for (const json& point : all) out.push_back({value(point.at(0)), value(point.at(1))});
  return out;
}

Eigen::MatrixXd matrix(const json& rows, std::size_t columns) {
  Eigen::MatrixXd out(Eigen::Index(rows.size()), Eigen::Index(columns));
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      out(Eigen::Index(r), Eigen::Index(c)) = rows.at(r).at(c).get<double>();
    }
  }
  return out;
}

Roi roi(const json& from) {
  return {from.at("x").get<int>(), from.at("y").get<int>(), from.at("width").get<int>(),
          from.at("height").get<int>()};
}

std::optional<Disc> region(const json& from) {
  if (from.is_null()) return std::nullopt;
  return Disc{{from.at("x").get<double>(), from.at("y").get<double>()},
              from.at("radius").get<double>()};
}

/// The charge of a plan or spot; a number beyond those of all trackers becomes 99, which
/// make_tracker refuses.
int charge_from(const json& value) {
  const double charge = value.get<double>();
  return std::abs(charge) < 99.0 ? int(charge) : 99;
}

SpotModel spot_model(const json& plan) {
  return {charge_from(plan.at("charge")), plan.at("lambda_d_px").get<double>(),
          lit_from(plan.at("lit"))};
}

/// Checks that the parts of a plan are consistent, and within the limits that later code requires.
Result<void> check_operator(const MeasurementPlan& plan, const json& rows,
                            const std::vector<int>& position_modes_j) {
  const std::size_t spots = plan.predicted_px.size();
  const auto as_many = [&](const std::vector<Vec2>& all) {
    return all.empty() || all.size() == spots;
  };
  if (spots == 0 || spots > std::size_t(kMaxSubapertures) || !as_many(plan.reference_px) ||
      rows.size() != 2 * spots) {
    return unfit("has parts with different numbers of spots");
  }
  const std::vector<int>& modes_j = plan.modes_j;
  if (modes_j.empty() || modes_j.size() > std::size_t(kMaxZernikeIndex)) {
    return unfit("has too many modes, or none");
  }
  if (std::any_of(modes_j.begin(), modes_j.end(),
                  [](int j) { return j < 0 || j > kMaxZernikeIndex; })) {
    return unfit("has modes that do not exist");
  }
  if (position_modes_j.empty() || position_modes_j.size() > modes_j.size() ||
      !std::equal(position_modes_j.begin(), position_modes_j.end(), modes_j.begin())) {
    return unfit("has modes that are not those of its operator");
  }
  if (plan.roi.width < 1 || plan.roi.width > kMaxSide || plan.roi.height < 1 ||
      plan.roi.height > kMaxSide || !plan.spots.lit.exist()) {
    return unfit("has an invalid image size or Bayer plane");
  }
  return {};
}

}  // namespace

Result<RecordedPlans> RecordedPlans::of(RecordingReader& reader) {
  auto all = reader.documents();
  if (!all) return fail(all.error());
  RecordedPlans plans;
  for (RecordedText& one : *all) {
    if (sha256_hex(one.text) != one.sha256) {
      return fail(Errc::invalid, "path",
                  "the recording is damaged: the checksum of its \"" + one.kind +
                      "\" document does not match; use an intact copy");
    }
    if (one.kind == "plan") {
      const json plan = json_of(one.text);
      const bool numbered =
          plan.is_object() && plan.contains("plan_id") && plan["plan_id"].is_number_unsigned();
      if (!numbered) return unfit("has no number");
      plans.plans_[plan["plan_id"].get<std::uint64_t>()] = std::move(one.text);
      continue;
    }
    if (one.kind == "configuration" && !plans.configuration_) {
      plans.configuration_ = parse_config(one.text);
    }
    plans.documents_[one.sha256] = std::move(one.text);
  }
  return plans;
}

/// Decodes a plan document of plan_facts.cpp; other content throws a JSON library exception.
Result<std::unique_ptr<MeasurementPlan>> RecordedPlans::read(const json& from) {
  auto plan = read_source(from);
  if (!plan) return plan;
  if (!(*plan)->beam.empty()) return unfit("is that of a further light source");
  auto branch_points = read_branch_points(from, (*plan)->predicted_px.size());
  if (!branch_points) return fail(branch_points.error());
  (*plan)->branch_points = std::move(*branch_points);
  if (auto beams = read_beams(from, **plan); !beams) return fail(beams.error());
  if (auto fit = read_templates(from, **plan); !fit) return fail(fit.error());
  return plan;
}

/// Reads what a plan, or one of its beams, measures its own light source with. All but the branch
/// points and the templates.
Result<std::unique_ptr<MeasurementPlan>> RecordedPlans::read_source(const json& from) {
  auto plan = std::make_unique<MeasurementPlan>();
  plan->id = from.at("plan_id").get<std::uint64_t>();
  plan->sensor_epoch = from.at("sensor_epoch").get<std::uint64_t>();
  plan->hologram_id = from.at("hologram_id").get<std::uint64_t>();
  plan->correction = modes_from(from.at("correction"));
  plan->charge = charge_from(from.at("charge"));
  plan->beam = from.value("beam", std::string());
  plan->region = region(from.value("region", json()));
  plan->can_fit_shapes = from.value("can_fit_shapes", false);
  plan->roi = roi(from.at("roi"));
  const auto format = pixel_format_from_name(from.at("pixel_format").get<std::string>());
  const auto tracker = tracker_from_name(from.at("tracker").get<std::string>());
  if (!format || !tracker)
    return unfit("needs a tracker or pixel format that this program does not have");
  plan->format = *format;
  plan->tracker_kind = *tracker;
  plan->spots = spot_model(from);
  plan->predicted_px = points(from.at("predicted_px"));
  plan->reference_px = points(from.at("reference_px"));
  plan->awaits_templates = from.value("awaits_templates", false);
  plan->reference_introduced_rms_waves = from.value("reference_introduced_rms_waves", 0.0);
  if (auto read = read_operator(from, *plan); !read) return fail(read.error());
  const TrackingConfig tracking{*tracker, from.at("kernel_radius").get<double>()};
  auto made = make_tracker(tracking, plan->spots);
  if (!made) return fail(made.error());
  plan->tracker = std::move(*made);
  std::vector<int> charges;
  for (const json& one : from.value("charges", json::array())) charges.push_back(charge_from(one));
  if (!charges.empty() && charges.size() != plan->predicted_px.size()) {
    return unfit("has charges of other spots");
  }
  auto kinds = SpotKinds::make(tracking, plan->spots, charges);
  if (!kinds) return fail(kinds.error());
  plan->kinds = std::move(*kinds);
  return plan;
}

/// Reads the modes, and the matrix by which spot positions determine the first of them.
Result<void> RecordedPlans::read_operator(const json& from, MeasurementPlan& plan) {
  const json op = json_of(documents_.at(from.at("operator").get<std::string>()));
  const auto& kinds = kNames<OperatorKind>();
  const auto kind = std::ranges::find(kinds, op.at("operator").get<std::string>());
  if (kind == kinds.end()) return unfit("has an operator that this program does not have");
  plan.mode_operator = OperatorKind(kind - kinds.begin());
  const auto position_modes_j = op.at("j").get<std::vector<int>>();
  plan.modes_j = from.value("modes_j", position_modes_j);
  if (auto fits = check_operator(plan, op.at("px_per_wave"), position_modes_j); !fits) return fits;
  const json nuisance = op.value("nuisance_px", json::array());
  if (!nuisance.empty() && nuisance.size() != op.at("px_per_wave").size()) {
    return unfit("has different numbers of rows in nuisance_px and px_per_wave");
  }
  plan.reconstructor = std::make_unique<Reconstructor>(
      matrix(op.at("px_per_wave"), position_modes_j.size()), position_modes_j, plan.reference_px,
      matrix(nuisance, nuisance.empty() ? 0 : nuisance.at(0).size()));
  return {};
}

/// Reads the plans of the further light sources.
Result<void> RecordedPlans::read_beams(const json& from, MeasurementPlan& plan) {
  for (const json& source : from.value("beams", json::array())) {
    auto beam = read_source(source);
    if (!beam) return fail(beam.error());
    (*beam)->branch_points = plan.branch_points;  // of the same lattice
    if ((*beam)->beam.empty() || !((*beam)->roi == plan.roi) ||
        (*beam)->sensor_epoch != plan.sensor_epoch ||
        (*beam)->predicted_px.size() != plan.predicted_px.size()) {
      return unfit("has a further light source that is not of its sensor");
    }
    plan.beams.push_back(std::move(*beam));
  }
  if (plan.beams.size() > std::size_t(kMaxBeams)) return unfit("has too many light sources");
  return {};
}

/// Makes the branch points' loops of the lattice that the plan's sensor has.
Result<std::shared_ptr<const BranchPoints>> RecordedPlans::read_branch_points(
    const json& from, std::size_t spots) const {
  const auto config = configuration();
  if (!config) return fail(config.error());
  auto sensor = decode<SensorConfig>(from.at("sensor"));
  if (!sensor) return fail(sensor.error());
  sensor->masks.clear();  // they move no subaperture, and their files may be elsewhere
  const auto optics = decode<OpticsConfig>(from.at("optics"));
  if (!optics) return fail(optics.error());
  const SlmGeometry& slm = config->slm.geometry;
  const auto lattice = make_lattice(*sensor, slm);
  if (!lattice) return fail(lattice.error());
  if (lattice->subapertures.size() != spots) return unfit("has spots of another lattice");
  return std::make_shared<const BranchPoints>(*lattice, 0.5 * sensor->pupil_diameter_px,
                                              px_per_cycle(*optics, slm));
}

/// Renders the templates of the plan, if it has an operating point.
Result<void> RecordedPlans::read_templates(const json& from, MeasurementPlan& plan) {
  const json point = from.value("operating_point", json());
  if (point.is_null()) return {};
  const json calibrated = from.value("calibration", json());
  const std::string sha256 = calibrated.is_string() ? calibrated.get<std::string>() : "";
  const std::string key = point.dump();
  const bool of_other_shapes = fit_ && !fit_calibration_.empty() && sha256 != fit_calibration_;
  if (key != fit_key_ || of_other_shapes || !fit_ || fit_->modes_j() != plan.modes_j ||
      !(fit_roi_ == plan.roi) || fit_lit_ != plan.spots.lit) {
    const json content = json_of(documents_.at(point.get<std::string>()));
    auto fit =
        points_.read(content, plan, {sha256, [&] { return json_of(documents_.at(sha256)); }});
    if (!fit) return fail(fit.error());
    fit_ = std::move(*fit);
    fit_key_ = key;
    const bool calibrate = fit_->point().measured || !fit_->point().corrected_at.empty();
    fit_calibration_ = calibrate ? sha256 : "";
    fit_roi_ = plan.roi;
    fit_lit_ = plan.spots.lit;
  }
  if (int(fit_->point().levels_dn.size()) != plan.subapertures()) {
    return unfit("has templates for other spots");
  }
  plan.fit = fit_;
  return {};
}

Result<std::unique_ptr<MeasurementPlan>> RecordedPlans::make(std::uint64_t plan_id) {
  const auto found = plans_.find(plan_id);
  if (found == plans_.end()) return unfit("is missing: number " + std::to_string(plan_id));
  try {
    return read(json_of(found->second));
  } catch (const std::exception& error) {  // from the JSON library, or for a missing document
    return unfit(std::string("cannot be read: ") + error.what());
  }
}

}  // namespace ovws
