#include "daemon/ovwsd/record/plan_facts.hpp"

#include <utility>

#include "daemon/ovwsd/library/calibration.hpp"
#include "daemon/ovwsd/library/reference.hpp"
#include "daemon/ovwsd/library/shapes_file.hpp"
#include "daemon/ovwsd/record/point_document.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"
#include "proto/names.hpp"
#include "proto/tables/camera.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/optics.hpp"
#include "proto/tables/reference.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {
namespace {

using nlohmann::json;

json rows_of(const Eigen::MatrixXd& matrix) {
  json rows = json::array();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    json row = json::array();
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) row.push_back(matrix(r, c));
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Approximate memory of a plan that no other plan shares, bytes. Of the reconstructor, which the
/// plans of one sensor and reference share, it counts only the matrices given to it.
std::size_t bytes_of_plan(const MeasurementPlan& plan) {
  const Reconstructor& positions = *plan.reconstructor;
  const std::size_t points = plan.predicted_px.size() + plan.reference_px.size();
  std::size_t bytes =
      sizeof(MeasurementPlan) + points * sizeof(Vec2) +
      std::size_t(positions.slopes().size() + positions.nuisance().size()) * sizeof(double);
  for (const auto& beam : plan.beams) bytes += bytes_of_plan(*beam);
  for (const auto& pattern : plan.patterns) bytes += bytes_of_plan(*pattern);
  return bytes;
}

json operator_content(const MeasurementPlan& plan) {
  const Reconstructor& positions = *plan.reconstructor;
  json content{{"operator", wire_name(plan.mode_operator)},
               {"j", positions.modes_j()},
               {"px_per_wave", rows_of(positions.slopes())}};
  if (positions.nuisance().cols() > 0) content["nuisance_px"] = rows_of(positions.nuisance());
  return content;
}

json slm_content(const ActiveSlm& slm) {
  json flatness;
  if (slm.flatness) flatness = to_json(slm.flatness->modes);
  return {{"identity", slm.identity},
          {"grey_levels", slm.hologram.lut},
          {"flatness_modes", std::move(flatness)}};
}

/// Size of each spot's charge; empty: all are of one kind.
json charges_of(const SpotKinds* kinds) {
  json charges = json::array();
  if (kinds == nullptr) return charges;
  for (const int kind : kinds->of_spots()) charges.push_back(kinds->model(kind).charge);
  return charges;
}

json region_content(const std::optional<Disc>& region) {
  if (!region) return nullptr;
  return {{"x", region->centre.x}, {"y", region->centre.y}, {"radius", region->radius}};
}

/// How a plan measures its own light source.
json source_content(const MeasurementPlan& plan, const SensorSnapshot& now) {
  return {{"plan_id", plan.id},
          {"sensor_epoch", plan.sensor_epoch},
          {"hologram_id", plan.hologram_id},
          {"correction", to_json(plan.correction)},
          {"charge", plan.charge},
          {"charges", charges_of(plan.kinds.get())},
          {"tracker", tracker_name(plan.tracker_kind)},
          {"kernel_radius", now.tracking.kernel_radius},
          {"lambda_d_px", plan.spots.lambda_d_px},
          {"lit", lit_content(plan.spots.lit)},
          {"roi", to_json(plan.roi)},
          {"pixel_format", pixel_format_name(plan.format)},
          {"predicted_px", to_json(plan.predicted_px)},
          {"reference_px", to_json(plan.reference_px)},
          {"reference_introduced_rms_waves", plan.reference_introduced_rms_waves},
          {"awaits_templates", plan.awaits_templates},
          {"can_fit_shapes", plan.can_fit_shapes},
          {"modes_j", plan.modes_j},
          {"beam", plan.beam},
          {"region", region_content(plan.region)}};
}

json plan_content(const PlanFacts& facts) {
  const SensorSnapshot& now = *facts.sensor;
  json content = source_content(facts.plan, now);
  content["pattern"] = wire_name(now.pattern);
  content["sensor"] = to_json(now.sensor);
  content["optics"] = to_json(now.optics);
  content["registration"] = to_json(KnownRegistration{now.registration});
  content["aberration"] = to_json(now.aberration);
  content["beams"] = json::array();
  for (const auto& beam : facts.plan.beams) content["beams"].push_back(source_content(*beam, now));
  return content;
}

}  // namespace

PlanFacts::PlanFacts(const MeasurementPlan& of, SensorView view)
    : plan(of),
      point(of.fit ? std::optional(of.fit->point()) : std::nullopt),
      sensor(std::move(view)) {
  plan.fit = nullptr;
}

std::size_t bytes_of(const PlanFacts& facts) {
  return bytes_of_plan(facts.plan) + sizeof(SensorSnapshot) +
         facts.sensor->sensor.lenslets.centres_px.size() * sizeof(Vec2);
}

Document make_document(std::string kind, const json& content) {
  // Use json_text: a camera's name may contain bytes that are not UTF-8.
  Document document{std::move(kind), json_text(content), {}};
  document.sha256 = sha256_hex(document.text);
  return document;
}

/// Returns the SHA-256 of the reference's document. Adds the document to `all` unless it was the
/// last reference added. A closed loop makes ten plans a second with one reference, whose image
/// takes a megabyte.
const std::string& PlanDocuments::reference_of(const std::shared_ptr<const Reference>& reference,
                                               std::vector<Document>& all) {
  const bool same = reference_ && reference_->t_taken_ns == reference->t_taken_ns &&
                    reference_->picture == reference->picture &&
                    reference_->positions_px == reference->positions_px;
  if (same) return reference_sha256_;
  all.push_back(make_document("reference", reference_content(*reference)));
  reference_ = reference;
  return reference_sha256_ = all.back().sha256;
}

/// Returns the SHA-256 of the calibration's document. Adds the document to `all` unless it was the
/// last calibration added, because its shapes take megabytes.
const std::string& PlanDocuments::calibration_of(
    const std::shared_ptr<const Calibration>& calibration, std::vector<Document>& all) {
  if (calibration_ && calibration_->t_taken_ns == calibration->t_taken_ns) {
    return calibration_sha256_;
  }
  all.push_back(make_document("calibration", calibration_content(*calibration)));
  calibration_ = calibration;
  return calibration_sha256_ = all.back().sha256;
}

std::vector<Document> PlanDocuments::of(const PlanFacts& facts) {
  std::vector<Document> all;
  json plan = plan_content(facts);
  const auto refer = [&](json& from, const char* kind, const json& content) {
    all.push_back(make_document(kind, content));
    from[kind] = all.back().sha256;
  };
  const SensorSnapshot& now = *facts.sensor;
  plan["reference"] = plan["calibration"] = plan["slm"] = plan["operating_point"] = nullptr;
  if (now.reference) plan["reference"] = reference_of(now.reference, all);
  refer(plan, "operator", operator_content(facts.plan));
  for (std::size_t k = 0; k < facts.plan.beams.size(); ++k) {
    refer(plan["beams"][k], "operator", operator_content(*facts.plan.beams[k]));
  }
  if (now.calibration) plan["calibration"] = calibration_of(now.calibration, all);
  if (now.slm) refer(plan, "slm", slm_content(*now.slm));
  std::erase_if(all, [&](const Document& one) { return !given_.insert(one.sha256).second; });
  if (facts.point) {
    Document point = make_document(
        "operating_point", point_content(*facts.point, facts.plan.modes_j, now, facts.plan.roi));
    plan[point.kind] = point.sha256;
    if (std::exchange(point_sha256_, point.sha256) != point.sha256) all.push_back(std::move(point));
  }
  all.push_back(make_document("plan", plan));
  return all;
}

}  // namespace ovws
