/// Reads settled frames of the stream `wavefront` for `ovws check`.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <vector>

#include "daemon/examine/check/measured.hpp"
#include "daemon/shared/job.hpp"
#include "daemon/shared/lost_spots.hpp"

namespace ovws::examine {

/// Which frames of a hologram count.
struct Wanted {
  int count = 0;
  std::vector<int> modes_j;  ///< frames of other modes do not count
  /// Frames are preferred that templates of the wavefront have measured: those whose standard
  /// errors have a root sum square of at most this. 0: all frames are the same.
  double most_sigma_waves = 0.0;
  double least_s = 0.0;    ///< time to watch in any case
  double longest_s = 3.0;  ///< time to wait for the preferred frames
  /// Time to wait for the first valid frame unless too many spots are lost.
  double templates_s = cli::kTemplates_s;
};

/// One thread at a time. Messages that came before its construction are not read.
class FrameReader {
 public:
  static tl::expected<FrameReader, cli::CallFailure> open(const cli::Common& common,
                                                          std::function<bool()> interrupted);

  /// Frames of one hologram, the newest `count`. No frames if too few are valid, or on an
  /// interrupt.
  Shown shown(std::uint64_t hologram_id, const Wanted& wanted);
  /// All frames of the next seconds. `tick` is called some times a second with the seconds left.
  Record record(double seconds, const std::function<void(double)>& tick);
  /// The spots of all settled frames that were read.
  const cli::SpotCounts& spots() const { return spots_; }

 private:
  explicit FrameReader(Subscriber stream, std::function<bool()> interrupted)
      : stream_(std::move(stream)), interrupted_(std::move(interrupted)) {}
  /// The next message about a frame; those about its spots are counted.
  std::optional<nlohmann::json> next();

  Subscriber stream_;
  std::function<bool()> interrupted_;
  cli::SpotCounts spots_;
};

}  // namespace ovws::examine
