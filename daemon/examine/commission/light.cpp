#include "daemon/examine/commission/light.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ovws::commission {
namespace {

using nlohmann::json;

constexpr int kCell = 16;
constexpr int kReach_px = 40;      ///< around a spot's peak; holds an aberrated spot, too
constexpr int kRim_px = 20;        ///< light that is brightest there belongs to a spot outside
constexpr float kMinPeak = 0.05F;  ///< of full scale
constexpr double kMinShare = 0.4;  ///< of the additional light that is near the peak
constexpr double kNoiseFactor = 4.0, kMinChange = 0.004;  ///< of full scale, mean of a cell

/// Sum of the pixels above `floor` within kReach_px of (cx, cy), and their centre of intensity.
struct Patch {
  double sum = 0.0, x = 0.0, y = 0.0;
};
Patch patch_at(const Image<float>& more, int cx, int cy, float floor) {
  Patch patch;
  for (int y = std::max(0, cy - kReach_px); y < std::min(more.height, cy + kReach_px + 1); ++y) {
    for (int x = std::max(0, cx - kReach_px); x < std::min(more.width, cx + kReach_px + 1); ++x) {
      const double value = more.at(x, y) > floor ? more.at(x, y) : 0.0;
      patch.sum += value;
      patch.x += value * x;
      patch.y += value * y;
    }
  }
  if (patch.sum > 0.0) {
    patch.x /= patch.sum;
    patch.y /= patch.sum;
  }
  return patch;
}

std::vector<double> cell_means(const Image<float>& image) {
  std::vector<double> means;
  for (int y = 0; y + kCell <= image.height; y += kCell) {
    for (int x = 0; x + kCell <= image.width; x += kCell) {
      double sum = 0.0;
      for (int k = 0; k < kCell * kCell; ++k) sum += image.at(x + k % kCell, y + k / kCell);
      means.push_back(sum / (kCell * kCell));
    }
  }
  return means;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    most = std::max(most, std::abs(a[k] - b[k]));
  }
  return most;
}

}  // namespace

float brightest(const Image<float>& image) {
  return image.pixels.empty() ? 0.0F : *std::ranges::max_element(image.pixels);
}

Result<json> expose(Bench& bench) {
  return bench.job("camera.auto_exposure", json::object(), "finding the exposure");
}

Result<json> expose_spots(Bench& bench) {
  const cli::Parts before = bench.parts(kLight);
  cli::Borrow kept(bench.settings().daemon, before, bench.restoring());
  if (before.at(cli::Part::pattern).at("pattern") != "sensor") {
    bench.call("slm.show", {{"pattern", "sensor"}});
  }
  auto found = expose(bench);
  if (found) kept.keep();
  return found;
}

std::optional<Spot> spot_in(const Image<float>& with, const Image<float>& without) {
  Image<float> more(with.width, with.height);
  if (without.width != with.width || without.height != with.height) return std::nullopt;
  for (std::size_t k = 0; k < more.pixels.size(); ++k) {
    more.pixels[k] = std::max(0.0F, with.pixels[k] - without.pixels[k]);
  }
  const auto peak = std::ranges::max_element(more.pixels);
  if (more.pixels.empty() || *peak < kMinPeak) return std::nullopt;
  const int at = int(peak - more.pixels.begin());
  const int x = at % more.width, y = at / more.width;
  const bool is_at_rim = std::min({x, y, more.width - 1 - x, more.height - 1 - y}) < kRim_px;
  if (is_at_rim) return std::nullopt;
  const float floor = 0.1F * *peak;
  const Patch near = patch_at(more, x, y, floor);
  double all = 0.0;
  for (const float value : more.pixels) all += value > floor ? value : 0.0F;
  if (near.sum < kMinShare * all) return std::nullopt;
  return Spot{near.x, near.y};
}

double change(const Image<float>& one, const Image<float>& other, const Image<float>& one_again) {
  const auto a = cell_means(one), b = cell_means(other), c = cell_means(one_again);
  return largest_difference(a, b) / (kNoiseFactor * largest_difference(a, c) + kMinChange);
}

}  // namespace ovws::commission
