/// A small bench for pipeline tests: bright spots drawn where a test wants them, and plans to
/// measure them with.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/optics/zernike.hpp"
#include "core/pipeline/plan.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws::test {

/// The brightest pixel near the start, then the centre of mass around it. Lost below 40 DN, and if
/// brighter is beyond the window. So simple that a test knows what it does.
class BrightestPixelTracker final : public SpotTracker {
 public:
  static constexpr int kReach = 14;
  static constexpr int kCentre = 8;
  TrackScratch make_scratch() const override { return {std::vector<float>(1), {}}; }

  SpotFix track(const ImageView& image, Vec2 start_px, TrackScratch& scratch) const override {
    scratch.samples[0] += 1.0F;  // two threads with one scratch would be seen by a sanitizer
    const int cx = int(std::lround(start_px.x));
    const int cy = int(std::lround(start_px.y));
    int best = -1, bx = 0, by = 0;
    for (int y = std::max(cy - kReach, 0); y <= std::min(cy + kReach, image.height - 1); ++y) {
      for (int x = std::max(cx - kReach, 0); x <= std::min(cx + kReach, image.width - 1); ++x) {
        const int value = image.row<std::uint8_t>(y)[x];
        if (value > best) best = value, bx = x, by = y;
      }
    }
    const bool at_border = std::max(std::abs(bx - cx), std::abs(by - cy)) == kReach;
    if (best < 40 || at_border || bx < kCentre || by < kCentre || bx >= image.width - kCentre ||
        by >= image.height - kCentre) {
      return {};
    }
    double sum = 0.0, sx = 0.0, sy = 0.0;
    for (int y = by - kCentre; y <= by + kCentre; ++y) {
      for (int x = bx - kCentre; x <= bx + kCentre; ++x) {
        const double value = image.row<std::uint8_t>(y)[x];
        sum += value, sx += value * x, sy += value * y;
      }
    }
    return {float(sx / sum), float(sy / sum), float(best), 1.0F, float(best)};
  }
};

/// The paper's lattice, charge 0 unless said, on a 512 x 512 image.
class SpotBench {
 public:
  static constexpr int kSize = 512;
  static constexpr std::size_t kBytes = std::size_t(kSize) * kSize;

  explicit SpotBench(int charge = 0) {
    sensor.charge = charge;
    lattice = *make_lattice(sensor, slm);
    model_px = model_spots_px(lattice, sensor, slm, optics, kSize, kSize);
    for (int j = 1; j <= optimal_mode_count(sensor.subapertures_across); ++j) modes_j.push_back(j);
    slopes =
        slope_matrix(lattice, sensor, modes_j, sensor.charge == 0 ? kGradientTilt : kVortexTilt,
                     camera_px_per_cycle(optics, slm));
  }

  int spots() const { return int(model_px.size()); }

  /// Model positions moved by modes (RMS waves).
  std::vector<Vec2> moved(const std::vector<Mode>& modes, Vec2 shift_px = {}) const {
    std::vector<Vec2> at = model_px;
    for (std::size_t i = 0; i < at.size(); ++i) {
      at[i] = at[i] + shift_px;
      for (const Mode& mode : modes) {
        at[i].x += mode.waves * slopes(Eigen::Index(2 * i), mode.j - 1);
        at[i].y += mode.waves * slopes(Eigen::Index(2 * i + 1), mode.j - 1);
      }
    }
    return at;
  }

  /// An image with a Gaussian spot at each position except those of `dark`.
  static std::shared_ptr<const Image<std::uint8_t>> draw(const std::vector<Vec2>& at_px,
                                                         const std::vector<int>& dark = {},
                                                         double peak = 200.0) {
    auto image = std::make_shared<Image<std::uint8_t>>(kSize, kSize, std::uint8_t(2));
    for (int i = 0; i < int(at_px.size()); ++i) {
      if (std::find(dark.begin(), dark.end(), i) != dark.end()) continue;
      add_spot(*image, at_px[i], [peak](double r2) { return peak * std::exp(-0.02 * r2); });
    }
    return image;
  }
  static std::shared_ptr<const Image<std::uint8_t>> black() { return draw({}); }

  /// The same with vortices: a ring of 10 px radius about a dark core.
  static std::shared_ptr<const Image<std::uint8_t>> draw_vortices(
      const std::vector<Vec2>& at_px, const std::vector<int>& dark = {}) {
    constexpr double kRingRadius = 10.0;
    auto image = std::make_shared<Image<std::uint8_t>>(kSize, kSize, std::uint8_t(2));
    for (int i = 0; i < int(at_px.size()); ++i) {
      if (std::find(dark.begin(), dark.end(), i) != dark.end()) continue;
      add_spot(*image, at_px[i], [](double r2) {
        const double q = r2 / (kRingRadius * kRingRadius);
        return 200.0 * q * std::exp(1.0 - q);
      });
    }
    return image;
  }

  /// A plan for hologram 1 that predicts and refers to the model positions.
  std::unique_ptr<MeasurementPlan> plan(std::uint64_t id) const {
    auto plan = std::make_unique<MeasurementPlan>();
    plan->id = id;
    plan->hologram_id = 1;
    plan->sensor_epoch = 1;
    plan->charge = sensor.charge;
    plan->spots = {sensor.charge, lambda_d_px(optics, slm, sensor)};
    plan->roi = {0, 0, kSize, kSize};
    plan->predicted_px = model_px;
    plan->reference_px = model_px;
    plan->tracker = std::make_unique<BrightestPixelTracker>();
    plan->modes_j = modes_j;
    plan->reconstructor = std::make_unique<Reconstructor>(slopes, modes_j, model_px);
    return plan;
  }

  SlmGeometry slm;
  OpticsConfig optics;
  SensorConfig sensor;
  Lattice lattice;
  std::vector<Vec2> model_px;
  std::vector<int> modes_j;
  Eigen::MatrixXd slopes;

 private:
  template <class Profile>
  static void add_spot(Image<std::uint8_t>& image, Vec2 at, Profile&& profile) {
    constexpr int kReach = 28;
    for (int y = int(at.y) - kReach; y <= int(at.y) + kReach; ++y) {
      for (int x = int(at.x) - kReach; x <= int(at.x) + kReach; ++x) {
        if (x < 0 || y < 0 || x >= image.width || y >= image.height) continue;
        const double r2 = (x - at.x) * (x - at.x) + (y - at.y) * (y - at.y);
        const double value = image.at(x, y) + profile(r2);
        image.at(x, y) = std::uint8_t(std::min(std::lround(value), 255L));
      }
    }
  }
};

}  // namespace ovws::test
