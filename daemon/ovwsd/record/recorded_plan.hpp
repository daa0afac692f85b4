/// From what a recording says of a plan to the plan.
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/pipeline/plan.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/sensor/reference_templates.hpp"
#include "drivers/replay/recording_reader.hpp"

namespace ovws {

/// Plans of one recording, made when they are asked for. One thread at a time.
class RecordedPlans {
 public:
  /// Errc::invalid: a document is not the one of its checksum, or no JSON.
  static Result<RecordedPlans> of(RecordingReader& reader);

  /// Errors (Errc::invalid): there is none of that number, or it does not fit together;
  /// (Errc::refused): it had templates of torn spots, which a recording does not hold.
  Result<std::unique_ptr<MeasurementPlan>> make(std::uint64_t plan_id);

 private:
  Result<std::unique_ptr<MeasurementPlan>> read(const nlohmann::json& from);
  Result<std::vector<std::shared_ptr<const TemplateBank>>> templates(const nlohmann::json& from,
                                                                     TrackingSettings& tracking,
                                                                     const SpotModel& spots);

  std::map<std::uint64_t, std::string> plans_;    ///< text by number
  std::map<std::string, std::string> documents_;  ///< text by checksum
  std::optional<Reference> reference_;            ///< that was read last
  std::string reference_sha256_;
  TemplateShelf shelf_;
};

}  // namespace ovws
