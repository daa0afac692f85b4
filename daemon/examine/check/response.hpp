/// Response of the bench to each mode: what is read back of what the SLM shows.
#pragma once

#include <array>
#include <vector>

#include "daemon/examine/check/measured.hpp"

namespace ovws::examine {

/// Frames of one hologram. `first`: the first settled and valid frame; `rest`: the later frames
/// that count, all measured in the same way. All have the same modes.
struct Shown {
  Frame first;
  std::vector<Frame> rest;
  int settled = 0, valid = 0;  ///< frames that came, whether they count or not
};

/// The response to mode j, shown with +a, -a, -a, +a. Standard errors are the larger of those by
/// the scatter of the frames and by the difference of the two pairs. Not read if a hologram has no
/// frames.
Poke poke_of(int j, const std::array<Shown, 4>& shown);

/// How far the reading of a poke is from what was shown, waves: root sum square over the measured
/// modes, with tilts, of the error that its standard errors do not explain.
double error_waves(const Poke& poke, const std::vector<int>& modes_j);

/// The gain of the poked mode itself; NaN if the sensor does not measure it.
study::Mean slope_of(const Poke& poke, const std::vector<int>& modes_j);
/// Root sum square of the gains of all other modes.
double crosstalk_of(const Poke& poke, const std::vector<int>& modes_j);

}  // namespace ovws::examine
