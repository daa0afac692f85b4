/// Finds a lenslet array in one image of its spots: lattice, pitch, rotation and lit lenslets.
#pragma once

#include <optional>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/geometry.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// What is known of the array before: numbers on the camera, in camera pixels.
struct LensletSearch {
  Grid grid = Grid::square;
  double pitch_px = 0.0;  ///< expected, right within kMaxPitchError
  SpotModel spots;        ///< size and charge of a spot
};
constexpr double kMaxPitchError = 0.1;  ///< relative

/// One place of the lattice, on the camera.
struct LensletNode {
  int a = 0,
      b = 0;   ///< along the lattice's two directions, from the spot nearest the middle of all
  Vec2 at_px;  ///< by the fitted lattice
  /// How much the lenslet counts to the pupil, 0 to 1: by its light relative to the median of the
  /// lit ones around it, 1 from half of that on, so that neither noise nor the light's profile
  /// moves the pupil much. Dark ones have one, too: a cut spot at the rim may be found or not.
  double share = 0.0;
  bool lit = false;  ///< a spot was found, and its bright part has at least kLitLevel
};
/// A lenslet with less light, relative to the upper quartile of all spots, counts as dark: its spot
/// may be stray light of its neighbours.
constexpr double kLitLevel = 0.2;

struct LensletMap {
  double pitch_px = 0.0;
  double pitch_error_px = 0.0;  ///< its standard error, from the spots' distances from the lattice
  double rotation_deg = 0.0;    ///< from the camera's +x towards +y, at most half of the symmetry
  double residual_px = 0.0;     ///< RMS distance of the spots from the lattice, over x and y
  std::vector<LensletNode> nodes;  ///< all lit ones, and the dark ones between and around them

  int lit() const;
};

/// Finds the array in a mean image (DN; not finite: saturated). The wavefront of the light may bend
/// the lattice by a third of the pitch from one lenslet to the next.
///
/// Errors (Errc::refused): field "camera", fewer than kMinSubapertures spots; "camera.roi", more
/// than kMaxSubapertures; "array.pitch_um", the spots are not as far apart as expected;
/// "sensor.grid", they do not form the expected lattice.
Result<LensletMap> find_lenslets(const Image<float>& mean_dn, const LensletSearch& search);

/// The circle on the array over which the modes are measured, and the lit lenslets inside.
struct LensletPupil {
  Vec2 centre_px;                ///< on the camera: mean place of the lenslets, by their shares
  double diameter_px = 0.0;      ///< camera pixels
  std::vector<Vec2> centres_px;  ///< of the lenslets in use, from centre_px; sorted by y, then x
};
/// Places the pupil. `diameter_px`: its diameter; none: the largest circle around the
/// centre that meets no dark cell, except dark ones that lit lenslets enclose; of a cell that
/// counts in part, it covers that part.
LensletPupil lenslet_pupil(const LensletMap& map, std::optional<double> diameter_px);

}  // namespace ovws
