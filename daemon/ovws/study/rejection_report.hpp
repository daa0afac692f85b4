/// What a study of a loop's rejection found, as files for people and programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/rejection.hpp"

namespace ovws::study {

/// A recording and what became of the camera's frames meanwhile.
struct RecordedLoop {
  Recording recording;
  int received = 0;           ///< frames of which the daemon told
  int lost = 0;               ///< frames of which it did not
  bool device_clock = true;   ///< whose stamps times_s are; false: those of arrival
  std::string why_not_valid;  ///< of the last frame that could not be used; empty: none
};

struct RejectionMeasured {
  std::vector<int> modes_j;  ///< of both recordings
  RecordedLoop open, closed;
  nlohmann::json loop;     ///< result of loop.get with the loop closed
  double steps_hz = 0.0;   ///< while it was recorded
  double segment_s = 0.0;  ///< of the spectra
};

struct RejectionFound {
  Spectrum open, closed;
  LoopLaw law;
  std::vector<RejectionPoint> rejection;
  std::vector<RejectionBand> bands;
};

RejectionFound find_rejection(const RejectionMeasured& measured);

/// "spectra" and "rejection".
std::vector<Figure> rejection_figures(const RejectionFound& found);

/// For a program: a number that is not known is null.
nlohmann::json rejection_summary(const RejectionMeasured& measured, const RejectionFound& found);

/// The same, to be read; of a result of rejection_summary.
std::string rejection_text(const nlohmann::json& summary);

}  // namespace ovws::study
