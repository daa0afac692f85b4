/// Records the wavefront stream for a given time.
#pragma once

#include <atomic>
#include <vector>

#include "daemon/ovws/study/rejection_report.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::cli {

struct RecordTask {
  bool loop_closed = false;  ///< the required state; any other is an error
  double seconds = 60.0;
  double seconds_after = 0.0;  ///< remaining time of the study, for the progress line
  std::vector<int> modes_j;
};

/// Records valid, settled frames with device time stamps, or arrival times if the camera has none.
/// Prints progress on stderr unless --json is set. Errors: the daemon fails, `interrupted`, too few
/// frames, or the loop's state or the sensor's modes change.
tl::expected<study::RecordedLoop, CallFailure> record(const Common& common, const RecordTask& task,
                                                      const std::atomic<bool>& interrupted);

/// A failure of this program, reported like an error of the daemon.
CallFailure failure(std::string message);
CallFailure interrupted_failure();

}  // namespace ovws::cli
