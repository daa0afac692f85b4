/// What a frame's numbers depend on, as it is written beside them: one JSON text a thing, told
/// apart by its checksum.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/pipeline/plan.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// Of one plan: copies, for the plan itself may be gone when they are written.
struct PlanFacts {
  PlanFacts(const MeasurementPlan& plan, SensorView view);

  std::uint64_t id = 0, sensor_epoch = 0, hologram_id = 0;
  int charge = 1;
  TrackerKind tracker_kind = TrackerKind::lg;
  SpotModel spots;
  Roi roi;
  PixelFormat format = PixelFormat::mono8;
  std::vector<Vec2> predicted_px, search_px, reference_px;
  double reference_introduced_rms_waves = 0.0;
  OperatorKind mode_operator = OperatorKind::slopes;
  std::vector<int> modes_j;
  Eigen::MatrixXd slopes;
  SensorView sensor;         ///< as it was when the plan was adopted
  Eigen::MatrixXd nuisance;  ///< see Reconstructor
};

struct Document {
  std::string kind;  ///< see RECORDING.md
  std::string text;
  std::string sha256;  ///< of the text
};
Document make_document(std::string kind, const nlohmann::json& content);

/// Of one recording. One thread.
class PlanDocuments {
 public:
  /// Those that were not given before, the plan's own last; it refers to the others by their
  /// checksums. The first with a reference's picture takes a tenth of a second.
  std::vector<Document> of(const PlanFacts& facts);

 private:
  const std::string& reference_of(const std::shared_ptr<const Reference>& reference,
                                  std::vector<Document>& all);

  std::set<std::string> given_;
  std::shared_ptr<const Reference> reference_;  ///< that was written last
  std::string reference_sha256_;
};

}  // namespace ovws
