#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "core/optics/zernike.hpp"
#include "daemon/ovws/design/search.hpp"
#include "proto/limits.hpp"

namespace ovws::design {
namespace {

bool works(const Bench& bench, const Config& base) {
  return find_config(bench, base, Shapes::unused).has_value();
}

bool within(double value, limits::Numbers range) {
  return value >= range.min && value <= range.max;
}

/// Rounds away from the present value, so that a change is rather too large than too small.
double rounded_away(double value, double factor) {
  return factor > 1.0 ? rounded_up(value) : rounded_down(value);
}

enum class Direction { up, both };

/// Multiplies a part by growing factors, also by their inverses, until the bench works.
/// `change` returns none if the part cannot be changed so far.
std::optional<Change> nearest(const Config& base, Direction direction,
                              const std::function<std::optional<Change>(double)>& change) {
  constexpr double kStep = 1.1, kMost = 30.0;
  for (double factor = kStep; factor <= kMost; factor *= kStep) {
    for (const double by : {1.0 / factor, factor}) {
      if (by < 1.0 && direction == Direction::up) continue;
      const auto changed = change(by);
      if (changed && works(changed->bench, base)) return changed;
    }
  }
  return std::nullopt;
}

std::optional<Change> another_lens(const Bench& bench, const Config& base) {
  return nearest(base, Direction::both, [&bench](double by) -> std::optional<Change> {
    Bench changed = bench;
    changed.focal_length_mm = rounded_away(by * bench.focal_length_mm, by);
    if (!within(changed.focal_length_mm, limits::kFocalLengthMm)) return std::nullopt;
    return Change{fmt::format("--focal-length {:g}", changed.focal_length_mm),
                  fmt::format("a lens of {:g} mm, or of {:g} mm and {:.3g} times the magnification",
                              changed.focal_length_mm, bench.focal_length_mm,
                              changed.focal_length_mm / bench.focal_length_mm),
                  changed};
  });
}

std::optional<Change> larger_camera(const Bench& bench, const Config& base) {
  return nearest(base, Direction::up, [&bench](double by) -> std::optional<Change> {
    Bench changed = bench;
    changed.sensor_width = kRegionStep * int(std::ceil(by * bench.sensor_width / kRegionStep));
    changed.sensor_height = kRegionStep * int(std::ceil(by * bench.sensor_height / kRegionStep));
    if (std::max(changed.sensor_width, changed.sensor_height) > limits::kRoiSize.max) {
      return std::nullopt;
    }
    return Change{fmt::format("--camera {}x{}@{:g}", changed.sensor_width, changed.sensor_height,
                              bench.camera_pitch_um),
                  fmt::format("a camera of at least {} x {} pixels of {:g} um",
                              changed.sensor_width, changed.sensor_height, bench.camera_pitch_um),
                  changed};
  });
}

std::optional<Change> larger_slm(const Bench& bench, const Config& base) {
  return nearest(base, Direction::up, [&bench](double by) -> std::optional<Change> {
    Bench changed = bench;
    changed.slm.width_px = int(std::ceil(by * bench.slm.width_px));
    changed.slm.height_px = int(std::ceil(by * bench.slm.height_px));
    if (std::max(changed.slm.width_px, changed.slm.height_px) > limits::kSlmSizePx.max) {
      return std::nullopt;
    }
    if (pupil_px(changed) <= pupil_px(bench)) return std::nullopt;  // the beam is the limit
    return Change{fmt::format("--slm {}x{}@{:g}", changed.slm.width_px, changed.slm.height_px,
                              bench.slm.pitch_um),
                  fmt::format("an SLM of at least {} x {} pixels of {:g} um", changed.slm.width_px,
                              changed.slm.height_px, bench.slm.pitch_um),
                  changed};
  });
}

std::optional<Change> wider_beam(const Bench& bench, const Config& base) {
  if (!bench.beam_mm) return std::nullopt;
  const double side_px = std::min(bench.slm.width_px, bench.slm.height_px);
  const double whole_mm = side_px * bench.slm.pitch_um * 1e-3;
  if (*bench.beam_mm >= whole_mm) return std::nullopt;
  return nearest(base, Direction::up, [&bench, whole_mm](double by) -> std::optional<Change> {
    Bench changed = bench;
    // A little more than the SLM's side, so that rounding leaves no pixel dark.
    changed.beam_mm = std::min(rounded_up(by * *bench.beam_mm), 1.001 * whole_mm);
    return Change{fmt::format("--beam {:.4g}", *changed.beam_mm),
                  fmt::format("a beam of at least {:.4g} mm", *changed.beam_mm), changed};
  });
}

/// The change to the modes of `fewer`, which positions determine, or to those that the shapes of
/// kUsualAcross vortices determine, if these are more and fewer than `wanted`.
Change more_by_shapes(Bench fewer, int wanted, const Config& base) {
  Bench more = fewer;
  more.modes = most_modes_by_shapes(kUsualAcross);
  const bool is_between = *more.modes > *fewer.modes && *more.modes < wanted;
  if (is_between && find_config(more, base, Shapes::used)) fewer = more;
  return Change{fmt::format("--modes {}", *fewer.modes),
                fmt::format("at most {} modes", *fewer.modes), fewer};
}

std::optional<Change> fewer_modes(const Bench& bench, const Config& base) {
  if (!bench.modes) return std::nullopt;
  for (int across = kMostAcross; across >= kLeastAcross; across -= 2) {
    Bench changed = bench;
    changed.modes = optimal_mode_count(across);
    if (*changed.modes >= *bench.modes || !works(changed, base)) continue;
    return more_by_shapes(changed, *bench.modes, base);
  }
  return std::nullopt;
}

using Part = std::optional<Change> (*)(const Bench&, const Config&);

/// The bench with one part as good as it can be, for a second change.
std::vector<Change> first_halves(const Bench& bench) {
  std::vector<Change> all;
  const double side_px = std::min(bench.slm.width_px, bench.slm.height_px);
  const double whole_mm = 1.001 * side_px * bench.slm.pitch_um * 1e-3;
  if (bench.beam_mm && *bench.beam_mm < whole_mm) {
    all.push_back({fmt::format("--beam {:.4g}", whole_mm),
                   fmt::format("a beam of at least {:.4g} mm", whole_mm), bench});
    all.back().bench.beam_mm = whole_mm;
  }
  if (bench.modes) {
    const int fewest = std::min(*bench.modes, optimal_mode_count(3));
    all.push_back(
        {fmt::format("--modes {}", fewest), fmt::format("at most {} modes", fewest), bench});
    all.back().bench.modes = fewest;
  }
  return all;
}

}  // namespace

std::vector<Change> changes_that_help(const Bench& bench, const Config& base, Limit limit) {
  std::vector<Part> parts{another_lens, wider_beam, fewer_modes, larger_slm};
  if (limit == Limit::region || limit == Limit::neighbours) parts.push_back(larger_camera);
  std::vector<Change> found;
  for (const Part part : parts) {
    if (auto change = part(bench, base)) found.push_back(std::move(*change));
  }
  if (!found.empty()) return found;
  const auto halves = first_halves(bench);
  std::ranges::copy_if(halves, std::back_inserter(found),
                       [&base](const Change& half) { return works(half.bench, base); });
  if (!found.empty()) return found;
  for (const Change& half : halves) {
    for (const Part part : {another_lens, larger_camera, larger_slm}) {
      auto change = part(half.bench, base);
      if (!change) continue;
      change->options = half.options + " " + change->options;
      change->meaning = half.meaning + ", and " + change->meaning;
      found.push_back(std::move(*change));
    }
  }
  return found;
}

}  // namespace ovws::design
