#include "core/wavefront/diffractive_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "core/port/clock.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws {
namespace {

constexpr float kPeak = 60000.0F;  // DN of 16 bit: rounding shifts no spot by more than 1e-5 px
constexpr int kMinTrackedSpots = 3;

/// Image of the last propagation in DN of 16 bit, scaled so that the brightest pixel is kPeak.
Image<std::uint16_t> image_of(const Image<std::complex<float>>& far) {
  Image<std::uint16_t> image(far.width, far.height);
  float brightest = std::numeric_limits<float>::min();
  for (const std::complex<float>& value : far.pixels) {
    brightest = std::max(brightest, std::norm(value));
  }
  std::transform(far.pixels.begin(), far.pixels.end(), image.pixels.begin(),
                 [scale = kPeak / brightest](const std::complex<float>& value) {
                   return std::uint16_t(std::lround(scale * std::norm(value)));
                 });
  return image;
}

}  // namespace

Result<ModeOperator> diffractive_operator(SensorField& field, const SpotTracker& tracker,
                                          const ModeOperator& slopes,
                                          std::span<const Vec2> spots_px, double limit_s) {
  return diffractive_operator(
      field, [&](int) -> const SpotTracker& { return tracker; }, slopes, spots_px, limit_s);
}

Result<ModeOperator> diffractive_operator(SensorField& field,
                                          const std::function<const SpotTracker&(int)>& tracker_of,
                                          const ModeOperator& slopes,
                                          std::span<const Vec2> spots_px, double limit_s) {
  const std::int64_t begun_ns = monotonic_ns();
  // Spot positions under one mode of `slopes`: x and y of each spot, camera pixels; NaN: lost.
  const auto tracked = [&](Eigen::Index column, double waves) {
    const Mode mode{slopes.modes_j[std::size_t(column)], waves};
    field.propagate({&mode, 1}, {});
    const Image<std::uint16_t> image = image_of(field.far());
    const ImageView view = view_of(image, PixelFormat::mono16);
    Eigen::VectorXd at_px(slopes.slopes.rows());
    for (std::size_t i = 0; i < spots_px.size(); ++i) {
      const auto moved = slopes.slopes.col(column).segment<2>(2 * Eigen::Index(i)) * waves;
      const SpotTracker& tracker = tracker_of(int(i));
      TrackScratch scratch = tracker.make_scratch();
      const SpotFix fix = tracker.track(view, spots_px[i] + Vec2{moved.x(), moved.y()}, scratch);
      at_px.segment<2>(2 * Eigen::Index(i)) << double(fix.x), double(fix.y);
    }
    return at_px;
  };
  ModeOperator made{OperatorKind::diffractive, slopes.modes_j, slopes.slopes};
  const Eigen::VectorXd flat = tracked(0, 0.0);
  for (Eigen::Index k = 0; k < made.slopes.cols(); ++k) {
    if (1e-9 * double(monotonic_ns() - begun_ns) > limit_s) {
      return fail(Errc::unavailable, "tracking",
                  "the diffractive operator of so many spots takes too long to compute: choose "
                  "operator slopes");
    }
    made.slopes.col(k) = tracked(k, kDiffractiveStep) - tracked(k, -kDiffractiveStep);
  }
  made.slopes /= 2.0 * kDiffractiveStep;
  int always_found = 0;
  for (std::size_t i = 0; i < spots_px.size(); ++i) {
    auto rows = made.slopes.middleRows(2 * Eigen::Index(i), 2);
    const bool found = rows.allFinite() && std::isfinite(flat[2 * Eigen::Index(i)]);
    always_found += found ? 1 : 0;
    if (!found) rows.setZero();
    made.flat_px.push_back(found ? Vec2{flat[2 * Eigen::Index(i)], flat[2 * Eigen::Index(i) + 1]}
                                 : Vec2{NAN, NAN});
  }
  if (always_found < kMinTrackedSpots) {
    return fail(Errc::refused, "tracking",
                "the tracker finds only " + std::to_string(always_found) + " of " +
                    std::to_string(spots_px.size()) +
                    " spots in the image that is computed for the diffractive operator: set "
                    "camera.roi so that it contains the spots, choose another tracker, or choose "
                    "operator slopes");
  }
  if (determined_modes(made.slopes) < int(made.modes_j.size())) {
    return fail(Errc::refused, "tracking",
                "the spots that the tracker finds in the model do not determine every mode: move "
                "the camera's region to the spots, or use another tracker");
  }
  return made;
}

}  // namespace ovws
