#include "core/wavefront/phase_retrieval.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <numbers>
#include <queue>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/decompositions.hpp"
#include "core/optics/chirp_z.hpp"
#include "core/optics/flatness.hpp"

namespace ovws {
namespace {

using ComplexFloat = std::complex<float>;
using Field = std::vector<ComplexFloat>;

constexpr int kDefocus = 4, kOblique = 3, kVertical = 5;
constexpr double kStrength = 3.0, kWeaker = 2.0;  // waves RMS
constexpr int kFullCells = 100;                   // for which kStrength is meant
constexpr double kMinLambdaPx = 2.0;              // an intensity has twice the pupil's frequencies
constexpr int kIterations = 80;
// A retrieval finds a vortex up to 0.3 pupil radii from that of its start; 10 iterations tell which
// of the starts is nearest.
constexpr int kTrials = 10, kStartsOnRing = 6;
constexpr double kStartRadius = 0.6;  // pupil radii
constexpr double kMaxMomentum = 0.9;
constexpr double kFloor = 0.01;     // of the brightest pixels: intensity where noise is as large
constexpr double kBright = 0.999;   // quantile that counts as brightest
constexpr double kMaxJumps = 2e-4;  // light at jumps; a vortex at 0.9 pupil radii has 5e-4
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Both directions between the cells and the image, each with its axis: all about their centres.
struct Transforms {
  ChirpZ to_image, to_cells;
  int side, window;
  Field between;

  Transforms(int cells, int pixels)
      : to_image({cells, pixels, -0.5 * (pixels - 1) / pixels, 1.0 / pixels}),
        to_cells({pixels, cells, -0.5 * (cells - 1) / pixels, 1.0 / pixels}),
        side(cells),
        window(pixels),
        between(std::size_t(cells) * std::size_t(pixels)) {}

  void image(const Field& cells, Field& out) {
    to_image.transform(cells.data(), side, between.data(), side);
    to_image.transform(between.data(), window, out.data(), window);
  }
  /// The adjoint of `image`, divided by the number of pixels. Conjugates `pixels`.
  void adjoint(Field& pixels, Field& out) {
    for (ComplexFloat& one : pixels) one = std::conj(one);
    to_cells.transform(pixels.data(), window, between.data(), window);
    to_cells.transform(between.data(), side, out.data(), side);
    const float scale = 1.0F / (float(window) * float(window));
    for (ComplexFloat& one : out) one = scale * std::conj(one);
  }
};

float brightest(const std::vector<DiverseImage>& images) {
  std::vector<float> all;
  for (const auto& one : images) {
    std::ranges::copy_if(one.intensity.pixels, std::back_inserter(all),
                         [](float dn) { return !std::isnan(dn); });
  }
  if (all.empty()) return 0.0F;
  const auto at = all.begin() + std::ptrdiff_t(kBright * double(all.size() - 1));
  std::ranges::nth_element(all, at);
  return *at;
}

/// Centroid of all images, from their middle. Patterns of both signs keep it in its place.
Vec2 centroid(const std::vector<DiverseImage>& images) {
  Vec2 sum;
  double light = 0.0;
  for (const auto& one : images) {
    const double middle = 0.5 * (one.intensity.width - 1);
    for (int y = 0; y < one.intensity.height; ++y) {
      for (int x = 0; x < one.intensity.width; ++x) {
        const float dn = one.intensity.at(x, y);
        if (std::isnan(dn)) continue;
        light += double(dn);
        sum = sum + double(dn) * Vec2{x - middle, y - middle};
      }
    }
  }
  return light > 0.0 ? (1.0 / light) * sum : Vec2{};
}

}  // namespace

std::vector<std::vector<Mode>> diversity_patterns(int count, int cells) {
  const double part = std::min(1.0, double(cells) / kFullCells);
  std::vector<std::vector<Mode>> patterns;
  for (const double waves : {kStrength, kWeaker}) {
    for (const int j : {kVertical, kOblique, kDefocus}) {
      patterns.push_back({{j, part * waves}});
      patterns.push_back({{j, -part * waves}});
    }
  }
  patterns.resize(std::size_t(count));
  return patterns;
}

Result<PhaseRetrieval> PhaseRetrieval::make(const PxPerCycle& px_per_cycle,
                                            double pupil_diameter_px, int cells) {
  const double lambda_px = px_per_cycle.scale() / pupil_diameter_px;
  if (lambda_px < kMinLambdaPx) {
    return fail(Errc::refused, "optics",
                "lambda/D of the whole pupil has fewer than 2 camera pixels, too few for a phase "
                "retrieval: use a longer focal length, or a smaller sensor.pupil_diameter_px");
  }
  PhaseRetrieval one;
  one.map_ = px_per_cycle;
  one.diameter_px_ = pupil_diameter_px;
  one.cells_ = cells;
  one.window_ = fast_fft_length(int(std::ceil(cells * lambda_px)));
  one.cell_px_ = px_per_cycle.scale() / one.window_;
  const PxPerCycle& m = px_per_cycle;
  const double reach = std::max(std::hypot(m.yy, m.yx), std::hypot(m.xy, m.xx)) /
                       std::abs(m.determinant()) * pupil_diameter_px;
  one.side_ = int(std::ceil(reach * one.window_)) + 2;
  constexpr int kParts = 5;  // of a cell, to find how much of it is in the pupil
  for (int k = 0; k < one.side_ * one.side_; ++k) {
    const Vec2 at = one.slm_px(k % one.side_, k / one.side_);
    int inside = 0;
    for (int p = 0; p < kParts * kParts; ++p) {
      const Vec2 aside{double(p % kParts - kParts / 2), double(p / kParts - kParts / 2)};
      inside += int(norm(at + (one.cell_px_ / kParts) * aside) <= 0.5 * pupil_diameter_px);
    }
    one.pupil_.push_back(float(inside) / float(kParts * kParts));
  }
  return one;
}

/// The centre of a cell, SLM pixels from the pupil's centre: the transpose of the registration.
Vec2 PhaseRetrieval::slm_px(int column, int row) const {
  const double middle = 0.5 * (side_ - 1);
  const Vec2 y{(column - middle) / window_, (row - middle) / window_};
  return {map_.xx * y.x + map_.yx * y.y, map_.xy * y.x + map_.yy * y.y};
}

/// What all starts of a retrieval share.
struct PhaseRetrieval::Given {
  std::vector<Field> shown;                          ///< phasors of each pattern
  std::vector<std::vector<float>> measured, weight;  ///< amplitudes of each image
  double start = 0.0;                                ///< even amplitude with the images' light
  Vec2 middle;                                       ///< centroid of the images

  Given(const PhaseRetrieval& with, const std::vector<DiverseImage>& images)
      : middle(centroid(images)) {
    const float floor = float(kFloor) * brightest(images);
    double light = 0.0, area = 0.0;
    for (const auto& one : images) {
      Field phasors;
      for (int k = 0; k < with.side_ * with.side_; ++k) {
        const Vec2 at = (2.0 / with.diameter_px_) * with.slm_px(k % with.side_, k / with.side_);
        double waves = 0.0;
        for (const Mode& mode : one.modes) waves += mode.waves * zernike(mode.j, at);
        phasors.push_back(wrapped_phasor(waves));
      }
      shown.push_back(std::move(phasors));
      auto& amplitude = measured.emplace_back();
      auto& weights = weight.emplace_back();
      for (const float dn : one.intensity.pixels) {
        const float bright = std::isnan(dn) ? 0.0F : std::max(dn, 0.0F);
        amplitude.push_back(std::sqrt(bright));
        weights.push_back(std::isnan(dn) ? 0.0F : bright / (bright + floor));
        light += double(bright);
      }
    }
    for (const float inside : with.pupil_) area += double(inside * inside);
    start = std::sqrt(light / double(images.size()) / area) / with.window_;
  }
};

/// The unknown field and what one iteration needs.
struct PhaseRetrieval::Iteration {
  const Given& given;
  Transforms transforms;
  Field field, ahead, cells, gradient, pixels;
  double momentum = 1.0, misfit = 0.0;

  /// Begins with a vortex at a place, SLM pixels from the pupil's centre; 0: with a flat phase.
  Iteration(const PhaseRetrieval& with, const Given& given_images, int circulation, Vec2 vortex)
      : given(given_images), transforms(with.side_, with.window_) {
    const Vec2 middle = given.middle;
    for (int k = 0; k < with.side_ * with.side_; ++k) {
      const double half = 0.5 * (with.side_ - 1);
      const double tilt =
          (middle.x * (k % with.side_ - half) + middle.y * (k / with.side_ - half)) / with.window_;
      const Vec2 at = with.slm_px(k % with.side_, k / with.side_) - vortex;
      const double turn = circulation * std::atan2(at.y, at.x) / (2.0 * std::numbers::pi);
      field.push_back(float(given.start) * with.pupil_[std::size_t(k)] *
                      wrapped_phasor(tilt + turn));
    }
    ahead = field;
    cells.resize(field.size());
    gradient.resize(field.size());
    pixels.resize(std::size_t(with.window_) * std::size_t(with.window_));
  }

  void run(int steps, const std::vector<float>& pupil, const std::function<bool()>& stop) {
    for (int k = 0; k < steps && !stop(); ++k) step(pupil);
  }

  void step(const std::vector<float>& pupil) {
    std::ranges::fill(gradient, ComplexFloat());
    double left = 0.0, all = 0.0;
    for (std::size_t i = 0; i < given.shown.size(); ++i) {
      const Field& shown = given.shown[i];
      const std::vector<float>&measured = given.measured[i], &weight = given.weight[i];
      for (std::size_t k = 0; k < cells.size(); ++k) cells[k] = ahead[k] * shown[k];
      transforms.image(cells, pixels);
      for (std::size_t k = 0; k < pixels.size(); ++k) {
        const float amplitude = std::abs(pixels[k]);
        const float miss = measured[k] - amplitude, w = weight[k];
        left += double(w * miss * miss);
        all += double(w * measured[k] * measured[k]);
        pixels[k] = amplitude > 0.0F ? (w * miss / amplitude) * pixels[k] : ComplexFloat();
      }
      transforms.adjoint(pixels, cells);
      for (std::size_t k = 0; k < cells.size(); ++k) {
        gradient[k] += cells[k] * std::conj(shown[k]);
      }
    }
    misfit = std::sqrt(left / all);
    const double next = 0.5 * (1.0 + std::sqrt(1.0 + 4.0 * momentum * momentum));
    const auto beyond = float(std::min((momentum - 1.0) / next, kMaxMomentum));
    momentum = next;
    const float share = 1.0F / float(given.shown.size());
    for (std::size_t k = 0; k < field.size(); ++k) {
      const ComplexFloat better = pupil[k] > 0.0F ? ahead[k] + share * gradient[k] : ComplexFloat();
      ahead[k] = better + beyond * (better - field[k]);
      field[k] = better;
    }
  }
};

/// The vortex, of starts over the pupil, that explains the images best.
std::unique_ptr<PhaseRetrieval::Iteration> PhaseRetrieval::from_a_vortex(
    const Given& given, const std::function<bool()>& stop) const {
  std::unique_ptr<Iteration> best;
  for (int k = 0; k <= kStartsOnRing; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kStartsOnRing;
    const double radius = k == kStartsOnRing ? 0.0 : kStartRadius * 0.5 * diameter_px_;
    const Vec2 at = radius * Vec2{std::cos(angle), std::sin(angle)};
    for (const int circulation : {1, -1}) {
      auto one = std::make_unique<Iteration>(*this, given, circulation, at);
      one->run(kTrials, pupil_, stop);
      if (!best || one->misfit < best->misfit) best = std::move(one);
    }
  }
  best->run(kIterations - kTrials, pupil_, stop);
  return best;
}

Result<PhaseRetrieval::Found> PhaseRetrieval::retrieve(const std::vector<DiverseImage>& images,
                                                       bool seek_vortex,
                                                       const std::function<bool()>& stop) const {
  const Given given(*this, images);
  auto best = std::make_unique<Iteration>(*this, given, 0, Vec2{});
  best->run(kIterations, pupil_, stop);
  if (seek_vortex) {
    auto turned = from_a_vortex(given, stop);
    if (turned->misfit < best->misfit) best = std::move(turned);
  }
  if (stop()) return fail(Errc::refused, "", "the job was stopped");
  Found found;
  found.misfit = best->misfit;
  Field& field = best->field;
  // Half the tilt of a cell would be a jump: take the centroid's tilt out first.
  const Vec2 middle = given.middle;
  const double half = 0.5 * (side_ - 1);
  for (int k = 0; k < side_ * side_; ++k) {
    field[std::size_t(k)] *=
        wrapped_phasor(-(middle.x * (k % side_ - half) + middle.y * (k / side_ - half)) / window_);
  }
  double jumps = 0.0;
  const Image<float> waves = unwrapped(field, jumps);
  if (jumps > kMaxJumps) found.singularity = brightest_singularity(field, waves);
  found.waves = on_slm(waves);
  return found;
}

/// Unwraps from the middle, always the brightest cell that has an unwrapped neighbour: so jumps
/// stay in the dark, unless the field has phase singularities. NaN outside the pupil.
Image<float> PhaseRetrieval::unwrapped(const Field& field, double& share_of_jumps) const {
  Image<float> waves(side_, side_);
  for (std::size_t k = 0; k < field.size(); ++k) {
    const float turns = float(double(std::arg(field[k])) / (2.0 * std::numbers::pi));
    waves.pixels[k] = pupil_[k] > 0.5F ? turns : kNan;
  }
  std::vector<bool> done(field.size(), false);
  std::priority_queue<std::pair<float, int>> queue;  // of light, and cell
  const int middle = (side_ / 2) * side_ + side_ / 2;
  queue.emplace(0.0F, middle);
  done[std::size_t(middle)] = true;
  double jumps = 0.0, all = 0.0;
  while (!queue.empty()) {
    const auto at = std::size_t(queue.top().second);
    queue.pop();
    for (const int step : {-1, 1, -side_, side_}) {
      const auto next = std::size_t(int(at) + step);
      if (next >= field.size() || std::isnan(waves.pixels[next])) continue;
      const float step_waves = waves.pixels[next] - waves.pixels[at];
      const double light = double(std::min(std::norm(field[at]), std::norm(field[next])));
      if (done[next]) {
        all += light;
        if (std::abs(step_waves) > 0.5F) jumps += light;
        continue;
      }
      waves.pixels[next] -= std::round(step_waves);
      done[next] = true;
      queue.emplace(std::norm(field[next]), int(next));
    }
  }
  share_of_jumps = jumps / all;
  return waves;
}

/// The place about which the phase turns, pupil radii, where the light is brightest: of four cells,
/// the darkest counts.
Vec2 PhaseRetrieval::brightest_singularity(const Field& field, const Image<float>& waves) const {
  Vec2 found;
  float brightest = 0.0F;
  for (int row = 0; row + 1 < side_; ++row) {
    for (int column = 0; column + 1 < side_; ++column) {
      const int first = row * side_ + column;
      const std::array<int, 5> around{first, first + 1, first + side_ + 1, first + side_, first};
      float turns = 0.0F, light = std::numeric_limits<float>::infinity();
      for (std::size_t k = 0; k < 4; ++k) {
        const auto here = std::size_t(around[k]), next = std::size_t(around[k + 1]);
        turns += std::round(waves.pixels[next] - waves.pixels[here]);
        light = std::min(light, std::norm(field[here]));
      }
      if (turns == 0.0F || std::isnan(turns) || light <= brightest) continue;
      brightest = light;
      found = (1.0 / diameter_px_) * (slm_px(column, row) + slm_px(column + 1, row + 1));
    }
  }
  return found;
}

/// Interpolates between the cells to the pupil's square on the SLM.
Image<float> PhaseRetrieval::on_slm(const Image<float>& waves) const {
  Image<float> map(cells_, cells_);
  const double d = map_.determinant();
  for (int k = 0; k < cells_ * cells_; ++k) {
    float& value = map.pixels[std::size_t(k)];
    value = kNan;
    const Vec2 unit = cell_centre(cells_, k);
    if (norm(unit) > 1.0) continue;
    const Vec2 at = (0.5 * diameter_px_) * unit;
    const Vec2 turned{(map_.yy * at.x - map_.yx * at.y) / d, (map_.xx * at.y - map_.xy * at.x) / d};
    value = value_at(waves, (2.0 * window_ / side_) * turned);
  }
  remove_tilts(map);
  return map;
}

void remove_tilts(Image<float>& waves) {
  Eigen::Matrix3d sums = Eigen::Matrix3d::Zero();
  Eigen::VectorXd values = Eigen::VectorXd::Zero(3);
  const auto point = [&](std::size_t k) {
    return Eigen::Vector3d(1.0, double(k % std::size_t(waves.width)) - 0.5 * waves.width,
                           double(k / std::size_t(waves.width)) - 0.5 * waves.height);
  };
  for (std::size_t k = 0; k < waves.pixels.size(); ++k) {
    if (std::isnan(waves.pixels[k])) continue;
    sums += point(k) * point(k).transpose();
    values += double(waves.pixels[k]) * point(k);
  }
  const Eigen::Vector3d plane = solve_symmetric(sums, values);
  for (std::size_t k = 0; k < waves.pixels.size(); ++k) {
    waves.pixels[k] -= float(plane.dot(point(k)));
  }
}

double rms_of(const Image<float>& waves) {
  double squares = 0.0;
  int count = 0;
  for (const float one : waves.pixels) {
    if (std::isnan(one)) continue;
    squares += double(one) * double(one);
    ++count;
  }
  return count > 0 ? std::sqrt(squares / count) : 0.0;
}

double common_resolution(const Image<float>& one, const Image<float>& other) {
  const int side = one.width;
  const int length = fast_fft_length(side);
  ChirpZ transform({side, length, -0.5 * (length - 1) / length, 1.0 / length});
  const auto spectrum = [&](const Image<float>& waves) {
    Field cells, between(std::size_t(side * length)), all(std::size_t(length * length));
    for (int k = 0; k < side * side; ++k) {
      const Vec2 at = cell_centre(side, k);
      const double rim =
          std::max(0.0, 1.0 - at.x * at.x - at.y * at.y);  // no edges in the spectrum
      const float value = waves.pixels[std::size_t(k)];
      cells.emplace_back(std::isnan(value) ? 0.0F : float(rim * rim) * value);
    }
    transform.transform(cells.data(), side, between.data(), side);
    transform.transform(between.data(), length, all.data(), length);
    return all;
  };
  const Field a = spectrum(one), b = spectrum(other);
  const int rings = side / 2;
  std::vector<double> common(std::size_t(rings + 1)), in_a(common), in_b(common);
  for (int k = 0; k < length * length; ++k) {
    const double cycles =
        std::hypot(k % length - 0.5 * (length - 1), k / length - 0.5 * (length - 1)) * side /
        length;
    const auto ring = std::size_t(std::lround(cycles));
    if (ring >= common.size()) continue;
    common[ring] += double((a[std::size_t(k)] * std::conj(b[std::size_t(k)])).real());
    in_a[ring] += double(std::norm(a[std::size_t(k)]));
    in_b[ring] += double(std::norm(b[std::size_t(k)]));
  }
  for (int ring = 1; ring <= rings; ++ring) {
    const auto r = std::size_t(ring);
    if (common[r] < 0.5 * std::sqrt(in_a[r] * in_b[r])) return 0.5 * side / ring;
  }
  return 1.0;
}

}  // namespace ovws
