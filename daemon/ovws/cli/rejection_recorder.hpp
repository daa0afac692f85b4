/// The wavefront stream, taken down for a time.
#pragma once

#include <atomic>
#include <vector>

#include "daemon/ovws/study/rejection_report.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::cli {

struct RecordTask {
  bool loop_closed = false;  ///< that it is something else is an error
  double seconds = 60.0;
  double seconds_after = 0.0;  ///< of the study, for who waits
  std::vector<int> modes_j;
};

/// Valid, settled frames, with the device's stamps, or those of arrival if it has none. Tells its
/// progress on stderr, not with --json. Errors: the daemon, `interrupted`, too few frames, the loop
/// or the sensor became another.
tl::expected<study::RecordedLoop, CallFailure> record(const Common& common, const RecordTask& task,
                                                      const std::atomic<bool>& interrupted);

/// A failure in our own words.
CallFailure failure(std::string message);
CallFailure interrupted_failure();

}  // namespace ovws::cli
