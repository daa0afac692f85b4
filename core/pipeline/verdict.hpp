/// Verdict on a frame: whether it is valid, and if not, why.
#pragma once

namespace ovws {

/// The first reason that applies. daemon/shared/verdict_sentence.hpp has a sentence for each.
enum class Verdict {
  valid,
  late,            ///< delivered so late that it is too old for control
  changing,        ///< the hologram was changing during the exposure, or there is no display
  no_pattern,      ///< a DMD's sequence is shown, and the frame's pattern is uncertain
  other_hologram,  ///< the SLM shows no hologram of the active plan, or the image has another
                   ///< region
  no_reference,    ///< there is no reference for its spots
  too_close,       ///< the spots are too close to those of another light source
  undetermined,    ///< enough spots are found, but do not determine the modes
  branch_points,   ///< the light has branch points, so that no smooth wavefront exists
  unconfirmed,     ///< templates must confirm the spots' positions first
  unexplained,     ///< no wavefront explains the spots' positions
  spots_lost,      ///< too few spots are found
};

}  // namespace ovws
