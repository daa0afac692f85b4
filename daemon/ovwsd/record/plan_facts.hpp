/// The documents of a recording: the plan, reference, operator, calibration and SLM that a frame
/// was measured with. A document is one JSON text, identified by its checksum.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/pipeline/plan.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// A plan to be recorded. It is copied, because the plan may be deleted before the recorder writes
/// it.
struct PlanFacts {
  PlanFacts(const MeasurementPlan& of, SensorView view);

  MeasurementPlan plan;                 ///< without `fit`: templates are too large to keep
  std::optional<OperatingPoint> point;  ///< of the templates, which determines them
  SensorView sensor;                    ///< sensor state when the plan was adopted
};
/// Approximate memory of these facts, bytes. What their plan shares with others counts in part
/// only.
std::size_t bytes_of(const PlanFacts& facts);

struct Document {
  std::string kind;  ///< see RECORDING.md
  std::string text;
  std::string sha256;  ///< of the text
};
Document make_document(std::string kind, const nlohmann::json& content);

/// Makes the documents of one recording. Used by one thread.
class PlanDocuments {
 public:
  /// The documents that describe this plan: reference, operators, calibration and SLM as far as
  /// they exist, and last the plan, which names the other documents by their SHA-256. Omits
  /// documents that an earlier call returned. An operating point is omitted only if it equals the
  /// last one. With a new reference that has an image, a call takes 0.1 s.
  std::vector<Document> of(const PlanFacts& facts);

 private:
  const std::string& reference_of(const std::shared_ptr<const Reference>& reference,
                                  std::vector<Document>& all);
  const std::string& calibration_of(const std::shared_ptr<const Calibration>& calibration,
                                    std::vector<Document>& all);

  /// SHA-256 of returned documents that rarely change. Plans are excluded: a closed loop makes ten
  /// per second.
  std::set<std::string> given_;
  std::string point_sha256_;                    ///< of the operating point written last
  std::shared_ptr<const Reference> reference_;  ///< the reference written last
  std::string reference_sha256_;
  std::shared_ptr<const Calibration> calibration_;  ///< the calibration written last
  std::string calibration_sha256_;
};

}  // namespace ovws
