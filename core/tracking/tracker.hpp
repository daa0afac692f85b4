/// The interface of a spot tracker: one spot of one frame, from a start position.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

class TemplateBank;

/// What the template of a tracker that has one (matched) is: the model's spot, or each spot as a
/// reference shows it.
enum class TemplateKind : std::uint8_t { model, reference };

/// What turns the spots' displacements into modes.
enum class OperatorKind : std::uint8_t {
  slopes,        ///< the tracker's own tilt of each mode (slope_matrix)
  diffractive,   ///< each mode through the diffraction model, tracked (diffractive_matrix)
  relinearised,  ///< slopes, then steps from where the model puts the spots (relinearise): no
                 ///< matrix
  measured,      ///< each mode shown on the bench, tracked (interaction_matrix)
};

/// TrackingConfig, and what a tracker by itself does not know: where its templates come from, and
/// how modes are made of what it finds.
struct TrackingSettings : TrackingConfig {
  TemplateKind templates = TemplateKind::model;
  OperatorKind mode_operator = OperatorKind::slopes;

  friend bool operator==(const TrackingSettings&, const TrackingSettings&) = default;
};

/// What a tracker must know of the spots. Lengths in camera pixels.
struct SpotModel {
  int charge = 1;
  double lambda_d_px = 12.55;  ///< diffraction width of one subaperture on the camera
  LitPixels lit{};             ///< which of the camera's pixels see them

  /// The same for an image of those pixels alone, whose pixels are `lit.lattice.step` apart.
  SpotModel on_lattice() const { return {charge, lambda_d_px / lit.lattice.step}; }

  friend bool operator==(const SpotModel&, const SpotModel&) = default;
};

/// Working memory of one tracking thread, sized once: `track` never allocates.
struct TrackScratch {
  std::vector<float> samples;
  std::vector<float> sums;
};

/// A subaperture's number that is not known.
constexpr int kAnySpot = -1;

/// Immutable after construction; one object serves all threads, each with a scratch of its own.
class SpotTracker {
 public:
  virtual ~SpotTracker() = default;

  /// Half-width of the square of pixels read around the start position, camera pixels.
  virtual int window_half_px() const = 0;
  virtual TrackScratch make_scratch() const = 0;

  /// Whether `track` cares which spot it is asked for.
  virtual bool per_spot() const { return false; }

  /// Finds the spot near `start_px`; `spot` is its subaperture's number, or kAnySpot. Lost (see
  /// SpotFix) if what is there does not look like the spot: no guess is ever returned. The window
  /// is clipped at the image's edge; a spot too near the edge is lost. RT-safe.
  virtual SpotFix track(const ImageView& image, Vec2 start_px, TrackScratch& scratch,
                        int spot = kAnySpot) const OVWS_NONBLOCKING = 0;
};

/// `own`: of `matched`, see there; no other tracker has templates.
/// Positions are the camera's pixels, also where only some of these are lit (LatticeTracker).
/// Errors (Errc::invalid, field "tracking.…"): kernel_radius outside [0.1, 2]; a tracker that makes
/// no sense for the charge (any lg on charge 0 follows the bright spot's maximum and is allowed).
/// Field "optics": lambda/d below 4 or above 200 lit pixels.
Result<std::unique_ptr<const SpotTracker>> make_tracker(
    const TrackingConfig& config, const SpotModel& spots,
    std::vector<std::shared_ptr<const TemplateBank>> own = {});

}  // namespace ovws
