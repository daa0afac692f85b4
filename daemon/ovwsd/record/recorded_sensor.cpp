/// The sensor's settings and reference from the documents of a recording, for refinement.
#include <exception>
#include <nlohmann/json.hpp>

#include "daemon/ovwsd/library/reference.hpp"
#include "daemon/ovwsd/record/recorded_plan.hpp"
#include "daemon/shared/slm_files.hpp"
#include "proto/json_text.hpp"
#include "proto/tables/optics.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {
namespace {

using nlohmann::json;

tl::unexpected<Error> unreadable(const std::string& what) {
  return fail(Errc::invalid, "path", "the recording's " + what);
}

}  // namespace

Result<Config> RecordedPlans::configuration() const {
  if (!configuration_) return unreadable("configuration is missing");
  const Result<Config>& config = *configuration_;
  if (!config) return unreadable("configuration cannot be read: " + text_of(config.error()));
  return config;
}

Result<SensorView> RecordedPlans::sensor(std::uint64_t plan_id, const MeasurementPlan& plan) {
  if (sensor_ && sensor_plan_ == plan_id) return sensor_;
  try {
    auto read = read_sensor(json_of(plans_.at(plan_id)), plan);
    if (!read) return read;
    sensor_ = std::move(*read);
  } catch (const std::exception& error) {  // from the JSON library, or for a missing document
    return unreadable(std::string("plan cannot be read: ") + error.what());
  }
  sensor_plan_ = plan_id;
  return sensor_;
}

Result<SensorView> RecordedPlans::read_sensor(const json& from, const MeasurementPlan& plan) {
  const auto config = configuration();
  if (!config) return fail(config.error());
  auto sensor = decode<SensorConfig>(from.at("sensor"));
  if (!sensor) return fail(sensor.error());
  if (auto read = load_masks(*sensor); !read) return fail(read.error());
  const auto optics = decode<OpticsConfig>(from.at("optics"));
  if (!optics) return fail(optics.error());
  auto view = std::make_shared<SensorSnapshot>();
  view->sensor = *sensor;
  view->tracking = config->tracking;
  view->tracking.tracker = plan.tracker_kind;
  view->tracking.kernel_radius = from.at("kernel_radius").get<double>();
  view->optics = *optics;
  view->aberration = modes_from(from.at("aberration"));
  view->correction = modes_from(from.at("correction"));
  view->modes_j = plan.modes_j;
  view->position_modes_j = plan.reconstructor->modes_j();
  const json& reference = from.at("reference");
  if (reference.is_string()) {
    auto read = read_reference(reference.get<std::string>());
    if (!read) return fail(read.error());
    view->reference = std::move(*read);
  }
  return view;
}

/// Reads a reference, unless it is the last one: its image takes a megabyte.
Result<std::shared_ptr<const Reference>> RecordedPlans::read_reference(const std::string& sha256) {
  if (reference_ && reference_sha256_ == sha256) return reference_;
  auto read = reference_from(json_of(documents_.at(sha256)));
  if (!read) return unreadable("reference cannot be read: " + text_of(read.error()));
  reference_ = std::make_shared<const Reference>(std::move(*read));
  reference_sha256_ = sha256;
  return reference_;
}

}  // namespace ovws
