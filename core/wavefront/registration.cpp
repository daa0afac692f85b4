#include "core/wavefront/registration.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/decompositions.hpp"
#include "core/base/median.hpp"
#include "core/spots/position_fit.hpp"

namespace ovws {
namespace {

constexpr int kMinSights = 4;
constexpr double kMaxOffsetsCondition = 100.0;  // condition number: infinite for a line
constexpr double kMinSignificance = 8.0;        // times the robust spread of all smoothed pixels
constexpr double kFullScale = 60000.0;

/// Box filter: sums over squares of side 2 half + 1, by a summed-area table.
Image<float> box_sums(const Image<float>& in, int half) {
  Image<double> sums(in.width + 1, in.height + 1);
  for (int y = 0; y < in.height; ++y) {
    double row = 0.0;
    for (int x = 0; x < in.width; ++x) {
      const float value = in.at(x, y);
      row += std::isfinite(value) ? double(value) : 0.0;
      sums.at(x + 1, y + 1) = sums.at(x + 1, y) + row;
    }
  }
  Image<float> out(in.width, in.height);
  for (int y = 0; y < in.height; ++y) {
    const int top = std::max(0, y - half), bottom = std::min(in.height, y + half + 1);
    for (int x = 0; x < in.width; ++x) {
      const int left = std::max(0, x - half), right = std::min(in.width, x + half + 1);
      out.at(x, y) = float(sums.at(right, bottom) - sums.at(left, bottom) - sums.at(right, top) +
                           sums.at(left, top));
    }
  }
  return out;
}

/// Centroid of the excess over half maximum, in the neighbourhood of the peak.
Vec2 middle_of_peak(const Image<float>& smoothed, int px, int py, int reach, float floor) {
  const float half = 0.5F * (smoothed.at(px, py) + floor);
  double sum = 0.0;
  Vec2 moment;
  for (int y = std::max(0, py - reach); y < std::min(smoothed.height, py + reach + 1); ++y) {
    for (int x = std::max(0, px - reach); x < std::min(smoothed.width, px + reach + 1); ++x) {
      const double above = double(std::max(0.0F, smoothed.at(x, y) - half));
      sum += above;
      moment = moment + above * Vec2{double(x), double(y)};
    }
  }
  return (1.0 / sum) * moment;
}

Vec2 errors_of(double variance, const Eigen::Matrix3d& covariance, int row) {
  const double error = std::sqrt(variance * covariance(row, row));
  return {error, error};
}

}  // namespace

void FoundArray::use_in(SensorConfig& sensor) const {
  if (empty()) return;
  sensor.lenslets = lenslets;
  sensor.pupil_diameter_px = pupil_diameter_px;
  sensor.subapertures_across = subapertures_across;
}

std::optional<Vec2> shift_if_same(const FoundArray& now, const FoundArray& next) {
  constexpr double kSamePlace = 0.005, kMostShift = 0.05, kRim = 0.1;  // of the pitch
  const double pitch = now.lenslets.width_px;
  if (std::abs(next.pupil_diameter_px - now.pupil_diameter_px) > kRim * pitch) return {};
  const double inner_px = 0.5 * (now.pupil_diameter_px - pitch) - kRim * pitch;
  std::vector<Vec2> offs;
  std::vector<bool> again(now.lenslets.centres_px.size(), false);
  for (const Vec2 at : next.lenslets.centres_px) {
    const std::size_t before = offs.size();
    for (std::size_t i = 0; i < again.size() && offs.size() == before; ++i) {
      const Vec2 off = at - now.lenslets.centres_px[i];
      if (norm(off) > kMostShift * pitch) continue;
      again[i] = true;
      offs.push_back(off);
    }
    if (offs.size() == before && norm(at) < inner_px) return {};
  }
  for (std::size_t i = 0; i < again.size(); ++i) {
    if (!again[i] && norm(now.lenslets.centres_px[i]) < inner_px) return {};
  }
  if (offs.empty()) return {};
  Vec2 mean;
  for (const Vec2 off : offs) mean = mean + (1.0 / double(offs.size())) * off;
  for (const Vec2 off : offs) {
    if (norm(off - mean) > kSamePlace * pitch) return {};
  }
  return Vec2{} - mean;
}

Registration rebased(const Registration& registration, Vec2 base_cpp) {
  Registration out = registration;
  out.base_px = out.base_px + out.px_per_cycle * (base_cpp - registration.base_cpp);
  out.base_cpp = base_cpp;
  return out;
}

Result<Registration> fit_registration(std::span<const ProbeSight> sights) {
  const auto n = Eigen::Index(sights.size());
  if (n < kMinSights) {
    return fail(Errc::refused, "",
                "the spot was found for only " + std::to_string(n) +
                    " slopes, 4 are needed: check the exposure, and that the region of interest "
                    "holds the base spot and its surroundings; if there is light, the SLM's phase "
                    "may fall with the grey level: run lut.run first");
  }
  double scale = 0.0;  // gives the columns a similar magnitude
  for (const ProbeSight& s : sights) scale = std::max(scale, norm(s.offset_cpp));
  Eigen::MatrixXd a(n, 3), b(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ProbeSight& s = sights[std::size_t(i)];
    a.row(i) << 1.0, s.offset_cpp.x / scale, s.offset_cpp.y / scale;
    b.row(i) << s.at_px.x, s.at_px.y;
  }
  const Eigen::VectorXd singular = singular_values(a);
  if (!(singular[0] < kMaxOffsetsCondition * singular[2])) {
    return fail(
        Errc::refused, "",
        "the spot was found on one line only, which does not determine the map: enlarge the "
        "region of interest");
  }
  const Eigen::MatrixXd x = least_squares(a, b);
  const double squares = (a * x - b).squaredNorm();
  const double variance = n > 3 ? squares / (2.0 * double(n - 3)) : 0.0;
  const Eigen::Matrix3d covariance = Cholesky(gram_matrix(a)).inverse();
  const Vec2 by_u = (1.0 / scale) * errors_of(variance, covariance, 1);
  const Vec2 by_v = (1.0 / scale) * errors_of(variance, covariance, 2);
  Registration r;
  r.base_px = {x(0, 0), x(0, 1)};
  r.px_per_cycle = {x(1, 0) / scale, x(2, 0) / scale, x(1, 1) / scale, x(2, 1) / scale};
  r.standard_error = {by_u.x, by_v.x, by_u.y, by_v.y};
  r.base_standard_error_px = errors_of(variance, covariance, 0);
  r.residual_px = std::sqrt(squares / (2.0 * double(n)));
  r.sights = int(n);
  return r;
}

std::optional<Vec2> spot_in(const Image<float>& light, const SpotModel& spots) {
  const int half = std::max(1, int(std::lround(spots.lambda_d_px)));
  if (light.width <= 2 * half || light.height <= 2 * half) return std::nullopt;
  const Image<float> smoothed = box_sums(light, half);
  const auto brightest = std::max_element(smoothed.pixels.begin(), smoothed.pixels.end());
  const int at = int(brightest - smoothed.pixels.begin());
  const float middle = median(smoothed.pixels);
  std::vector<float> deviations;
  for (const float value : smoothed.pixels) deviations.push_back(std::abs(value - middle));
  const double spread = kSigmaPerMedianDeviation * double(median(std::move(deviations)));
  if (!(double(*brightest - middle) > kMinSignificance * spread)) return std::nullopt;
  return middle_of_peak(smoothed, at % light.width, at / light.width, 2 * half, middle);
}

Image<std::uint16_t> in_16_bits(const Image<float>& light) {
  float darkest = 0.0F, brightest = 0.0F;
  for (const float value : light.pixels) {
    if (!std::isfinite(value)) continue;
    darkest = std::min(darkest, value);
    brightest = std::max(brightest, value);
  }
  const float per_dn = float(kFullScale) / std::max(brightest - darkest, 1e-6F);
  Image<std::uint16_t> whole(light.width, light.height);
  for (std::size_t k = 0; k < light.pixels.size(); ++k) {
    const float value = std::isfinite(light.pixels[k]) ? light.pixels[k] : brightest;
    whole.pixels[k] = std::uint16_t(std::lround((value - darkest) * per_dn));
  }
  return whole;
}

std::optional<Vec2> find_probe(const Image<float>& light, const SpotModel& spots, Vec2 start_px) {
  const Image<std::uint16_t> whole = in_16_bits(light);
  const auto tracker = make_position_fit(spots);
  if (!tracker) return std::nullopt;
  TrackScratch scratch = (*tracker)->make_scratch();
  const SpotFix fix = (*tracker)->track(view_of(whole, PixelFormat::mono16), start_px, scratch);
  if (!fix.found()) return std::nullopt;
  return Vec2{double(fix.x), double(fix.y)};
}

}  // namespace ovws
