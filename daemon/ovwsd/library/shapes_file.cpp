#include "daemon/ovwsd/library/shapes_file.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/optics/zernike.hpp"
#include "core/spots/spot_sums.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/limits.hpp"
#include "proto/tables/modes.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr int kMaxWindowSide = 2080, kMaxPlace = 1 << 16;

void demand(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(what);
}

std::string floats_text(const Eigen::MatrixXf& values) {
  return base64_of({values.data(), std::size_t(values.size())});
}

Eigen::MatrixXf floats(const json& text, Eigen::Index rows, Eigen::Index cols) {
  const auto values = floats_of(text.get<std::string>(), std::size_t(rows * cols));
  demand(values.has_value(), "an array has the wrong length");
  Eigen::MatrixXf out = Eigen::Map<const Eigen::MatrixXf>(values->data(), rows, cols);
  demand(out.allFinite(), "an array holds a number that is not finite");
  return out;
}

RenderedSpot spot_from(const json& one, const SpotWindow& size, std::size_t modes) {
  RenderedSpot spot;
  spot.window = size;
  spot.window.left = one.at("left").get<int>();
  spot.window.top = one.at("top").get<int>();
  spot.place_px = {one.at("x").get<double>(), one.at("y").get<double>()};
  demand(size.plane_step() == 1 || size.lit.has(spot.window.left, spot.window.top),
         "a spot's window begins on another colour");
  const auto inside = [](double at) { return at >= 0.0 && at < double(kMaxPlace); };
  demand(inside(spot.window.left) && inside(spot.window.top) && std::isfinite(spot.place_px.x) &&
             std::isfinite(spot.place_px.y),
         "a spot has no place");
  const Eigen::Index cells = spot.window.cells();
  spot.light = floats(one.at("light"), cells, 1);
  spot.per_wave = floats(one.at("per_wave"), cells, Eigen::Index(modes));
  spot.per_px = floats(one.at("per_px"), cells, 2);
  return spot;
}

/// Reads how the modes were poked.
void read_pokes(const json& content, MeasuredShapes& shapes) {
  constexpr double kMinPokeWaves = 1e-4, kMaxFixedWaves = 1000.0;
  shapes.poke_waves = content.at("poke_waves").get<std::vector<double>>();
  demand(shapes.poke_waves.empty() || shapes.poke_waves.size() == shapes.modes_j.size(),
         "it has another number of pokes than of modes");
  for (const double waves : shapes.poke_waves) {
    demand(waves >= kMinPokeWaves && waves <= limits::kPokeWaves.max, "a poke is out of range");
  }
  const json fixed = content.at("fixed");
  demand(fixed.size() <= std::size_t(kMaxZernikeIndex), "it has too many other modes");
  for (const json& one : fixed) {
    const Mode& mode =
        shapes.fixed.emplace_back(Mode{one.at("j").get<int>(), one.at("waves").get<double>()});
    demand(mode.j >= 0 && mode.j <= kMaxZernikeIndex && std::abs(mode.waves) <= kMaxFixedWaves,
           "a mode is out of range");
  }
}

}  // namespace

json lit_content(const LitPixels& lit) {
  return {
      {"step", lit.plane.step}, {"x", lit.plane.x}, {"y", lit.plane.y}, {"diagonal", lit.diagonal}};
}

LitPixels lit_from(const json& content) {
  return {{content.at("step").get<int>(), content.at("x").get<int>(), content.at("y").get<int>()},
          content.at("diagonal").get<bool>()};
}

json shapes_content(const MeasuredShapes& shapes) {
  const SpotWindow& window = shapes.spots.front().window;
  json spots = json::array();
  for (const RenderedSpot& spot : shapes.spots) {
    spots.push_back({{"left", spot.window.left},
                     {"top", spot.window.top},
                     {"x", spot.place_px.x},
                     {"y", spot.place_px.y},
                     {"light", floats_text(spot.light)},
                     {"per_wave", floats_text(spot.per_wave)},
                     {"per_px", floats_text(spot.per_px)}});
  }
  return {{"modes_j", shapes.modes_j},
          {"side", window.side},
          {"bin", window.bin},
          {"lit", lit_content(window.lit)},
          {"poke_waves", shapes.poke_waves},
          {"fixed", to_json(shapes.fixed)},
          {"spots", std::move(spots)}};
}

Result<MeasuredShapes> shapes_from(const json& content, int spots,
                                   const std::vector<int>& leading_j) {
  try {
    MeasuredShapes shapes;
    shapes.modes_j = content.at("modes_j").get<std::vector<int>>();
    const auto& modes_j = shapes.modes_j;
    SpotWindow window{0, 0, content.at("side").get<int>(), content.at("bin").get<int>()};
    demand(window.side >= kMinSide && window.side <= kMaxWindowSide,
           "its windows have an invalid size");
    window.lit = lit_from(content.at("lit"));
    const int largest_bin = window.lit.plane.everything() ? 2 : 1;
    demand(window.lit.exist() && window.bin >= 1 && window.bin <= largest_bin,
           "its windows have invalid pixels");
    demand(modes_j.size() >= leading_j.size() && modes_j.size() <= std::size_t(kMaxZernikeIndex) &&
               std::equal(leading_j.begin(), leading_j.end(), modes_j.begin()) &&
               std::all_of(modes_j.begin(), modes_j.end(),
                           [](int j) { return j >= 1 && j <= kMaxZernikeIndex; }),
           "its modes are not those of the matrix");
    read_pokes(content, shapes);
    demand(spots > 0 && content.at("spots").size() == std::size_t(spots),
           "it has another number of spots");
    for (const json& one : content.at("spots")) {
      shapes.spots.push_back(spot_from(one, window, modes_j.size()));
    }
    return shapes;
  } catch (const std::exception& error) {  // thrown by the JSON library or `demand`
    return fail(Errc::invalid, "shapes", std::string("cannot be used: ") + error.what());
  }
}

}  // namespace ovws
