/// Report of the study `rejection`: figures, JSON summary and text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/rejection.hpp"

namespace ovws::study {

/// A recording, and the counts of received and lost frames.
struct RecordedLoop {
  Recording recording;
  int received = 0;           ///< frames whose message arrived
  int lost = 0;               ///< frames without a message
  bool device_clock = true;   ///< times_s are device time stamps; false: arrival times
  std::string why_not_valid;  ///< reason of the last unusable frame; empty: none
};

struct RejectionMeasured {
  std::vector<int> modes_j;  ///< of both recordings
  RecordedLoop open, closed;
  nlohmann::json loop;     ///< result of loop.get with the loop closed
  double steps_hz = 0.0;   ///< step rate of the loop during the recording
  double segment_s = 0.0;  ///< segment length of the spectra
};

struct RejectionFound {
  Spectrum open, closed;
  LoopLaw law;
  std::vector<RejectionPoint> rejection;
  std::vector<RejectionBand> bands;
};

RejectionFound find_rejection(const RejectionMeasured& measured);

/// The figures "rejection-spectra" and "rejection".
std::vector<Figure> rejection_figures(const RejectionFound& found);

/// JSON summary; unknown numbers are null.
nlohmann::json rejection_summary(const RejectionMeasured& measured, const RejectionFound& found);

/// Formats a result of rejection_summary as text.
std::string rejection_text(const nlohmann::json& summary);

}  // namespace ovws::study
